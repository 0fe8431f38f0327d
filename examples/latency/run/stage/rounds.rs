//! The rounds, as the revoker conducts them.

use std::sync::atomic::Ordering::SeqCst;
use std::time::{Duration, Instant};

use super::{Answer, Cue, Limits, Revoker, Stage};
use crate::run::device::{CALLED_BACK, REGISTER};
use crate::run::measured::Measured;
use crate::run::{Outcome, wakeup};

/// The least pause after a round.
const PAUSE: Duration = Duration::from_micros(100);
/// So few rounds are played even if they take longer than the row's time.
const LEAST: u64 = 8;

impl Stage {
    pub(super) fn conduct(
        &self,
        cue: Cue,
        limits: Limits,
        mut revoker: impl Revoker,
    ) -> Outcome<Measured> {
        let mut measured = Measured::new()?;
        let ends = Instant::now() + limits.time;
        while measured.rounds() < limits.rounds
            && (measured.rounds() < LEAST || Instant::now() < ends)
        {
            let began = Instant::now();
            self.play_round(cue, &mut revoker, &mut measured)?;
            rest_after(began.elapsed())?;
        }
        measured.late = self.late.load(SeqCst);
        Ok(measured)
    }

    fn play_round(
        &self,
        cue: Cue,
        revoker: &mut impl Revoker,
        measured: &mut Measured,
    ) -> Outcome<()> {
        revoker.prepare()?;
        self.quiescent.store(false, SeqCst);
        self.over.store(false, SeqCst);
        self.hog_is_done.store(false, SeqCst);
        let called_back = CALLED_BACK.load(SeqCst);
        self.go.ring();
        self.await_cue(cue, measured.rounds(), revoker)?;
        let caught = self.inside.load(SeqCst);
        let start = Instant::now();
        let answer = revoker.measured()?;
        let took = start.elapsed();
        let register = REGISTER.load(SeqCst);
        let hog_first = self.hog_is_done.load(SeqCst);
        self.quiescent.store(answer == Answer::Done, SeqCst);
        self.over.store(true, SeqCst);
        self.done.wait()?;
        self.failure()?;
        let changed = register != REGISTER.load(SeqCst);
        self.late.fetch_add(u64::from(changed && answer == Answer::Done), SeqCst);
        match cue {
            Cue::AnyInstant => measured.time(took, answer),
            Cue::Inside | Cue::InsideAfterStall => measured.add(took, caught, answer),
        }
        measured.hog_first += u64::from(hog_first);
        // Its thread notices when it runs again.
        if called_back != CALLED_BACK.load(SeqCst) {
            measured.called_back += 1;
            measured.called_back_max = measured.called_back_max.max(took);
        }
        Ok(())
    }

    fn await_cue(&self, cue: Cue, round: u64, revoker: &mut impl Revoker) -> Outcome<()> {
        let one_cpu = self.placement.is_one_cpu();
        if cue == Cue::AnyInstant {
            wakeup::sleep(any_instant(round))?;
            self.hog.ring();
            return if one_cpu { Ok(()) } else { self.told.wait() };
        }
        if cue == Cue::InsideAfterStall {
            self.told.wait()?;
            revoker.meanwhile()?;
            self.resume.ring();
        }
        self.told.wait()?;
        if one_cpu {
            self.hog.ring();
        }
        self.failure()
    }
}

/// Leaves others the CPU for longer than the kernel takes it from real-time
/// threads for them (a twentieth), so that it need not.
fn rest_after(round: Duration) -> Outcome<()> {
    wakeup::sleep(PAUSE.max(round / 8))
}

/// Between 50 and 114 us, spread evenly over any number of rounds: the
/// multiples of the golden ratio.
fn any_instant(round: u64) -> Duration {
    let fraction = round.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 48;
    Duration::from_nanos(50_000 + fraction)
}
