//! Rows of plain locks: what a program without gates would write, as well as it
//! can be done with the lock.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use priority_inheriting_lock::PriorityInheritingLock;

use super::Outcome;
use super::device::REGISTER;
use super::measured::Measured;
use super::stage::{Answer, Cue, Limits, Revoker, Stage, work};

/// How long a spinning thread spins before it gives up. By then the hog would
/// have ended.
pub(crate) const SPINS: Duration = Duration::from_millis(5);

/// A lock around nothing.
pub(crate) trait Lock: Send + Sync {
    fn new() -> Self;

    /// Runs `f` alone, unless it gives up first.
    fn with<R>(&self, f: impl FnOnce() -> R) -> Option<R>;
}

impl Lock for Mutex<()> {
    fn new() -> Self {
        Self::new(())
    }

    fn with<R>(&self, f: impl FnOnce() -> R) -> Option<R> {
        let _alone = self.lock().unwrap_or_else(PoisonError::into_inner);
        Some(f())
    }
}

impl Lock for parking_lot::Mutex<()> {
    fn new() -> Self {
        Self::new(())
    }

    fn with<R>(&self, f: impl FnOnce() -> R) -> Option<R> {
        let _alone = self.lock();
        Some(f())
    }
}

impl Lock for PriorityInheritingLock<()> {
    fn new() -> Self {
        Self::new(())
    }

    fn with<R>(&self, f: impl FnOnce() -> R) -> Option<R> {
        let _alone = self.lock();
        Some(f())
    }
}

/// A lock whose waiters spin.
#[derive(Debug, Default)]
pub(crate) struct Spinning(AtomicBool);

impl Lock for Spinning {
    fn new() -> Self {
        Self::default()
    }

    fn with<R>(&self, f: impl FnOnce() -> R) -> Option<R> {
        let start = Instant::now();
        while self.0.swap(true, SeqCst) {
            if start.elapsed() > SPINS {
                return None;
            }
            std::hint::spin_loop();
        }
        let result = f();
        self.0.store(false, SeqCst);
        Some(result)
    }
}

/// A device that may be commanded while a flag says so, behind a lock.
struct Guarded<L> {
    lock: L,
    valid: AtomicBool,
}

impl<L: Lock> Guarded<L> {
    fn new() -> Self {
        Self { lock: L::new(), valid: AtomicBool::new(false) }
    }
}

/// From clearing the flag until the lock was entered, while the holder is
/// inside a command.
pub(crate) fn inside_command<L: Lock>(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    let guarded = Guarded::<L>::new();
    let command = || {
        let issue = || guarded.valid.load(SeqCst).then(|| stage.command_inside());
        issued(guarded.lock.with(issue).flatten())
    };
    stage.play(Cue::Inside, limits, command, Revoke(&guarded))
}

/// How long a valid command takes while a refused holder is inside its check.
pub(crate) fn inside_check<L: Lock>(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    let guarded = Guarded::<L>::new();
    let check = || {
        let refused = guarded.lock.with(|| {
            stage.check_inside();
            !guarded.valid.load(SeqCst)
        });
        if refused == Some(true) { Ok(()) } else { Err("a revoked command was issued".into()) }
    };
    stage.play(Cue::Inside, limits, check, Overtake(&guarded))
}

fn issued(issued: Option<()>) -> Outcome<()> {
    issued.ok_or_else(|| "a valid command was refused".into())
}

struct Revoke<'a, L>(&'a Guarded<L>);

impl<L: Lock> Revoker for Revoke<'_, L> {
    fn prepare(&mut self) -> Outcome<()> {
        self.0.valid.store(true, SeqCst);
        Ok(())
    }

    fn measured(&mut self) -> Outcome<Answer> {
        self.0.valid.store(false, SeqCst);
        Ok(self.0.lock.with(|| ()).map_or(Answer::GaveUp, |()| Answer::Done))
    }
}

struct Overtake<'a, L>(&'a Guarded<L>);

impl<L: Lock> Revoker for Overtake<'_, L> {
    fn prepare(&mut self) -> Outcome<()> {
        Ok(())
    }

    fn measured(&mut self) -> Outcome<Answer> {
        let command = || REGISTER.store(2, SeqCst);
        Ok(self.0.lock.with(command).map_or(Answer::GaveUp, |()| Answer::Done))
    }
}

/// The paper's bare flag, looked at before each command: from clearing it until
/// it is clear, which is all that its revoker waits for.
pub(crate) fn bare_flag(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    let valid = AtomicBool::new(false);
    let command = || issued(valid.load(SeqCst).then(|| stage.command_inside()));
    stage.play(Cue::Inside, limits, command, Clear(&valid))
}

/// The same at any instant of a holder that commands all the time. Each command
/// works for a microsecond before its store.
pub(crate) fn bare_flag_at_any_instant(stage: &Arc<Stage>, limits: Limits) -> Outcome<Measured> {
    let valid = AtomicBool::new(false);
    let mut number = 0_u32;
    let commands = || {
        while valid.load(SeqCst) && !stage.is_over() {
            work(Duration::from_micros(1), || false);
            number = number.wrapping_add(1);
            REGISTER.store(number, SeqCst);
        }
        Ok(())
    };
    stage.play(Cue::AnyInstant, limits, commands, Clear(&valid))
}

struct Clear<'a>(&'a AtomicBool);

impl Revoker for Clear<'_> {
    fn prepare(&mut self) -> Outcome<()> {
        self.0.store(true, SeqCst);
        Ok(())
    }

    fn measured(&mut self) -> Outcome<Answer> {
        self.0.store(false, SeqCst);
        Ok(Answer::Done)
    }
}
