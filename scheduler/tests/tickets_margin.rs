//! Whatever is asked for in whatever order, the bus never carries more than its
//! supply, no two tasks of one category run together, and no task runs that was
//! not granted its tickets.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]
#![allow(dead_code, reason = "each test uses its own part of the rig")]

#[path = "tickets/rig.rs"]
mod rig;

use std::cell::Cell;
use std::collections::BTreeMap;

use faregate_scheduler::manager::{Event, Needs};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestCaseResult, TestRunner};
use rig::lamp::LAMP;
use rig::{Needing, Rig, SUPPLY, needs};

const LAMPS: [&str; 3] = ["camera", "heater", "radio"];

#[derive(Clone, Debug)]
enum Step {
    Request {
        number: u32,
        priority: u8,
        draw: u32,
        category: u32,
        gates: Vec<usize>,
    },
    /// A body ends, and its tickets go back.
    End(u32),
    /// A body that was told to stop stands still at last.
    Stop,
    Command {
        number: u32,
        lamp: usize,
        on: bool,
    },
    Turn,
    Enter,
    Leave,
}

fn step() -> impl Strategy<Value = Step> {
    let number = || 1..12_u32;
    let gates = prop::collection::vec(0..LAMPS.len(), 0..3);
    prop_oneof![
        6 => (number(), 0..4_u8, 0..40_u32, 0..5_u32, gates).prop_map(
            |(number, priority, draw, category, gates)| {
                Step::Request { number, priority: priority * 60, draw, category, gates }
            }
        ),
        3 => number().prop_map(Step::End),
        4 => Just(Step::Stop),
        6 => (number(), 0..LAMPS.len(), prop::bool::weighted(0.7))
            .prop_map(|(number, lamp, on)| Step::Command { number, lamp, on }),
        8 => Just(Step::Turn),
        1 => Just(Step::Enter),
        1 => Just(Step::Leave),
    ]
}

/// What the test knows of a task, by its own account.
#[derive(Debug)]
struct Body {
    needs: Needs,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Asked,
    Runs,
    Stopping,
    Stopped,
}

struct World {
    rig: Rig,
    bodies: BTreeMap<u32, Body>,
    grants: usize,
    takes: usize,
}

impl World {
    fn apply(&mut self, step: &Step) {
        match step {
            Step::Request { number, priority, draw, category, gates } => {
                let gates: Vec<&str> = gates.iter().map(|gate| LAMPS[*gate]).collect();
                let needs = needs(*priority).drawing(*draw).using(*category).commanding(&gates);
                if !self.bodies.contains_key(number) {
                    // A manager names its victims; the broker finds them, too.
                    self.rig.request(*number, &needs, &[]);
                    self.bodies.insert(*number, Body { needs, state: State::Asked });
                }
            }
            Step::End(number) => {
                if self.bodies.remove(number).is_some() {
                    self.rig.end(*number);
                }
            }
            Step::Stop => {
                let stopping = |(_, body): &(&u32, &mut Body)| body.state == State::Stopping;
                if let Some((number, body)) = self.bodies.iter_mut().find(stopping) {
                    body.state = State::Stopped;
                    self.rig.stop(*number);
                }
            }
            Step::Command { number, lamp, on } => {
                let _ = self.rig.command(*number, LAMPS[*lamp], if *on { "on" } else { "off" });
            }
            Step::Turn => {
                self.rig.turn();
                self.rig.sleep();
                self.hear();
            }
            Step::Enter => self.rig.reserve("eclipse", &LAMPS[..1]),
            Step::Leave => self.rig.unreserve("eclipse"),
        }
    }

    fn hear(&mut self) {
        for event in std::mem::take(&mut self.rig.events) {
            match event {
                Event::Granted { occurrence } => self.granted(occurrence.task.get()),
                Event::Taken { occurrence, .. } => {
                    let number = occurrence.task.get();
                    if let Some(body) = self.bodies.get_mut(&number) {
                        assert_eq!(body.state, State::Runs, "taken from {number}");
                        body.state = State::Stopping;
                        self.takes += 1;
                    }
                }
                Event::Refused { occurrence, .. } => {
                    self.bodies.remove(&occurrence.task.get());
                }
                _ => {}
            }
        }
    }

    fn granted(&mut self, number: u32) {
        let Some(body) = self.bodies.get_mut(&number) else { return };
        assert!(matches!(body.state, State::Asked | State::Stopped), "granted to {number}");
        body.state = State::Runs;
        self.grants += 1;
        self.rig.start(number);
    }

    /// Of the bodies and of the devices themselves.
    fn check(&self) -> TestCaseResult {
        let run = |body: &&Body| matches!(body.state, State::Runs | State::Stopping);
        let running: Vec<&Body> = self.bodies.values().filter(run).collect();
        let own: u64 = running.iter().map(|body| body.needs.draw.get()).sum();
        let lamps = LAMPS.iter().filter(|lamp| self.rig.is_on(lamp)).count() as u64;
        let sum = own + lamps * LAMP.get();
        prop_assert!(sum <= u64::from(SUPPLY) * 1000, "{own} mW of tasks, and {lamps} lamps");
        prop_assert!(self.rig.charged() <= u64::from(SUPPLY), "charged {}", self.rig.charged());
        for (index, one) in running.iter().enumerate() {
            for other in &running[index + 1..] {
                let shared = one.needs.categories.overlaps(other.needs.categories);
                prop_assert!(!shared, "two run in one category: {one:?} {other:?}");
            }
        }
        Ok(())
    }

    /// Everybody goes home.
    fn go_home(&mut self) {
        self.rig.unreserve("eclipse");
        for number in std::mem::take(&mut self.bodies).into_keys() {
            self.rig.end(number);
        }
        self.rig.events.clear();
        self.rig.run(100, &needs(0).drawing(SUPPLY).using(1));
        self.rig.end(100);
        self.rig.until("nothing is charged", |rig| rig.charged() == 0);
    }
}

#[test]
fn the_supply_is_never_exceeded_and_no_category_is_used_twice() {
    const CASES: u32 = 60;
    let (grants, takes) = (Cell::new(0), Cell::new(0));
    let config = Config { cases: CASES, failure_persistence: None, ..Config::default() };
    let histories = prop::collection::vec(step(), 20..120);
    let lived = TestRunner::new(config).run(&histories, |steps| {
        let mut world =
            World { rig: Rig::new(&LAMPS), bodies: BTreeMap::new(), grants: 0, takes: 0 };
        // At boot every device counts as on.
        world.rig.until("the lamps are seen off", |rig| rig.charged() == 0);
        for step in &steps {
            world.apply(step);
            world.check()?;
        }
        world.go_home();
        grants.set(grants.get() + world.grants);
        takes.set(takes.get() + world.takes);
        Ok(())
    });
    if let Err(why) = lived {
        panic!("{why}");
    }
    // What never happened was not tried.
    println!("{} grants, {} of them taken", grants.get(), takes.get());
    assert!(grants.get() > CASES as usize && takes.get() > CASES as usize / 4);
}
