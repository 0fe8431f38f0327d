//! The manager among agents and bodies, every act of it looked at.

use std::collections::{BTreeMap, BTreeSet};

use faregate_scheduler::Mission;
use faregate_scheduler::manager::{
    Action, Addition, Attempt, Event, Exit, Manager, Note, Occurrence, Reply, Telecommand,
    TelecommandId,
};
use faregate_scheduler::mission::AgentSpec;
use faregate_scheduler::task::{Preemption, TaskId, TaskPriority};
use faregate_scheduler::time::{Instant, Now, UnixTime};
use faregate_tickets::amount::Milliwatts;

use crate::model::agents::Agents;
use crate::model::reference::{Body, Does, Known, MEMORY, SUPPLY, Taken, expected};
use crate::model::{Spec, Transition};
use crate::world::id;

pub(crate) struct Bench {
    manager: Manager,
    agents: Agents,
    known: Vec<Known>,
    now: i64,
    slow: bool,
    /// Bodies that were told to stop, and how that ends.
    stops: Vec<Event>,
    started: BTreeSet<Attempt>,
    /// Whose tickets the manager was told of as valid.
    valid: BTreeSet<Occurrence>,
    gaps: Vec<(i64, u128)>,
    /// How often each one-shot was said to be over.
    over: BTreeMap<TaskId, u32>,
    telecommands: u64,
    refused: bool,
}

impl Bench {
    pub(crate) fn new() -> Self {
        let supply = Some(Milliwatts::new(SUPPLY));
        let mission = Mission {
            agents: vec![AgentSpec { name: "tasks".into(), supply }],
            memory: Some(MEMORY),
            waiting_requests: 100,
            ..Mission::default()
        };
        Self {
            manager: Manager::new(mission),
            agents: Agents::default(),
            known: Vec::new(),
            now: 0,
            slow: false,
            stops: Vec::new(),
            started: BTreeSet::new(),
            valid: BTreeSet::new(),
            gaps: Vec::new(),
            over: BTreeMap::new(),
            telecommands: 0,
            refused: false,
        }
    }

    pub(crate) fn apply(&mut self, transition: Transition) {
        match transition {
            Transition::Add(Spec(mut task)) => {
                task.id = id(u32::try_from(self.known.len()).unwrap() + 1);
                let position = self.known.len() as u64;
                self.known.push(Known {
                    task: (*task).clone(),
                    loaded: self.now,
                    position,
                    held: false,
                    last: None,
                    body: None,
                    rerun: None,
                    over: false,
                });
                self.over.insert(task.id, 0);
                self.ask(Telecommand::Add(vec![Addition { task: *task }]));
            }
            Transition::Second => {
                self.now += 1;
                self.gaps.retain(|(until, _)| *until > self.now);
                self.step(vec![]);
                self.skip();
            }
            Transition::Exit(n, succeeds) => self.exit(n, succeeds),
            Transition::Hold(n) => self.with_task(n, |bench, index| {
                bench.known[index].held = true;
                bench.ask(Telecommand::Hold(bench.known[index].task.id));
            }),
            Transition::Resume(n) => self.with_task(n, |bench, index| {
                if std::mem::replace(&mut bench.known[index].held, false) {
                    bench.ask(Telecommand::Resume(bench.known[index].task.id));
                }
            }),
            Transition::Priority(n, level) => self.with_task(n, |bench, index| {
                let priority = TaskPriority::new(level).unwrap();
                bench.known[index].task.priority = priority;
                bench.ask(Telecommand::SetPriority(bench.known[index].task.id, priority));
            }),
            Transition::Remove(n) => self.with_task(n, Self::remove),
            Transition::Bar(n) => {
                let asked = self.agents.asked();
                if let Some(occurrence) = asked.get(n % asked.len().max(1)).copied() {
                    self.agents.bar(occurrence);
                }
            }
            Transition::Unbar => self.agents.unbar(),
            Transition::Slow => self.slow = true,
            Transition::Quick => self.slow = false,
        }
        if !self.slow {
            self.rest();
            self.check();
        }
    }

    /// Everything comes to an end, and nothing was lost on the way.
    pub(crate) fn finish(mut self) {
        self.agents.unbar();
        self.slow = false;
        for index in 0..self.known.len() {
            if std::mem::replace(&mut self.known[index].held, false) && !self.known[index].over {
                self.ask(Telecommand::Resume(self.known[index].task.id));
            }
        }
        // Routine tasks may starve less important ones for good.
        for index in 0..self.known.len() {
            let known = &self.known[index];
            let is_there = self.manager.task(known.task.id).is_some();
            let ends = known.body.as_ref().is_some_and(|body| body.ends);
            if known.task.interval.is_some() && is_there && !ends {
                self.remove(index);
            }
        }
        for _ in 0..60 {
            self.apply(Transition::Second);
            for n in 0..self.known.len() {
                self.exit(n, true);
            }
            self.rest();
            self.check();
        }
        for known in &self.known {
            let times = self.over[&known.task.id];
            if known.task.interval.is_none() {
                assert_eq!(times, 1, "{} was over {times} times", known.task.id);
            }
        }
    }

    fn remove(&mut self, index: usize) {
        let known = &mut self.known[index];
        match &mut known.body {
            Some(body) => body.ends = true,
            None => known.over = true,
        }
        self.ask(Telecommand::Remove(vec![self.known[index].task.id]));
    }

    fn with_task(&mut self, n: usize, act: impl FnOnce(&mut Self, usize)) {
        let there: Vec<_> = (0..self.known.len())
            .filter(|index| {
                let known = &self.known[*index];
                !known.over && known.body.as_ref().is_none_or(|body| !body.ends)
            })
            .collect();
        let there: Vec<_> = there
            .into_iter()
            .filter(|index| self.manager.task(self.known[*index].task.id).is_some())
            .filter(|index| self.over[&self.known[*index].task.id] == 0)
            .collect();
        if let Some(index) = there.get(n % there.len().max(1)).copied() {
            act(self, index);
        }
    }

    fn ask(&mut self, telecommand: Telecommand) {
        self.telecommands += 1;
        self.refused = false;
        let text = format!("{telecommand:?}");
        self.step(vec![Event::Telecommand { id: TelecommandId(self.telecommands), telecommand }]);
        assert!(!self.refused, "{text} was refused");
    }

    /// Occurrences that are due while another one is at work are lost.
    fn skip(&mut self) {
        for known in &mut self.known {
            if known.rerun.is_some_and(|number| !known.may_rerun(number, self.now)) {
                known.last = known.last.max(known.rerun.take());
            }
            if known.body.is_some() || known.rerun.is_some() {
                let due = known.last_due(self.now).unwrap_or(0);
                let now_running = known.body.as_ref().map(|body| body.number).or(known.rerun);
                if Some(due) > now_running {
                    known.last = known.last.max(Some(due));
                }
            }
        }
    }

    fn exit(&mut self, n: usize, succeeds: bool) {
        let alive: Vec<_> = (0..self.known.len())
            .filter(|index| {
                self.known[*index].body.as_ref().is_some_and(|b| b.state != Does::Stands)
            })
            .collect();
        let Some(index) = alive.get(n % alive.len().max(1)).copied() else { return };
        let attempt = self.attempt(index);
        self.stops.retain(|event| {
            !matches!(event, Event::Stopped { attempt: a } | Event::Exited { attempt: a, .. } if *a == attempt)
        });
        let exit = Exit::Code(i32::from(!succeeds));
        self.exited(attempt, exit);
    }

    fn attempt(&self, index: usize) -> Attempt {
        let known = &self.known[index];
        let body = known.body.as_ref().unwrap();
        let occurrence = Occurrence { task: known.task.id, load: 0, number: body.number };
        Attempt { occurrence, number: body.attempt }
    }

    fn index(&self, occurrence: Occurrence) -> usize {
        self.known.iter().position(|known| known.task.id == occurrence.task).unwrap()
    }

    fn exited(&mut self, attempt: Attempt, exit: Exit) {
        let index = self.index(attempt.occurrence);
        self.agents.stopped(attempt.occurrence);
        let known = &mut self.known[index];
        let body = known.body.take().unwrap();
        let pauses = matches!(known.task.preemption, Preemption::Pause);
        let again = body.state == Does::Stops && !body.ends && !pauses;
        if again && known.may_rerun(body.number, self.now) {
            known.rerun = Some(body.number);
        } else {
            known.last = known.last.max(Some(body.number));
            known.over |= body.ends || known.task.interval.is_none();
            if !again && known.task.gap.as_micros() > 0 {
                let gap = i64::try_from(known.task.gap.as_micros() / 1_000_000).unwrap();
                self.gaps.push((self.now + gap, known.task.categories.mask()));
            }
        }
        self.step(vec![Event::Exited { attempt, exit }]);
    }

    /// Agents and bodies say what they have to say, until nothing happens.
    fn rest(&mut self) {
        for _ in 0..1_000 {
            if let Some(event) = self.stops.pop() {
                self.body_says(event);
                continue;
            }
            self.agents.settle();
            let events = std::mem::take(&mut self.agents.events);
            if events.is_empty() {
                return;
            }
            self.step(events);
        }
        panic!("never at rest");
    }

    fn body_says(&mut self, event: Event) {
        match event {
            Event::Stopped { attempt } => {
                let index = self.index(attempt.occurrence);
                if let Some(body) = &mut self.known[index].body {
                    body.state = Does::Stands;
                }
                self.agents.stopped(attempt.occurrence);
                self.step(vec![event]);
            }
            Event::Exited { attempt, exit } => self.exited(attempt, exit),
            _ => unreachable!("bodies say nothing else"),
        }
    }

    fn step(&mut self, events: Vec<Event>) {
        for event in &events {
            match event {
                Event::Granted { occurrence } => drop(self.valid.insert(*occurrence)),
                Event::Taken { occurrence, .. } => drop(self.valid.remove(occurrence)),
                _ => {}
            }
        }
        let us = self.now * 1_000_000;
        let elapsed = Instant::from_micros(u64::try_from(us).unwrap());
        let now = Now { elapsed, wall: UnixTime::from_micros(us) };
        let mut actions = Vec::new();
        println!("{} s: {events:?}", self.now);
        self.manager.step(now, events, &mut actions);
        for action in &actions {
            match action {
                Action::Journal(_) | Action::Sync | Action::Answer { .. } => {}
                Action::Note(note) => println!("    {note}"),
                action => println!("    {action:?}"),
            }
        }
        for action in actions {
            self.act(action);
        }
        for known in &self.known {
            let Some(body) = &known.body else { continue };
            let occurrence = Occurrence { task: known.task.id, load: 0, number: body.number };
            let runs = body.state == Does::Runs;
            assert!(!runs || self.valid.contains(&occurrence), "{occurrence} runs without tickets");
        }
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Request { occurrence, victims } => {
                let needs = self.manager.needs(occurrence).unwrap();
                self.agents.request(occurrence, needs, &victims);
            }
            Action::Relinquish { occurrence } => {
                self.valid.remove(&occurrence);
                self.agents.relinquish(occurrence);
            }
            Action::Start { attempt } => self.start(attempt),
            Action::Continue { attempt } => self.go_on(attempt),
            Action::Stop { attempt, how, .. } => self.stop(attempt, how),
            Action::Answer { reply: Reply::Refused(_), .. } => self.refused = true,
            Action::Note(Note::Ended { occurrence, .. }) => self.count_over(occurrence.task),
            Action::Note(Note::Missed { task, .. }) => self.count_over(task),
            Action::Note(Note::Removed(task)) => {
                // One that ran was said to have ended, too.
                let times = self.over.get_mut(&task).unwrap();
                *times = (*times).max(1);
            }
            Action::Note(Note::NeverRuns { task, .. }) => self.count_over(task),
            _ => {}
        }
    }

    fn count_over(&mut self, task: TaskId) {
        let known = self.known.iter_mut().find(|known| known.task.id == task).unwrap();
        if known.task.interval.is_none() {
            known.over |= known.body.is_none();
            *self.over.get_mut(&task).unwrap() += 1;
        }
    }

    fn start(&mut self, attempt: Attempt) {
        assert!(self.started.insert(attempt), "{attempt} started twice");
        let index = self.index(attempt.occurrence);
        let number = attempt.occurrence.number;
        let known = &self.known[index];
        assert!(known.body.is_none(), "{attempt} has a body already");
        assert!(known.due(number) <= self.now, "{attempt} started too early");
        let again = known.rerun == Some(number);
        let may = if again { Known::may_rerun } else { Known::is_open };
        assert!(may(known, number, self.now), "{attempt} started too late");
        self.fits(index, true);
        let known = &mut self.known[index];
        known.rerun = None;
        known.body = Some(Body { number, attempt: attempt.number, state: Does::Runs, ends: false });
    }

    fn go_on(&mut self, attempt: Attempt) {
        let index = self.index(attempt.occurrence);
        self.fits(index, false);
        let body = self.known[index].body.as_mut().unwrap();
        assert_eq!(body.state, Does::Stands, "{attempt} goes on without having stopped");
        body.state = Does::Runs;
    }

    /// Nobody uses what it needs.
    fn fits(&self, index: usize, starts: bool) {
        let mut taken = Taken::default();
        for (_, categories) in &self.gaps {
            taken.categories |= categories;
        }
        for (other, known) in self.known.iter().enumerate() {
            let Some(body) = known.body.as_ref().filter(|_| other != index) else { continue };
            if body.state == Does::Stands {
                taken.memory += known.task.memory;
            } else {
                taken.take(&known.task, true);
            }
        }
        let task = &self.known[index].task;
        assert!(taken.fits(task, starts), "{} runs beside {taken:?}", task.id);
    }

    fn stop(&mut self, attempt: Attempt, how: faregate_scheduler::manager::Stop) {
        use faregate_scheduler::manager::Stop;
        let index = self.index(attempt.occurrence);
        let Some(body) = self.known[index].body.as_mut() else { return };
        body.state = Does::Stops;
        self.stops.retain(|event| !matches!(event, Event::Stopped { attempt: a } if *a == attempt));
        self.stops.push(match how {
            Stop::Pause => Event::Stopped { attempt },
            _ => Event::Exited { attempt, exit: Exit::Signal(15) },
        });
    }

    /// At rest, who runs is who should.
    fn check(&self) {
        let gaps = self.gaps.iter().fold(0, |all, (_, categories)| all | categories);
        let barred = |task| self.agents.barred.iter().any(|occurrence| occurrence.task == task);
        let expected = expected(&self.known, gaps, barred, self.now);
        let running: BTreeSet<_> = self
            .known
            .iter()
            .filter(|known| known.body.as_ref().is_some_and(|body| body.state == Does::Runs))
            .map(|known| known.task.id)
            .collect();
        assert_eq!(
            running,
            expected,
            "at {} s: {:#?}",
            self.now,
            self.manager.status().collect::<Vec<_>>()
        );
    }
}
