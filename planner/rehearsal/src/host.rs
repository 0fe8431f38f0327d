//! The host of a control thread: the rover, the agents, and the clock between
//! them.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use faregate_devices_sim::SimClock;
use faregate_devices_sim::rover::{Rover, RoverTruth};
use faregate_planner::execute::{Control, Event};
use faregate_planner::state::{Mode, Window};
use faregate_planner::trace::{Entry, Happened, Trace, Why};
use faregate_planner::units::{Span, Time};
use faregate_planner::{ActivityId, TimedPlan};
use faregate_tickets::amount::Milliwatts;
use faregate_tickets::clock::{Clock, Duration, Instant};

use crate::draws::Draws;
use crate::station::{Seat, Station, SwitchTicket};
use crate::{LEAD, NotRehearsed, Planner, Setup, model};

/// How many events at one instant are too many.
const MOST_EVENTS: usize = 10_000;

pub(crate) struct Host<'h, 'b, 'g> {
    pub(crate) setup: &'h Setup,
    pub(crate) rover: Rover,
    pub(crate) clock: SimClock,
    pub(crate) station: Station<'b, 'g>,
    pub(crate) control: Control,
    pub(crate) draws: Draws,
    watch: &'h mut dyn FnMut(&Entry),
    pub(crate) trace: Trace,
    pub(crate) events: VecDeque<Event>,
    pub(crate) seats: BTreeMap<ActivityId, Held<'b, 'g>>,
    /// Those that no place was free for: they ask again.
    pub(crate) unseated: BTreeSet<ActivityId>,
    pub(crate) windows: BTreeMap<usize, Seat<'b, 'g>>,
    pub(crate) heaters: BTreeMap<usize, Heater<'b, 'g>>,
    pub(crate) computer: Computer<'b, 'g>,
    /// Somebody else's tickets, by the place of the mishap in the script.
    pub(crate) others: BTreeMap<usize, Option<Seat<'b, 'g>>>,
    /// The windows as the communication behaviour has them.
    pub(crate) known: Vec<Window>,
    last_truth: Option<RoverTruth>,
    /// What something draws that nobody planned.
    pub(crate) leak: Milliwatts,
}

/// The tickets of an activity.
pub(crate) struct Held<'b, 'g> {
    pub(crate) seat: Seat<'b, 'g>,
    /// Its sequence was started.
    pub(crate) started: bool,
}

/// The ticket of a heater that is to be on.
pub(crate) struct Heater<'b, 'g> {
    pub(crate) ticket: SwitchTicket<'b, 'g>,
    pub(crate) on: bool,
}

/// The computer's tickets: for its switch, and for what it draws in its phase.
#[derive(Default)]
pub(crate) struct Computer<'b, 'g> {
    pub(crate) ticket: Option<SwitchTicket<'b, 'g>>,
    pub(crate) phase: Option<Seat<'b, 'g>>,
    /// A wakeup or a shutdown that waits for its ticket, and how long it takes.
    pub(crate) pending: Option<(Mode, Span)>,
}

impl<'h, 'b, 'g> Host<'h, 'b, 'g> {
    pub(crate) fn new(
        setup: &'h Setup,
        rover: Rover,
        clock: SimClock,
        station: Station<'b, 'g>,
        first: TimedPlan,
        watch: &'h mut dyn FnMut(&Entry),
    ) -> Self {
        let (plan, parameters) = setup.believed();
        let state = setup.state.clone();
        let planned = Happened::Planned {
            why: vec![Why::First],
            state: Box::new(state.clone()),
            timed: Box::new(first.clone()),
        };
        let trace = Trace {
            begin: state.now,
            end: plan.end,
            is_static: !setup.options.replans,
            charge_lag: charge_lag(setup),
            charge_noise: setup.senses.charge_noise,
            charge_holds: Some(setup.options.charge_holds),
            windows: state.windows.clone(),
            entries: Vec::new(),
        };
        let mut host = Self {
            rover,
            clock,
            station,
            draws: setup.draws.clone(),
            watch,
            trace,
            events: VecDeque::new(),
            seats: BTreeMap::new(),
            unseated: BTreeSet::new(),
            windows: BTreeMap::new(),
            heaters: BTreeMap::new(),
            computer: Computer::default(),
            others: BTreeMap::new(),
            known: state.windows.clone(),
            last_truth: None,
            leak: Milliwatts::ZERO,
            control: Control::new(plan, parameters, state, first, setup.options),
            setup,
        };
        host.note(planned);
        host
    }

    pub(crate) fn run(mut self, planner: &mut dyn Planner) -> Result<Trace, NotRehearsed> {
        self.begin();
        loop {
            self.settle(planner)?;
            self.note_truth();
            if self.control.is_over() {
                break;
            }
            let next = self.next().ok_or(NotRehearsed::StandsStill)?;
            self.clock.advance_to(next);
        }
        let truth = self.rover.truth();
        self.note(Happened::Truth(crate::record::truth(&truth)));
        self.trace.end = self.now();
        self.trace.windows = self.known.clone();
        Ok(self.trace)
    }

    /// Everything that happens at this instant, and what follows from it.
    fn settle(&mut self, planner: &mut dyn Planner) -> Result<(), NotRehearsed> {
        let mut ticked = false;
        for _ in 0..MOST_EVENTS {
            self.station.sense();
            self.station.service();
            self.poll();
            let event = match self.events.pop_front() {
                Some(event) => event,
                None if !ticked => {
                    ticked = true;
                    Event::Tick
                }
                None => return Ok(()),
            };
            if self.is_stale(&event) {
                continue;
            }
            let actions = self.control.step(self.now(), event);
            for action in actions {
                self.perform(action, planner)?;
            }
        }
        Err(NotRehearsed::StandsStill)
    }

    /// A grant that was given back before anybody heard of it: what was asked for
    /// since is another one.
    fn is_stale(&self, event: &Event) -> bool {
        let Event::Granted(id) = event else { return false };
        let held = self.seats.get(id);
        !held.is_some_and(|held| !held.started && held.seat.is_granted())
    }

    /// When something happens next: whole milliseconds, after now.
    fn next(&mut self) -> Option<Instant> {
        let now = self.clock.now();
        let of_agents = self.station.service();
        let of_control = self.control.due().map(|at| model::instant(self.setup, at));
        let candidates = [of_agents, of_control, self.rover.next_event()]
            .into_iter()
            .chain([self.station.next_sensed(), self.next_of_script()])
            .flatten();
        let whole = candidates.map(whole_milliseconds);
        let least = Instant::from_micros(now.as_micros().saturating_add(1));
        whole.map(|at| at.max(whole_milliseconds(least))).min()
    }

    pub(crate) fn now(&self) -> Time {
        model::time(self.setup, self.clock.now())
    }

    pub(crate) fn note(&mut self, what: Happened) {
        let entry = Entry { at: self.now(), what };
        (self.watch)(&entry);
        self.trace.entries.push(entry);
    }

    fn note_truth(&mut self) {
        let truth = self.rover.truth();
        let key = |truth: &RoverTruth| (truth.load, truth.peak, truth.engines);
        if self.last_truth.as_ref().map(key) != Some(key(&truth)) {
            let noted = crate::record::truth(&truth);
            self.note(Happened::Truth(noted));
            self.last_truth = Some(truth);
        }
    }
}

/// How late what is known of the charge can be: from one measurement to the
/// next, and until that one has arrived. Where the sensors are silent, as long as
/// the last one is believed.
fn charge_lag(setup: &Setup) -> Span {
    let senses = &setup.senses;
    let ms = |time: Duration| i64::try_from(time.as_micros() / 1_000).unwrap_or(i64::MAX);
    let holds = if setup.script.is_ever_silent() { setup.options.charge_holds.get() } else { 0 };
    Span::new(ms(senses.period).max(holds).saturating_add(ms(senses.lag)))
}

fn whole_milliseconds(at: Instant) -> Instant {
    let us = at.as_micros().saturating_sub(LEAD.as_micros());
    Instant::from_micros(us.div_ceil(1_000).saturating_mul(1_000)).after(LEAD)
}
