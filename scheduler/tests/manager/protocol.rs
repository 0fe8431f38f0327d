//! What the manager and the agents say to each other.

use faregate_agents::Categories;
use faregate_scheduler::Mission;
use faregate_scheduler::executive::TicketPort;
use faregate_scheduler::manager::{
    Action, Addition, Attempt, Event, Exit, Manager, Needs, Occurrence, Stop, Telecommand,
    TelecommandId, WaitsFor,
};
use faregate_scheduler::mission::DeviceSpec;
use faregate_scheduler::task::{Preemption, Restart, Task, TaskPriority, When};
use faregate_scheduler::time::{Instant, Now};

use crate::world::{With, World, id, seconds, task};

/// A manager whose agents are the test.
struct Bare(Manager, u64);

impl Bare {
    fn of(mission: Mission, tasks: impl IntoIterator<Item = Task>) -> (Self, Vec<Action>) {
        let mut bare = Self(Manager::new(mission), 0);
        let tasks = tasks.into_iter().map(|task| Addition { task }).collect();
        let id = TelecommandId(1);
        let actions = bare.step([Event::Telecommand { id, telecommand: Telecommand::Add(tasks) }]);
        (bare, actions)
    }

    /// One step; what it asks for, without what it writes and tells.
    fn step(&mut self, events: impl IntoIterator<Item = Event>) -> Vec<Action> {
        let mut actions = Vec::new();
        let elapsed = Instant::from_micros(self.1);
        let now = Now { elapsed, ..Now::default() };
        self.0.step(now, events.into_iter().collect(), &mut actions);
        actions.retain(|action| {
            !matches!(
                action,
                Action::Journal(_) | Action::Sync | Action::Note(_) | Action::Answer { .. }
            )
        });
        actions
    }
}

fn of(number: u32) -> Occurrence {
    Occurrence { task: id(number), load: 0, number: 0 }
}

fn attempt(number: u32) -> Attempt {
    Attempt { occurrence: of(number), number: 1 }
}

fn request(number: u32, victims: &[u32]) -> Action {
    let victims = victims.iter().map(|victim| of(*victim)).collect();
    Action::Request { occurrence: of(number), victims }
}

fn granted(number: u32) -> Event {
    Event::Granted { occurrence: of(number) }
}

fn start(number: u32) -> Action {
    Action::Start { attempt: attempt(number) }
}

fn relinquish(number: u32) -> Action {
    Action::Relinquish { occurrence: of(number) }
}

fn taken(number: u32) -> Event {
    Event::Taken { occurrence: of(number), by: "somebody".into() }
}

#[test]
fn nothing_starts_without_granted_tickets() {
    let (mut manager, actions) = Bare::of(Mission::default(), [task(1, 5.0)]);
    assert_eq!(actions, [request(1, &[])]);
    assert_eq!(manager.step([]), []);
    assert_eq!(manager.step([granted(1)]), [start(1)]);
    assert_eq!(manager.step([granted(1)]), [], "once");
}

#[test]
fn a_taker_names_its_victims_and_starts_when_they_have_stopped() {
    let (mut manager, _) = Bare::of(
        Mission::default(),
        [task(1, 50.0).categories(1), task(2, 5.0).categories(3).priority(1).at(5.0)],
    );
    manager.step([granted(1)]);
    manager.1 = 5_000_000;
    assert_eq!(manager.step([]), [request(2, &[1])]);
    let stop = manager.step([taken(1)]);
    assert!(
        matches!(stop[..], [Action::Stop { attempt: a, how: Stop::Pause, .. }] if a == attempt(1))
    );
    assert_eq!(manager.step([granted(2)]), [], "the agents are ahead of the body");
    assert_eq!(manager.step([Event::Stopped { attempt: attempt(1) }]), [start(2)]);
    let ended = Event::Exited { attempt: attempt(2), exit: Exit::Code(0) };
    assert_eq!(manager.step([ended]), [relinquish(2)]);
    assert_eq!(manager.step([granted(1)]), [Action::Continue { attempt: attempt(1) }]);
}

/// It is silent from 5 s on, and takes its grace; at 8 s comes its latest end.
#[test]
fn one_whose_cutoff_comes_while_it_is_ended_for_a_failure_is_not_tried_again() {
    for cutoff in [8.0, 9.0] {
        let first = task(1, 50.0).with(|task| {
            task.heartbeat = Some(seconds(5.0));
            task.preemption = Preemption::Kill { grace: seconds(10.0) };
            task.restart = Restart::OnFailure { limit: 3, back_off: seconds(0.0) };
            task.cutoff = When::AfterLoad(seconds(cutoff));
        });
        let (mut manager, _) = Bare::of(Mission::default(), [first]);
        manager.step([granted(1)]);
        manager.1 = 5_100_000;
        assert!(matches!(manager.step([])[..], [Action::Stop { .. }]));
        manager.1 = 8_500_000;
        assert_eq!(manager.step([]), []);
        let ended = Event::Exited { attempt: attempt(1), exit: Exit::Signal(9) };
        let again =
            if cutoff > 8.5 { vec![relinquish(1), request(1, &[])] } else { vec![relinquish(1)] };
        assert_eq!(manager.step([ended]), again, "{cutoff}");
    }
}

#[test]
fn one_that_cannot_be_pre_empted_asks_at_the_top_and_a_fault_response_kills_it() {
    let waits = task(1, 50.0).priority(3).with(|task| task.preemption = Preemption::Wait);
    let (mut manager, _) = Bare::of(Mission::default(), [waits]);
    assert_eq!(manager.0.needs(of(1)).unwrap().priority, TaskPriority::TOP);
    manager.step([granted(1)]);
    let stop = manager.step([taken(1)]);
    assert!(matches!(stop[..], [Action::Stop { how: Stop::Kill { .. }, .. }]));
}

#[test]
fn who_waits_at_the_agents_for_something_outside_keeps_nothing_from_others() {
    let (mut manager, actions) = Bare::of(
        Mission::default(),
        [task(1, 5.0).categories(1).priority(9), task(2, 5.0).categories(1)],
    );
    assert_eq!(actions, [request(1, &[])]);
    let why = "safe mode".to_owned();
    assert_eq!(
        manager.step([Event::Blocked { occurrence: of(1), why: why.clone() }]),
        [request(2, &[])]
    );
    assert_eq!(manager.0.waits_for(of(1)), Some(WaitsFor::Tickets(why)));
    assert_eq!(manager.step([granted(2)]), [start(2)]);
    // The agents take what it needs from the less important one by themselves.
    manager.step([taken(2), granted(1)]);
    assert_eq!(manager.step([Event::Stopped { attempt: attempt(2) }]), [start(1)]);
}

#[test]
fn one_that_can_never_have_its_tickets_never_runs() {
    let (mut manager, _) = Bare::of(Mission::default(), [task(1, 5.0)]);
    manager.step([Event::Refused { occurrence: of(1), why: "no such gate".into() }]);
    assert!(manager.0.task(id(1)).is_none());
    assert!(manager.0.is_over());
}

#[test]
fn who_is_not_granted_yet_stands_back_for_a_more_important_one() {
    let (mut manager, actions) = Bare::of(
        Mission::default(),
        [task(1, 5.0).categories(1), task(2, 5.0).categories(1).priority(1).at(1.0)],
    );
    assert_eq!(actions, [request(1, &[])]);
    manager.1 = 1_000_000;
    assert_eq!(manager.step([]), [relinquish(1), request(2, &[])]);
    assert_eq!(manager.step([granted(1)]), [], "it was handed back before it came");
    assert_eq!(manager.step([granted(2)]), [start(2)]);
}

#[test]
fn not_more_requests_wait_at_the_agents_than_the_mission_says() {
    let mission = Mission { waiting_requests: 2, ..Mission::default() };
    let tasks =
        [(1, 1), (2, 2), (3, 3), (4, 4), (5, 5)].map(|(id, level)| task(id, 5.0).priority(level));
    let (mut manager, actions) = Bare::of(mission, tasks);
    assert_eq!(actions, [request(5, &[]), request(4, &[])], "the most important ones");
    assert_eq!(manager.0.waits_for(of(3)), Some(WaitsFor::Slot));
    assert_eq!(manager.step([granted(4)]), [start(4), request(3, &[])]);
}

#[test]
fn a_grant_that_cannot_be_used_is_handed_back() {
    let gap = task(1, 5.0).categories(1).with(|task| task.gap = seconds(10.0));
    let (mut manager, _) =
        Bare::of(Mission::default(), [gap.priority(1).at(1.0), task(2, 50.0).categories(1)]);
    manager.step([granted(2)]);
    manager.1 = 1_000_000;
    manager.step([]);
    manager.step([taken(2), Event::Stopped { attempt: attempt(2) }, granted(1)]);
    manager.1 = 6_000_000;
    manager.step([Event::Exited { attempt: attempt(1), exit: Exit::Code(0) }]);
    assert_eq!(manager.step([granted(2)]), [relinquish(2)], "the gap keeps the category");
    manager.1 = 15_000_000;
    assert_eq!(manager.step([]), []);
    manager.1 = 16_000_000;
    assert_eq!(manager.step([]), [request(2, &[])]);
    assert_eq!(manager.step([granted(2)]), [Action::Continue { attempt: attempt(2) }]);
}

#[test]
fn a_pre_emption_that_was_for_nothing_ends_as_soon_as_the_body_has_stopped() {
    let (mut manager, _) = Bare::of(Mission::default(), [task(1, 50.0)]);
    manager.step([granted(1)]);
    manager.step([taken(1)]);
    assert_eq!(manager.step([granted(1)]), []);
    assert_eq!(
        manager.step([Event::Stopped { attempt: attempt(1) }]),
        [Action::Continue { attempt: attempt(1) }]
    );
}

#[test]
fn a_victim_whose_taker_has_gone_is_stopped_by_the_manager_if_it_must_not_run() {
    let (mut manager, _) = Bare::of(
        Mission::default(),
        [task(1, 50.0).categories(1), task(2, 5.0).categories(1).priority(1).at(5.0)],
    );
    manager.step([granted(1)]);
    manager.1 = 5_000_000;
    assert_eq!(manager.step([]), [request(2, &[1])]);
    let commands = [Telecommand::Remove(vec![id(2)]), Telecommand::Hold(id(1))];
    let commands =
        commands.map(|telecommand| Event::Telecommand { id: TelecommandId(2), telecommand });
    let acts = manager.step(commands);
    assert_eq!(acts[..2], [relinquish(2), relinquish(1)]);
    assert!(matches!(acts[2], Action::Stop { how: Stop::Pause, .. }), "{acts:?}");
}

#[test]
fn news_of_what_is_over_changes_nothing() {
    let (mut manager, _) = Bare::of(Mission::default(), [task(1, 5.0)]);
    manager.step([granted(1)]);
    manager.step([Event::Exited { attempt: attempt(1), exit: Exit::Code(0) }]);
    let before = format!("{:?}", manager.0.status().collect::<Vec<_>>());
    let late = [
        granted(1),
        taken(1),
        Event::Stopped { attempt: attempt(1) },
        Event::Exited { attempt: attempt(1), exit: Exit::Code(1) },
        Event::Heartbeat { attempt: attempt(1) },
        Event::Runaway { attempt: attempt(1) },
        Event::Blocked { occurrence: of(1), why: String::new() },
        Event::Refused { occurrence: of(7), why: String::new() },
    ];
    assert_eq!(manager.step(late), []);
    assert_eq!(format!("{:?}", manager.0.status().collect::<Vec<_>>()), before);
}

/// Agents that never answer.
struct Silent;

impl TicketPort for Silent {
    fn request(&mut self, _: Occurrence, _: &Needs, _: &[Occurrence], _: Now) {}
    fn stopped(&mut self, _: Occurrence, _: Now) {}
    fn relinquish(&mut self, _: Occurrence, _: Now) {}
    fn reserve(&mut self, _: &str, _: &[String], _: Now) {}
    fn unreserve(&mut self, _: &str, _: Now) {}
    fn poll(&mut self, _: Now, _: &mut Vec<Event>) {}
    fn next_due(&self) -> Option<Instant> {
        None
    }
}

#[test]
fn a_window_that_closes_while_the_tickets_are_asked_for_ends_the_request() {
    let mut world = World::new(Mission::default());
    world.tickets = Box::new(Silent);
    world.add([task(1, 5.0).closes(10.0)]);
    world.until(20.0);
    assert_eq!(world.log.lines, ["10.000 task 1 missed occurrence 0: its window closed"]);
}

/// A camera whose gate is faulted keeps nobody waiting who does not need it,
/// however many do.
#[test]
fn who_waits_for_what_is_out_of_order_leaves_places_to_others() {
    let camera = DeviceSpec {
        name: "camera".into(),
        kind: "camera".into(),
        agent: "tasks".into(),
        draw: None,
        categories: Categories::NONE,
        parameters: Default::default(),
    };
    let mission = Mission { devices: vec![camera], ..Mission::default() };
    let pictures = (1..=60).map(|n| {
        let task = task(n, 5.0).priority(5);
        task.with(|task| task.gates = vec!["camera".into()])
    });
    let (mut manager, mut actions) = Bare::of(mission, pictures.chain([task(99, 5.0).at(5.0)]));
    let mut asked = 0;
    while let [Action::Request { occurrence, .. }] = actions[..] {
        asked += 1;
        actions = manager.step([Event::Blocked { occurrence, why: "it is faulted".into() }]);
    }
    assert_eq!(actions, []);
    assert!(asked > 1, "it may be for one of them only");
    manager.1 = 5_000_000;
    assert_eq!(manager.step([]), [request(99, &[])]);
    let waits = manager.0.waits_for(of(60)).unwrap().to_string();
    assert_eq!(waits, "tickets: it is faulted");
}
