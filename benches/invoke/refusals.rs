//! Every way in which a ticket is refused before it comes to the gate's lock.

use std::hint::black_box;

use faregate::prelude::*;
use faregate::runtime::host::HostStrategy;

use crate::peers::VALUE;
use crate::subjects::{Free, Pass, Stand};
use crate::support::{Contest, Entrant, Failure};

type OnHost = Stand<Free<HostStrategy>, 1>;
type Refused = Pass<Free<HostStrategy>, 1>;

/// One entrant for each way, with its name.
pub(crate) fn enter(contest: &mut Contest<'_>) -> Result<Vec<(&'static str, Entrant)>, Failure> {
    let tickets = [
        ("taken", taken()?),
        ("barred", barred()?),
        ("in safe mode", in_safe_mode()?),
        ("revoked an instant ago", just_revoked()?),
    ];
    let mut entrants = Vec::new();
    for (name, ticket) in tickets {
        if ticket.check().is_ok() {
            return Err(format!("a ticket that was {name} is valid").into());
        }
        let entrant = contest.enter(format!("refused, {name}"), move |n| {
            let value = black_box(VALUE);
            for _ in 0..n {
                // By reference: a copy of the reason would be paid for, too.
                black_box(&ticket.invoke(value));
            }
            assert!(ticket.check().is_err(), "admitted while its refusal was measured");
        });
        entrants.push((name, entrant));
    }
    Ok(entrants)
}

/// A more important ticket has the gate.
fn taken() -> Result<Refused, Failure> {
    let stand = OnHost::free()?;
    let ticket = stand.ticket(Validity::always())?;
    let taker = stand.broker.request(Priority::EMERGENCY, &stand.handle)?;
    stand.broker.service();
    // It keeps the gate for as long as the bench lasts.
    Box::leak(Box::new(taker)).check()?;
    Ok(ticket)
}

fn barred() -> Result<Refused, Failure> {
    let stand = OnHost::free()?;
    let ticket = stand.ticket(Validity::always())?;
    stand.broker.bar(&stand.supervisor, ticket.id())?.quiesce()?;
    stand.broker.service();
    Ok(ticket)
}

/// Safe mode, and service has seen it.
fn in_safe_mode() -> Result<Refused, Failure> {
    let stand = OnHost::free()?;
    let ticket = stand.ticket(Validity::always())?;
    stand.broker.enter_safe_mode(&stand.supervisor, Priority::EMERGENCY)?.quiesce()?;
    stand.broker.service();
    Ok(ticket)
}

/// Safe mode, and service has not been there yet: the ticket is still the
/// gate's tenant, its stamps alone are old.
fn just_revoked() -> Result<Refused, Failure> {
    let stand = OnHost::free()?;
    let ticket = stand.ticket(Validity::always())?;
    stand.broker.enter_safe_mode(&stand.supervisor, Priority::EMERGENCY)?.without_waiting();
    Ok(ticket)
}
