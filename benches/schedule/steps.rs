//! Row 13: a decision, in instructions. What caches and neighbours add to its
//! time is not in them.

use std::cell::RefCell;
use std::rc::Rc;

use crate::count::{Case, Counts, count};
use crate::stream::{KINDS, Kind, Schedule, Stream};
use crate::support::{Bench, Failure, Target};
use crate::world::World;

/// A large schedule and a small one.
const SIZES: [u32; 2] = [100_000, 100];
/// So many events of each kind are counted; what counts is the worst of them.
const TIMES: usize = 8;

/// A stream, and the event of it that is counted next.
struct Stage {
    stream: Stream<World>,
    event: Option<<World as Schedule>::Event>,
    /// Whether what comes of the latest one is still to be done.
    has_happened: bool,
}

impl Stage {
    fn before(&mut self, kind: Kind) {
        if core::mem::take(&mut self.has_happened) {
            self.stream.follow();
        }
        while self.stream.next() != kind {
            self.stream.pass();
        }
        self.event = Some(self.stream.make());
    }

    fn run(&mut self) {
        let event = self.event.take();
        self.stream.schedule.happen(event.unwrap_or_default());
        self.has_happened = true;
    }
}

pub(crate) fn cases() -> Vec<Case> {
    let cases = |size| {
        let stage = Stage { stream: Stream::new(size), event: None, has_happened: false };
        let stage = Rc::new(RefCell::new(stage));
        KINDS.map(|kind| {
            let [before, run] = [(); 2].map(|()| Rc::clone(&stage));
            Case::new(name(kind, size), move || run.borrow_mut().run())
                .after(move || before.borrow_mut().before(kind))
                .times(TIMES)
        })
    };
    SIZES.into_iter().flat_map(cases).collect()
}

fn name(kind: Kind, size: u32) -> String {
    format!("decision among {size}, {}, the most", kind.name())
}

pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let counts = match count() {
        Ok(counts) => counts,
        Err(why) => {
            eprintln!("instructions are not counted: {why}");
            return Ok(());
        }
    };
    let [large, small] = SIZES.map(|size| worst(bench, &counts, size));
    let name = "decision, 100 000 tasks / 100, the most of the worst, instructions";
    bench.figure(13, name, large? / small?, "x", Target::None);
    Ok(())
}

fn worst(bench: &mut Bench, counts: &Counts, size: u32) -> Result<f64, Failure> {
    let mut worst = 0.0_f64;
    for kind in KINDS {
        let name = name(kind, size);
        let steps = counts.of(&name).ok_or_else(|| format!("{name} was not counted"))?;
        worst = worst.max(steps as f64);
    }
    let name = format!("decision among {size}, the most of the worst");
    bench.figure(13, &name, worst, "instructions", Target::None);
    Ok(worst)
}
