//! A manager's thread in miniature: it starts and stops bodies, and waits for
//! what becomes of them as an executive does.

use std::time;

use faregate_scheduler::bodies::{RealBodies, Settings, Surroundings};
use faregate_scheduler::executive::{Bodies, StartBody, Waker};
use faregate_scheduler::manager::{Attempt, Event, Exit, Occurrence, Stop, StopWhy};
use faregate_scheduler::task::{Body, Task, TaskId};
use faregate_scheduler::time::{Duration, Instant, Now};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// Nothing here takes this long. Who waits longer waits in vain.
const PATIENCE: time::Duration = time::Duration::from_secs(60);

pub(crate) struct Bench {
    pub(crate) bodies: RealBodies,
    waker: Waker,
    begun: time::Instant,
    next: u32,
    told: Vec<Event>,
}

/// With and without control groups. A host may permit none; then both are the
/// same, and the test says so.
pub(crate) fn both_ways(check: impl Fn(Bench)) {
    for control_groups in [true, false] {
        let bench = Bench::new(Settings { control_groups, ..Settings::default() });
        match bench.bodies.control_group() {
            Ok(_) => println!("with control groups"),
            Err(why) => println!("without control groups: {why}"),
        }
        check(bench);
    }
}

pub(crate) fn shell(script: &str) -> Body {
    Body::Process { program: "/bin/sh".into(), arguments: vec!["-c".into(), script.into()] }
}

impl Bench {
    pub(crate) fn new(settings: Settings) -> Self {
        Self::around(settings, Surroundings::default())
    }

    pub(crate) fn around(settings: Settings, around: Surroundings) -> Self {
        let waker = Waker::new().unwrap();
        let bodies = RealBodies::new(settings, waker.clone(), around).unwrap();
        Self { bodies, waker, begun: time::Instant::now(), next: 1, told: Vec::new() }
    }

    pub(crate) fn now(&self) -> Now {
        let elapsed = u64::try_from(self.begun.elapsed().as_micros()).unwrap();
        Now { elapsed: Instant::from_micros(elapsed), ..Now::default() }
    }

    pub(crate) fn start(&mut self, body: Body) -> Attempt {
        self.start_for(body, Duration::ZERO)
    }

    pub(crate) fn start_for(&mut self, body: Body, duration: Duration) -> Attempt {
        let id = TaskId::new(self.next).unwrap();
        self.next += 1;
        let task = Task { duration, ..Task::new(id, body) };
        let occurrence = Occurrence { task: id, load: 0, number: 3 };
        let attempt = Attempt { occurrence, number: 2 };
        let now = self.now();
        self.bodies.start(StartBody { attempt, task: &task, now });
        attempt
    }

    pub(crate) fn stop(&mut self, attempt: Attempt, how: Stop) {
        let why = StopWhy::Preempted { by: "task 9".into() };
        let now = self.now();
        self.bodies.stop(attempt, how, &why, now);
    }

    pub(crate) fn resume(&mut self, attempt: Attempt) {
        let now = self.now();
        self.bodies.resume(attempt, now);
    }

    /// Waits as an executive does: on the descriptors and until the next due
    /// instant, never at intervals.
    pub(crate) fn turn(&mut self) {
        let due = self.bodies.next_due();
        let wait = due.map_or(PATIENCE, |due| {
            let now = self.now().elapsed;
            if due <= now { time::Duration::ZERO } else { due.since(now).into() }
        });
        let wait = Timespec::try_from(wait.min(PATIENCE)).unwrap();
        let mut fds =
            [PollFd::new(&self.bodies, PollFlags::IN), PollFd::new(&self.waker, PollFlags::IN)];
        let woken = poll(&mut fds, Some(&wait));
        let _ = self.waker.take();
        assert!(woken != Ok(0) || due.is_some(), "nothing has happened: {:?}", self.told);
        let now = self.now();
        self.bodies.poll(now, &mut self.told);
    }

    /// Waits for the first event that `wanted` gives something for. Others are
    /// kept.
    pub(crate) fn wait<T>(&mut self, mut wanted: impl FnMut(&Event) -> Option<T>) -> T {
        let begun = time::Instant::now();
        loop {
            let found =
                self.told.iter().enumerate().find_map(|(i, event)| Some((i, wanted(event)?)));
            if let Some((index, value)) = found {
                self.told.remove(index);
                return value;
            }
            assert!(begun.elapsed() < PATIENCE, "in vain: {:?}", self.told);
            self.turn();
        }
    }

    pub(crate) fn exit(&mut self, of: Attempt) -> Exit {
        self.wait(|event| match event {
            Event::Exited { attempt, exit } if *attempt == of => Some(exit.clone()),
            _ => None,
        })
    }

    /// Rings the manager's bell, as a port does.
    pub(crate) fn ring(&self) {
        self.waker.wake();
    }

    pub(crate) fn has_told(&self, of: Attempt) -> bool {
        let is_exit =
            |event: &Event| matches!(event, Event::Exited { attempt, .. } if *attempt == of);
        self.told.iter().any(is_exit)
    }

    pub(crate) fn stopped(&mut self, of: Attempt) {
        self.wait(|event| (*event == Event::Stopped { attempt: of }).then_some(()));
    }

    pub(crate) fn pause(&mut self, attempt: Attempt) {
        self.stop(attempt, Stop::Pause);
        self.stopped(attempt);
    }

    pub(crate) fn kill(&mut self, attempt: Attempt, grace: Duration) -> Exit {
        self.stop(attempt, Stop::Kill { grace });
        self.exit(attempt)
    }

    /// What the attempt has printed to its standard output, once there is a
    /// line of it.
    pub(crate) fn line(&self, attempt: Attempt) -> String {
        self.printed(attempt, |text| text.contains('\n'))
    }

    /// What the attempt has printed, once it is enough.
    pub(crate) fn printed(&self, attempt: Attempt, enough: impl Fn(&str) -> bool) -> String {
        super::look::until("it prints", || {
            let output = self.bodies.output(attempt)?;
            let text = String::from_utf8(output.stdout.tail).unwrap();
            enough(&text).then_some(text)
        })
    }

    /// Looks at what happened without waiting for anything.
    pub(crate) fn bodies_poll(&mut self) {
        let now = self.now();
        self.bodies.poll(now, &mut self.told);
    }

    pub(crate) fn told(&self) -> &[Event] {
        &self.told
    }
}
