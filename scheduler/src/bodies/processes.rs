//! All processes of a manager: started, watched through one descriptor, ended.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;

use rustix::event::{PollFd, PollFlags, Timespec, epoll, poll};
use rustix::process::Pid;

use crate::bodies::cgroup::{Group, Groups};
use crate::bodies::children::{self, Bell};
use crate::bodies::family;
use crate::bodies::gauge::Whereabouts;
use crate::bodies::launch::{Order, Prepared, Started};
use crate::bodies::output::{Capture, Output, Scribe};
use crate::bodies::process::{Became, Process};
use crate::bodies::settings::{Moment, Settings};
use crate::bodies::sweep::{Run, Swept};
use crate::executive::{PortFactory, PortNotice};
use crate::manager::{Attempt, Event, Exit, Stop};
use crate::time::{Duration, Instant};

/// The bell of children among the processes' descriptors.
const BELL: u64 = u64::MAX;

/// How often a manager that ends looks whether its processes have, and how long
/// it waits each time for one of them.
const LAST_LOOKS: u32 = 500;
const LOOKS_APART: Duration = Duration::from_millis(10);
const LAST_LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 10_000_000 };

/// The processes of attempts that are not over.
pub(super) struct Processes {
    settings: Settings,
    ports: Box<dyn PortFactory>,
    run: Run,
    epoll: OwnedFd,
    bell: Bell,
    scribe: Scribe,
    live: BTreeMap<Attempt, (u64, Process)>,
    /// Those whose processes are gone, and whose ports are not yet quiet.
    closing: Vec<(Attempt, Exit)>,
    next_serial: u64,
}

impl Processes {
    pub(super) fn new(
        settings: Settings,
        run: Run,
        ports: Box<dyn PortFactory>,
    ) -> io::Result<Self> {
        family::adopt_orphans()?;
        let epoll = epoll::create(epoll::CreateFlags::CLOEXEC)?;
        let bell = Bell::new()?;
        epoll::add(&epoll, &bell, epoll::EventData::new_u64(BELL), epoll::EventFlags::IN)?;
        let scribe = Scribe::new(settings.output_kept)?;
        let (live, closing) = (BTreeMap::new(), Vec::new());
        Ok(Self { settings, ports, run, epoll, bell, scribe, live, closing, next_serial: 0 })
    }

    pub(super) fn groups(&self) -> Result<&Path, &str> {
        self.run.groups.as_ref().map(Groups::path).map_err(String::as_str)
    }

    pub(super) fn also_swept(&mut self, swept: Vec<Swept>) {
        self.run.swept.extend(swept);
    }

    pub(super) fn swept(&self) -> &[Swept] {
        &self.run.swept
    }

    /// # Errors
    /// Why it was not started, for people. Then nothing of it is left.
    pub(super) fn start(
        &mut self,
        attempt: Attempt,
        program: &str,
        arguments: &[String],
    ) -> Result<(), String> {
        let serial = self.next_serial;
        self.next_serial += 1;
        let port = self.ports.open(attempt).map_err(|error| format!("no command port: {error}"))?;
        let mark = self.run.mark(serial);
        let open_files = self.settings.open_files;
        let order = Order { program, arguments, attempt, mark, port, open_files, group: None };
        let process = self.fork(order).inspect_err(|_| self.ports.close(attempt))?;
        self.watch(serial, &process);
        self.live.insert(attempt, (serial, process));
        Ok(())
    }

    fn fork(&mut self, order: Order<'_>) -> Result<Process, String> {
        let program = order.program;
        let group = self.run.groups.as_mut().ok().map(Groups::group).transpose();
        let group = group.map_err(|error| format!("no control group: {error}"))?;
        match self.fork_into(Order { group: group.as_ref(), ..order }) {
            Ok((started, capture)) => Ok(Process::new(program, started, group, capture)),
            Err(why) => {
                self.keep(group);
                Err(why)
            }
        }
    }

    fn fork_into(&mut self, order: Order<'_>) -> Result<(Started, Option<Capture>), String> {
        let attempt = order.attempt;
        let mut prepared = Prepared::new(order)?;
        let capture = prepared.outputs().map(|(out, err)| self.scribe.capture(out, err));
        let capture = capture.transpose().map_err(|error| format!("no output: {error}"))?;
        self.settings.probe.passes(Moment::Fork, attempt);
        let started = prepared.fork();
        self.settings.probe.passes(Moment::Forked, attempt);
        match started {
            Ok(started) => Ok((started, capture)),
            Err(why) => {
                capture.iter().for_each(|capture| drop(capture.finish()));
                Err(why)
            }
        }
    }

    fn keep(&mut self, group: Option<Group>) {
        if let (Ok(groups), Some(group)) = (&mut self.run.groups, group) {
            groups.keep(group);
        }
    }

    /// Where the kernel does not watch it (it has no memory for that), the bell
    /// of children and the times to look again do.
    fn watch(&self, serial: u64, process: &Process) {
        let data = epoll::EventData::new_u64(serial);
        let _ = epoll::add(&self.epoll, process.pidfd(), data, epoll::EventFlags::IN);
        if let Some(events) = process.group_events() {
            // Each change once: a state that nobody wants to know stays unread.
            let changes = epoll::EventFlags::PRI | epoll::EventFlags::ET;
            let _ = epoll::add(&self.epoll, events, data, changes);
        }
    }

    pub(super) fn stop(&mut self, attempt: Attempt, how: Stop, now: Instant) {
        let Some((_, process)) = self.live.get_mut(&attempt) else { return };
        if let Stop::Checkpoint { grace, .. } = how {
            self.ports.tell(attempt, PortNotice::Checkpoint { grace });
        }
        process.stop(how, now);
    }

    pub(super) fn resume(&mut self, attempt: Attempt) {
        if let Some((_, process)) = self.live.get_mut(&attempt) {
            self.ports.tell(attempt, PortNotice::Resumed);
            process.resume();
        }
    }

    /// What has become of them. Outputs of those that are over go to `keep`.
    pub(super) fn poll(
        &mut self,
        now: Instant,
        events: &mut Vec<Event>,
        mut keep: impl FnMut(Attempt, Output),
    ) {
        let ready = self.ready();
        let rung = ready.contains(&BELL);
        let is_concerned = |serial: &u64, process: &Process| {
            rung || ready.contains(serial) || process.due().is_some_and(|due| due <= now)
        };
        let mut over = Vec::new();
        for (attempt, (serial, process)) in &mut self.live {
            if !is_concerned(serial, process) {
                continue;
            }
            match process.attend(now) {
                Became::Same => {}
                Became::Still => events.push(Event::Stopped { attempt: *attempt }),
                Became::Over(exit) => over.push((*attempt, exit)),
            }
        }
        for (attempt, exit) in over {
            if let Some(output) = self.end(attempt) {
                keep(attempt, output);
            }
            self.closing.push((attempt, exit));
        }
        self.tell_quiet(events);
        if rung {
            children::reap_orphans();
        }
    }

    /// An attempt is over when no command of it is in progress any more: the
    /// next attempt has tickets for the same gates.
    fn tell_quiet(&mut self, events: &mut Vec<Event>) {
        let ports = &self.ports;
        let is_quiet = |(attempt, _): &mut (Attempt, Exit)| ports.is_quiet(*attempt);
        let quiet = self.closing.extract_if(.., is_quiet);
        events.extend(quiet.map(|(attempt, exit)| Event::Exited { attempt, exit }));
    }

    /// The first of them to be looked at without being told.
    pub(super) fn next_due(&self) -> Option<Instant> {
        self.live.values().filter_map(|(_, process)| process.due()).min()
    }

    pub(super) fn pid(&self, attempt: Attempt) -> Option<Pid> {
        self.live.get(&attempt).map(|(_, process)| process.pid())
    }

    pub(super) fn whereabouts(&self, attempt: Attempt) -> Option<Whereabouts> {
        self.live.get(&attempt).map(|(_, process)| process.whereabouts())
    }

    pub(super) fn memory(&self, attempt: Attempt) -> Option<u64> {
        self.live.get(&attempt).map(|(_, process)| process.memory())
    }

    pub(super) fn output(&self, attempt: Attempt) -> Option<Output> {
        self.live.get(&attempt).map(|(_, process)| process.printed())
    }

    fn ready(&self) -> BTreeSet<u64> {
        let mut buffer = [const { MaybeUninit::uninit() }; 64];
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        let Ok((ready, _)) = epoll::wait(&self.epoll, &mut buffer, Some(&at_once)) else {
            return BTreeSet::new();
        };
        let ready: BTreeSet<u64> = ready.iter().map(|event| event.data.u64()).collect();
        if ready.contains(&BELL) {
            self.bell.silence();
        }
        ready
    }

    /// Its authority ends before anybody hears of its end.
    fn end(&mut self, attempt: Attempt) -> Option<Output> {
        self.ports.close(attempt);
        let (_, mut process) = self.live.remove(&attempt)?;
        // Not left to the closing: a child between fork and exec has copies of
        // the descriptors, and the kernel would go on to report them.
        let _ = epoll::delete(&self.epoll, process.pidfd());
        if let Some(events) = process.group_events() {
            let _ = epoll::delete(&self.epoll, events);
        }
        self.settings.probe.passes(Moment::Reap, attempt);
        process.reap();
        self.settings.probe.passes(Moment::Reaped, attempt);
        let output = process.printed();
        self.keep(process.take_group());
        Some(output)
    }
}

/// Readable when something has happened to one of them.
impl AsFd for Processes {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.epoll.as_fd()
    }
}

/// A manager that goes leaves nothing behind. It waits for what it has killed,
/// but not for ever: what the kernel does not let die is left to the sweep.
impl Drop for Processes {
    fn drop(&mut self) {
        let mut now = Instant::default();
        for (_, process) in self.live.values_mut() {
            process.stop(Stop::Kill { grace: Duration::ZERO }, now);
        }
        for _ in 0..LAST_LOOKS {
            self.poll(now, &mut Vec::new(), |_, _| {});
            if self.live.is_empty() {
                return self.run.is_over();
            }
            let _ = poll(&mut [PollFd::new(&self.epoll, PollFlags::IN)], Some(&LAST_LOOK));
            now = now.after(LOOKS_APART);
        }
    }
}
