//! Which process belongs to which attempt.
//!
//! This program is made the *subreaper*: a process whose parent has died
//! becomes its child. So whatever a task's processes do (fork twice, begin a
//! session of their own, outlive their parents), all of them are descendants of
//! this program, and nobody else is ever looked at.
//!
//! A child that was not started here and whose session is not this program's is
//! such an orphan. It belongs to the attempt that it was seen in before, whose
//! session or control group it is in, or whose mark is in its environment. One with none of
//! these hides where it comes from: a *stray*, which is killed when it is seen.
//! (A program that embeds the schedule manager and starts children of its own
//! keeps them in its own session, or they look like that.)

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use parking_lot::Mutex;
use rustix::process::{PidfdFlags, Signal, pidfd_open, pidfd_send_signal};

use crate::bodies::procfs::{self, Stat};

/// The environment variable that marks what an attempt has started: the run of
/// the manager, a dot, the serial number of the attempt in that run.
pub(super) const MARK: &str = "FAREGATE_RUN";

/// The main processes that were not reaped yet, with what was seen of their
/// kin. One for the whole program, as its children are.
pub(super) static FAMILY: Mutex<BTreeMap<i32, Kin>> = Mutex::new(BTreeMap::new());

/// What was seen of the processes of one attempt.
#[derive(Debug)]
pub(super) struct Kin {
    mark: String,
    group: Option<String>,
    known: BTreeMap<i32, u64>,
    sessions: BTreeSet<i32>,
}

impl Kin {
    /// A main process leads a session of its own, from before its program is
    /// executed.
    pub(super) fn new(main: i32, mark: String, group: Option<String>) -> Self {
        Self { mark, group, known: BTreeMap::new(), sessions: BTreeSet::from([main]) }
    }

    fn claims(&self, orphan: &Stat, mark: Option<&str>, group: &str) -> bool {
        self.known.get(&orphan.pid) == Some(&orphan.start)
            || self.sessions.contains(&orphan.session)
            || mark == Some(&self.mark)
            || self.group.as_deref().is_some_and(|own| Path::new(group).ends_with(own))
    }
}

/// All living descendants of this program, told apart by attempt.
#[derive(Debug, Default)]
pub(super) struct Census {
    by_main: BTreeMap<i32, Vec<Stat>>,
    strays: Vec<Stat>,
    /// Somebody's origin is not to be seen yet.
    unsettled: bool,
}

/// Whom a child of this program belongs to.
enum Origin {
    /// The attempt with this main process.
    Attempt(i32),
    /// Whoever started it: it is in this program's session. Or a manager that
    /// was killed, and whose processes came to us: that is the sweep's affair.
    Another,
    /// It is between two programs, or about to end.
    NotToBeSeen,
    /// It hides.
    Nobody,
}

impl Census {
    /// Looks at all processes of the host; or, where a control group has the
    /// attempt's processes and only who has left it is looked for, at this
    /// program's descendants.
    ///
    /// # Timing
    /// Three system calls for each process of the host; or some more for each
    /// thread of this program and each descendant.
    pub(super) fn take(whole_host: bool) -> Self {
        let me = rustix::process::getpid().as_raw_nonzero().get();
        let family = if whole_host { None } else { procfs::family_of(me) };
        let all = settled(family.unwrap_or_else(procfs::everybody), me);
        let own_session = all.iter().find(|stat| stat.pid == me).map_or(0, |stat| stat.session);
        let tree = Tree::new(&all);
        let mut family = FAMILY.lock();
        let mut census = Self::default();
        for child in tree.children(me) {
            let living = tree.with_descendants(child).into_iter().filter(|stat| !stat.is_dead());
            match origin(&family, child, own_session) {
                Origin::Attempt(main) => census.by_main.entry(main).or_default().extend(living),
                Origin::Another => {}
                Origin::NotToBeSeen => census.unsettled = true,
                Origin::Nobody => census.strays.extend(living),
            }
        }
        census.remember(&mut family, own_session);
        census
    }

    /// Whether everybody was told apart, and nobody hides.
    pub(super) fn is_settled(&self) -> bool {
        self.strays.is_empty() && !self.unsettled
    }

    /// What lives of the attempt with this main process.
    pub(super) fn of(&self, main: i32) -> &[Stat] {
        self.by_main.get(&main).map_or(&[], Vec::as_slice)
    }

    /// Ends who hides where it comes from.
    pub(super) fn kill_strays(&self) {
        for stray in &self.strays {
            signal(stray, Signal::KILL);
        }
    }

    /// A number may be given to another process once its owner is gone: only
    /// who is alive now is kept.
    fn remember(&self, family: &mut BTreeMap<i32, Kin>, own_session: i32) {
        for (main, kin) in family {
            let living = self.of(*main);
            kin.known = living.iter().map(|stat| (stat.pid, stat.start)).collect();
            kin.sessions = living.iter().map(|stat| stat.session).collect();
            kin.sessions.remove(&own_session);
            kin.sessions.insert(*main);
        }
    }
}

fn origin(family: &BTreeMap<i32, Kin>, child: &Stat, own_session: i32) -> Origin {
    if family.contains_key(&child.pid) {
        return Origin::Attempt(child.pid);
    }
    if child.session == own_session {
        return Origin::Another;
    }
    let environment = procfs::environment(child.pid);
    let mark = environment.as_ref().and_then(|environment| procfs::variable(environment, MARK));
    let group = procfs::control_group(child.pid);
    let owner = family.iter().find(|(_, kin)| kin.claims(child, mark, &group));
    match (owner, mark, environment.is_some()) {
        (Some((main, _)), _, _) => Origin::Attempt(*main),
        (None, Some(_), _) => Origin::Another,
        (None, None, _) if child.is_dead() => Origin::Another,
        (None, None, true) => Origin::Nobody,
        (None, None, false) => Origin::NotToBeSeen,
    }
}

/// While everybody was looked at, parents died. Whoever was seen with one that
/// is not there is looked at again: it has another parent now.
fn settled(mut all: Vec<Stat>, me: i32) -> Vec<Stat> {
    let seen: BTreeSet<i32> = all.iter().map(|stat| stat.pid).collect();
    let is_lost = |stat: &Stat| stat.pid != me && stat.parent != 0 && !seen.contains(&stat.parent);
    for stat in all.iter_mut().filter(|stat| is_lost(stat)) {
        *stat = Stat::of(stat.pid).filter(|now| now.start == stat.start).unwrap_or(*stat);
    }
    all
}

/// Processes by parent.
struct Tree<'a>(BTreeMap<i32, Vec<&'a Stat>>);

impl<'a> Tree<'a> {
    fn new(all: &'a [Stat]) -> Self {
        let mut by_parent: BTreeMap<i32, Vec<&Stat>> = BTreeMap::new();
        for stat in all {
            by_parent.entry(stat.parent).or_default().push(stat);
        }
        Self(by_parent)
    }

    fn children(&self, parent: i32) -> &[&'a Stat] {
        self.0.get(&parent).map_or(&[], Vec::as_slice)
    }

    /// It ends: what was read at different moments could name a process its own
    /// ancestor, but none is looked at twice.
    fn with_descendants(&self, root: &Stat) -> Vec<Stat> {
        let mut found = vec![*root];
        let mut seen = BTreeSet::from([root.pid]);
        let mut next = 0;
        while let Some(stat) = found.get(next) {
            let children = self.children(stat.pid);
            found.extend(children.iter().filter(|child| seen.insert(child.pid)).map(|c| **c));
            next += 1;
        }
        found
    }
}

/// Sends a signal to the process that was seen, or to nobody: its number may
/// belong to another one by now.
pub(super) fn signal(seen: &Stat, signal: Signal) {
    let Some(pid) = procfs::pid(seen.pid) else { return };
    let Ok(pidfd) = pidfd_open(pid, PidfdFlags::empty()) else { return };
    // What the descriptor names cannot change any more.
    if seen.is_still_there() {
        let _ = pidfd_send_signal(&pidfd, signal);
    }
}

/// Makes orphans of tasks children of this program, instead of the host's first
/// process.
///
/// # Errors
/// The kernel's.
pub(super) fn adopt_orphans() -> io::Result<()> {
    let me = rustix::process::getpid();
    Ok(rustix::process::set_child_subreaper(Some(me))?)
}
