//! Row 8: what follows a bar. The service that finds it looks at the seats in
//! which it can be, and those grow with the room that the broker has, one in 64.

use std::time::{Duration, Instant};

use faregate_agents::Policy;
use faregate_tickets::id::TicketId;

use crate::stage::{SEATS, Stage, Ticket};
use crate::support::{Bench, Contest, Curve, Entrant, Failure, Series};

const ROUNDS: u32 = 200;

/// A broker with room for `T` tickets, and one ticket.
struct Bars<const T: usize> {
    stage: Stage<T>,
    ticket: Ticket<T>,
}

impl<const T: usize> Bars<T> {
    fn new() -> Result<Self, Failure> {
        let (stage, mut tickets) = Stage::crowded(1, Policy::unlimited(), 1);
        let ticket = tickets.pop().ok_or("there is no ticket")?;
        Ok(Self { stage, ticket })
    }

    /// Bars the ticket, has the service find it, and reinstates it.
    fn round(&self) -> Result<Duration, Failure> {
        let Stage { agents, supervisor, .. } = &self.stage;
        let id: TicketId = self.ticket.id();
        self.ticket.check().map_err(|refusal| format!("not valid before: {refusal}"))?;
        let start = Instant::now();
        agents.bar(supervisor, id)?.without_waiting();
        agents.service();
        let took = start.elapsed();
        if agents.waiting_for(id) != Some(faregate_agents::Waiting::Barred) {
            return Err("the books did not find the bar".into());
        }
        agents.reinstate(supervisor, id)?;
        self.stage.see_off();
        Ok(took)
    }

    fn enter(self, contest: &mut Contest<'_>, failed: &crate::Failed) -> Entrant {
        let failed = failed.clone();
        contest.enter_timed(format!("bar and service, room for {T}"), move |n| {
            (0..n).map(|_| failed.unless(|| self.round())).sum()
        })
    }
}

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let failed = crate::Failed::default();
    let mut contest = bench.contest("bar and service").rounds(ROUNDS.min(bench.rounds()));
    let entrants = [
        (64, Bars::<64>::new()?.enter(&mut contest, &failed)),
        (1_024, Bars::<1_024>::new()?.enter(&mut contest, &failed)),
        (8_192, Bars::<8_192>::new()?.enter(&mut contest, &failed)),
        (SEATS, Bars::<SEATS>::new()?.enter(&mut contest, &failed)),
    ];
    let times = contest.run();
    failed.check()?;
    let title = "From a bar until the books know of it";
    let points = entrants.map(|(room, entrant)| (room as f64, times.of(entrant).p5));
    let curve = Curve::new("bar-room", title, "tickets that there is room for", "ns");
    bench.curve(curve.log_x().log_y().with(Series::new("bar and service", points.to_vec())));
    bench.peers(&times);
    Ok(())
}
