//! Signals to everything that a process has started.
//!
//! A control group is stopped and killed as a whole, by the kernel. Without one
//! (or for who has left it) it is done by looking, signalling, and looking
//! again, until nobody is found twice in a row.

use std::collections::BTreeSet;

use rustix::process::{Signal, kill_process_group};

use super::{Phase, Process};
use crate::bodies::cgroup::Group;
use crate::bodies::family::{Census, signal};
use crate::bodies::procfs::{self, Stat};

impl Process {
    pub(super) fn census(&self) -> Census {
        Census::take(self.group.is_none())
    }

    /// Everything of it that lives, by either list.
    pub(super) fn living(&self, census: &Census) -> Vec<Stat> {
        let mut living = census.of(self.main()).to_vec();
        let seen: BTreeSet<i32> = living.iter().map(|stat| stat.pid).collect();
        let listed = self.group.iter().flat_map(Group::pids);
        living.extend(listed.filter(|pid| !seen.contains(pid)).filter_map(Stat::of));
        living.retain(|stat| !stat.is_dead());
        living
    }

    pub(super) fn signal_all(&self, number: Signal) {
        for stat in self.living(&self.census()) {
            signal(&stat, number);
        }
    }

    /// Stops everything. The group is frozen beside the signal: who begins to
    /// exist meanwhile stands still as well, and nobody but us lets them go on.
    pub(super) fn stop_everything(&mut self) {
        self.signal_main_group(Signal::STOP);
        self.signal_all(Signal::STOP);
        self.freezes = self.group.as_ref().is_some_and(|group| group.freeze(true).is_ok());
    }

    /// Whether nothing of it runs. Who still runs is signalled again.
    pub(super) fn is_still(&mut self) -> bool {
        let frozen = self.frozen();
        let census = self.census();
        census.kill_strays();
        let mut still = census.is_settled() && (!self.freezes || frozen.is_some());
        let frozen = frozen.unwrap_or_default();
        let loose: Vec<Stat> =
            self.living(&census).into_iter().filter(|stat| !frozen.contains(&stat.pid)).collect();
        for stat in loose.iter().filter(|stat| !procfs::stands_still(stat.pid)) {
            signal(stat, Signal::STOP);
            still = false;
        }
        if !still && !self.freezes {
            self.signal_main_group(Signal::STOP);
        }
        let Phase::Stopping { seen_still } = &mut self.phase else { return false };
        let twice = *seen_still || (self.freezes && loose.is_empty());
        *seen_still = still;
        still && twice
    }

    /// Whom the kernel keeps from running; `None`: it does not keep all of the
    /// group yet.
    fn frozen(&self) -> Option<BTreeSet<i32>> {
        let group = self.group.as_ref().filter(|group| self.freezes && group.state().frozen)?;
        Some(group.pids().into_iter().collect())
    }

    /// The signal comes first: a frozen process takes it when it thaws, and one
    /// that was never stopped runs its handler all the same.
    pub(super) fn let_go_on(&mut self) {
        self.signal_all(Signal::CONT);
        if let Some(group) = &self.group {
            let _ = group.freeze(false);
        }
        self.freezes = false;
    }

    pub(super) fn kill_everything(&self) {
        if let Some(group) = &self.group {
            let _ = group.kill();
        }
        self.signal_main_group(Signal::KILL);
        self.signal_all(Signal::KILL);
    }

    /// Whether nothing of it lives. Who does is killed.
    pub(super) fn is_empty(&mut self) -> bool {
        let populated = self.group.as_ref().is_some_and(|group| group.state().populated);
        if let Some(group) = self.group.as_ref().filter(|_| populated) {
            let _ = group.kill();
        }
        let census = self.census();
        census.kill_strays();
        let living = self.living(&census);
        for stat in &living {
            signal(stat, Signal::KILL);
        }
        let empty = living.is_empty() && !populated && census.is_settled();
        if !empty {
            self.signal_main_group(Signal::KILL);
        }
        let Phase::Clearing { seen_empty } = &mut self.phase else { return false };
        let twice = *seen_empty || self.group.is_some();
        *seen_empty = empty;
        empty && twice
    }

    /// The kernel signals a process group at one moment: a fork in progress
    /// does not slip through. Nobody else's group has this number while the
    /// main process is not reaped.
    fn signal_main_group(&self, number: Signal) {
        let _ = kill_process_group(self.pid, number);
    }

    pub(super) fn main(&self) -> i32 {
        self.pid.as_raw_nonzero().get()
    }
}
