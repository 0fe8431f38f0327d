//! The stage: a holder, a hog and a revoker, and how they wake each other.

mod rounds;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};
use std::sync::{Arc, Barrier, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::Outcome;
use super::bell::Bell;
use super::measured::Measured;
use super::rights::{self, HOG, HOLDER, Placement, REVOKER};

/// How long the hog works. On a flight computer nothing says that it ends.
pub(crate) const HOG_WORKS: Duration = Duration::from_millis(3);
/// What is left of a command or check when its thread is pre-empted inside it.
pub(crate) const STILL_TO_DO: Duration = Duration::from_micros(2);

/// When the revoker sets out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cue {
    /// When the holder is inside.
    Inside,
    /// When the holder is inside, after it was held up on its way in, for
    /// [`Revoker::meanwhile`].
    InsideAfterStall,
    /// At any instant: the holder commands all the time.
    AnyInstant,
}

/// How many rounds a row has, and for how long it may play them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) rounds: u64,
    pub(crate) time: Duration,
}

/// What became of a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// What was waited for came.
    Done,
    /// It did not, and who waited gave up.
    GaveUp,
}

/// The part of the revoker.
pub(crate) trait Revoker: Send {
    /// Before a round: the holder's ticket is made valid.
    fn prepare(&mut self) -> Outcome<()>;

    /// While the holder stalls on its way in.
    fn meanwhile(&mut self) -> Outcome<()> {
        Ok(())
    }

    /// What is measured.
    fn measured(&mut self) -> Outcome<Answer>;
}

/// Where a row is played.
#[derive(Debug)]
pub(crate) struct Stage {
    placement: Placement,
    go: Bell,
    hog: Bell,
    told: Bell,
    resume: Bell,
    done: Bell,
    /// The round's measurement is over: the hog need not go on.
    over: AtomicBool,
    /// No round follows.
    ended: AtomicBool,
    /// The hog has done all its work in this round.
    hog_is_done: AtomicBool,
    /// The holder is inside a command or check.
    inside: AtomicBool,
    /// The revoker has been told that the holder is out.
    quiescent: AtomicBool,
    /// Commands that reached the device after that.
    late: AtomicU64,
    failure: Mutex<Option<String>>,
}

impl Stage {
    pub(crate) fn new(placement: Placement) -> Outcome<Arc<Self>> {
        Ok(Arc::new(Self {
            placement,
            go: Bell::new()?,
            hog: Bell::new()?,
            told: Bell::new()?,
            resume: Bell::new()?,
            done: Bell::new()?,
            over: AtomicBool::new(false),
            ended: AtomicBool::new(false),
            hog_is_done: AtomicBool::new(false),
            inside: AtomicBool::new(false),
            quiescent: AtomicBool::new(false),
            late: AtomicU64::new(0),
            failure: Mutex::new(None),
        }))
    }

    pub(crate) fn placement(&self) -> Placement {
        self.placement
    }

    /// The round's measurement is over.
    pub(crate) fn is_over(&self) -> bool {
        self.over.load(SeqCst)
    }

    /// A command of the holder: pre-empted, then finished. Its last instruction
    /// is what the device sees.
    pub(crate) fn command_inside(&self) {
        self.be_preempted();
        // The device itself counts, outside any lock.
        let late = self.quiescent.load(SeqCst);
        self.late.fetch_add(u64::from(late), SeqCst);
        self.inside.store(false, SeqCst);
    }

    /// A check of the holder that will refuse: pre-empted, then finished.
    pub(crate) fn check_inside(&self) {
        self.be_preempted();
        self.inside.store(false, SeqCst);
    }

    /// Wakes a more important thread of this CPU, which pre-empts this one in
    /// the middle of the call.
    fn be_preempted(&self) {
        self.inside.store(true, SeqCst);
        if self.placement.is_one_cpu() {
            self.told.ring()
        } else {
            self.hog.ring()
        }
        work(STILL_TO_DO, || false);
    }

    /// The holder stands between its look at the gate and the gate.
    pub(crate) fn stall(&self) {
        self.told.ring();
        if let Err(failure) = self.resume.wait() {
            self.fail(&failure.to_string());
        }
    }

    /// Ends the row, for a reason.
    pub(crate) fn fail(&self, why: &str) {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.get_or_insert_with(|| why.to_owned());
        drop(failure);
        self.end();
    }

    fn end(&self) {
        self.ended.store(true, SeqCst);
        self.over.store(true, SeqCst);
        for bell in [&self.go, &self.hog, &self.told, &self.resume, &self.done] {
            bell.ring();
        }
    }

    fn failure(&self) -> Outcome<()> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.clone().map_or(Ok(()), |failure| Err(failure.into()))
    }

    /// Plays the rounds: `holder` is what the holder does in each.
    pub(crate) fn play(
        &self,
        cue: Cue,
        limits: Limits,
        holder: impl FnMut() -> Outcome<()> + Send,
        revoker: impl Revoker,
    ) -> Outcome<Measured> {
        let ready = Barrier::new(3);
        let Placement { holder_cpu, revoker_cpu } = self.placement;
        let measured = thread::scope(|scope| {
            let mut threads = vec![
                scope.spawn(|| self.act(&ready, holder_cpu, HOLDER, || self.hold(holder))),
                scope.spawn(|| self.act(&ready, holder_cpu, HOG, || self.be_in_the_way())),
            ];
            let rounds = || self.conduct(cue, limits, revoker);
            let conductor = scope.spawn(|| self.act(&ready, revoker_cpu, REVOKER, rounds));
            let measured = conductor.join().map_err(|_| "the revoker panicked")?;
            let others = threads.drain(..).map(|thread| {
                thread.join().map_err(|_| "the holder or the hog panicked".into()).flatten()
            });
            others.collect::<Outcome<Vec<()>>>()?;
            measured
        });
        self.failure()?;
        measured
    }

    /// One thread's part. However it ends, it ends for all.
    fn act<R>(
        &self,
        ready: &Barrier,
        cpu: usize,
        priority: u8,
        part: impl FnOnce() -> Outcome<R>,
    ) -> Outcome<R> {
        let _ends = Ends(self);
        let permitted = rights::take(cpu, priority);
        ready.wait();
        permitted?;
        part().inspect_err(|failure| self.fail(&failure.to_string()))
    }

    fn hold(&self, mut holder: impl FnMut() -> Outcome<()>) -> Outcome<()> {
        loop {
            self.go.wait()?;
            if self.ended.load(SeqCst) {
                return Ok(());
            }
            holder()?;
            self.done.ring();
        }
    }

    fn be_in_the_way(&self) -> Outcome<()> {
        loop {
            self.hog.wait()?;
            if self.ended.load(SeqCst) {
                return Ok(());
            }
            if !self.placement.is_one_cpu() {
                self.told.ring();
            }
            work(HOG_WORKS, || self.is_over());
            self.hog_is_done.store(!self.is_over(), SeqCst);
        }
    }
}

/// Ends the row when its part does.
struct Ends<'a>(&'a Stage);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.end();
    }
}

/// Works for so long, or until it need not.
pub(crate) fn work(time: Duration, enough: impl Fn() -> bool) {
    let start = Instant::now();
    while start.elapsed() < time && !enough() {
        std::hint::spin_loop();
    }
}
