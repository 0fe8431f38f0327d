//! The tickets of the virtual executive keep to what a ticket port promises.

use faregate_agents::Categories;
use faregate_scheduler::TaskId;
use faregate_scheduler::executive::{TicketPort, VirtualTickets};
use faregate_scheduler::manager::{Event, Needs, Occurrence};
use faregate_scheduler::task::TaskPriority;
use faregate_scheduler::time::{Duration, Now};
use faregate_tickets::amount::Milliwatts;

fn occurrence(task: u32) -> Occurrence {
    Occurrence { task: TaskId::new(task).unwrap(), load: 0, number: 0 }
}

fn needs(mask: u128, priority: u8, gate: &str) -> Needs {
    Needs {
        priority: TaskPriority::new(priority).unwrap(),
        categories: Categories::from_mask(mask),
        draw: Milliwatts::ZERO,
        gates: vec![gate.into()],
        grace: Duration::ZERO,
    }
}

/// The port at one instant, by the numbers of tasks.
#[derive(Default)]
struct Desk(VirtualTickets);

impl Desk {
    fn request(&mut self, task: u32, needs: &Needs, victims: &[u32]) {
        let victims: Vec<_> = victims.iter().map(|victim| occurrence(*victim)).collect();
        self.0.request(occurrence(task), needs, &victims, Now::default());
    }

    fn hears(&mut self) -> Vec<String> {
        let mut events = Vec::new();
        self.0.poll(Now::default(), &mut events);
        let said = events.into_iter().map(|event| match event {
            Event::Granted { occurrence } => format!("{} granted", occurrence.task),
            Event::Taken { occurrence, by } => format!("{} taken by {by}", occurrence.task),
            other => format!("{other:?}"),
        });
        said.collect()
    }
}

#[test]
fn a_taker_is_granted_when_its_victims_have_stopped_and_not_before() {
    let mut desk = Desk::default();
    desk.request(1, &needs(0b01, 1, "a"), &[]);
    desk.request(2, &needs(0b10, 1, "b"), &[]);
    assert_eq!(desk.hears(), ["task 1 granted", "task 2 granted"]);
    desk.request(3, &needs(0b11, 9, "c"), &[1, 2]);
    assert_eq!(desk.hears(), ["task 1 taken by task 3", "task 2 taken by task 3"]);
    desk.0.stopped(occurrence(1), Now::default());
    assert_eq!(desk.hears(), [""; 0]);
    desk.0.stopped(occurrence(2), Now::default());
    assert_eq!(desk.hears(), ["task 3 granted"]);
}

#[test]
fn victims_are_granted_again_in_their_order_without_asking() {
    let mut desk = Desk::default();
    desk.request(1, &needs(1, 1, "a"), &[]);
    desk.hears();
    desk.request(2, &needs(1, 3, "b"), &[1]);
    desk.0.stopped(occurrence(1), Now::default());
    desk.hears();
    desk.request(3, &needs(1, 2, "c"), &[]);
    assert_eq!(desk.hears(), [""; 0]);
    desk.0.relinquish(occurrence(2), Now::default());
    assert_eq!(desk.hears(), ["task 3 granted"]);
    desk.0.relinquish(occurrence(3), Now::default());
    assert_eq!(desk.hears(), ["task 1 granted"]);
}

/// The schedule's order is finer than priorities: a victim can be of the same.
#[test]
fn a_victim_of_the_same_priority_stands_behind_its_taker() {
    let mut desk = Desk::default();
    desk.request(1, &needs(1, 5, "a"), &[]);
    desk.hears();
    desk.request(2, &needs(1, 5, "b"), &[1]);
    desk.hears();
    desk.0.stopped(occurrence(1), Now::default());
    assert_eq!(desk.hears(), ["task 2 granted"]);
    desk.0.relinquish(occurrence(2), Now::default());
    assert_eq!(desk.hears(), ["task 1 granted"]);
}

/// As the agents have it: see the tests of the real port.
#[test]
fn a_victim_that_somebody_else_has_taken_already_keeps_its_turn() {
    let mut desk = Desk::default();
    desk.request(1, &needs(1, 5, "a"), &[]);
    desk.hears();
    desk.request(2, &needs(1, 9, "b"), &[1]);
    desk.request(3, &needs(1, 5, "c"), &[1]);
    desk.0.stopped(occurrence(1), Now::default());
    assert_eq!(desk.hears(), ["task 1 taken by task 2", "task 2 granted"]);
    desk.0.relinquish(occurrence(2), Now::default());
    assert_eq!(desk.hears(), ["task 1 granted"]);
}

/// The first victim shares only a draw with its taker, which is not counted.
#[test]
fn a_victim_is_not_granted_again_before_its_taker() {
    let mut desk = Desk::default();
    desk.request(1, &needs(0, 5, "a"), &[]);
    desk.request(2, &needs(1, 5, "b"), &[]);
    desk.hears();
    desk.request(3, &needs(1, 5, "c"), &[1, 2]);
    assert_eq!(desk.hears(), ["task 1 taken by task 3", "task 2 taken by task 3"]);
    desk.0.stopped(occurrence(1), Now::default());
    assert_eq!(desk.hears(), [""; 0]);
    desk.0.stopped(occurrence(2), Now::default());
    assert_eq!(desk.hears(), ["task 3 granted", "task 1 granted"]);
}

#[test]
fn one_gate_has_one_tenant() {
    let mut desk = Desk::default();
    desk.request(1, &needs(0, 1, "camera"), &[]);
    desk.request(2, &needs(0, 1, "camera"), &[]);
    desk.request(3, &needs(0, 1, "gimbal"), &[]);
    assert_eq!(desk.hears(), ["task 1 granted", "task 3 granted"]);
}

#[test]
fn a_mode_takes_its_gates_and_gives_them_back() {
    let mut desk = Desk::default();
    desk.request(1, &needs(0, 1, "camera"), &[]);
    desk.request(2, &needs(0, 1, "gimbal"), &[]);
    desk.hears();
    desk.0.reserve("quiet", &["camera".into()], Now::default());
    assert_eq!(desk.hears(), ["task 1 taken by mode quiet"]);
    desk.0.stopped(occurrence(1), Now::default());
    assert_eq!(desk.hears(), [""; 0]);
    desk.0.unreserve("quiet", Now::default());
    assert_eq!(desk.hears(), ["task 1 granted"]);
}
