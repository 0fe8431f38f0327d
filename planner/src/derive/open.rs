//! A world's phases in progress: what a sweep knows in one, found again from
//! what the world says, so that another sweep can begin or end there.

use crate::energy::Cursor;
use crate::problem::Problem;
use crate::state::Mode;

use super::mark::{Open, Phase, Up};
use super::placed::{Need, Placed};
use super::var::Var;
use super::world::World;

impl World {
    /// In the last phase in which something is met that is needed before an
    /// instant: as late as everything is as if nothing followed.
    pub(crate) fn open_before(
        &self,
        problem: &Problem,
        placed: &Placed,
        change: i64,
    ) -> Option<Open> {
        let met = placed.needs.partition_point(|need| need.from < change);
        let (phase, begun, until) = self.phase_of(problem, placed, met)?;
        let earliest = until.max(begun.counted.at + problem.computer.min_awake);
        let it = &self.phases[phase];
        // The world may have what is being made longer, which begins then.
        let last = (change - 1).min(earliest).min(it.down.at - 1);
        let piece = &self.pieces[self.at(last)];
        if piece.from < it.up.at || piece.from > last {
            return None;
        }
        let steps = placed.steps.partition_point(|step| step.at <= piece.from);
        let cursor = Cursor::at(piece, problem.computer.awake, problem, steps);
        Some(Open { begun, until: Var::fixed(until), cursor, met, phases: phase })
    }

    /// Whether it has an open phase like that.
    pub(crate) fn has_open(
        &self,
        problem: &Problem,
        placed: &Placed,
        open: &Open,
        long: bool,
    ) -> bool {
        let found = self.phase_of(problem, placed, open.met);
        found.is_some_and(|(_, begun, until)| {
            let long_here = begun.counted.at + problem.computer.min_awake <= until;
            let as_long = long && long_here || begun.counted == open.begun.counted;
            as_long && open.until == Var::fixed(until)
        })
    }

    /// The phase in which the last of so many needs is met, how it began, and
    /// until when they keep it up.
    fn phase_of(&self, problem: &Problem, placed: &Placed, met: usize) -> Option<(usize, Up, i64)> {
        if !problem.blocks.is_empty() || !self.late.is_empty() {
            return None;
        }
        let met = placed.needs.get(..met)?;
        let last = met.last()?;
        let before = self.phases.partition_point(|phase| phase.up.at <= last.from);
        let place = before.checked_sub(1)?;
        let phase = &self.phases[place];
        let in_it = met.iter().rev().take_while(|need| need.from >= phase.up.at);
        let until = in_it.map(|need: &Need| need.to).fold(phase.up.at, i64::max);
        Some((place, begun(problem, place, phase), until))
    }
}

/// What is up already counts from when it came up.
fn begun(problem: &Problem, place: usize, phase: &Phase) -> Up {
    let is_present = place == 0 && problem.computer.mode == Mode::Awake;
    let counted = if is_present { Var::fixed(problem.computer.since) } else { phase.up };
    Up { wakeup: phase.wakeup, up: phase.up, counted }
}
