//! `run`: the stand-alone executive.

mod descriptors;
mod display;
mod host;
mod outside;
mod planned;
mod tally;
mod teller;
mod virtual_clock;
mod virtual_plan;

use crate::args::RunArgs;
use crate::exit::{Exit, Failure};
use crate::schedule;
use teller::Teller;
use virtual_clock::Pace;

pub(crate) fn run(args: &RunArgs) -> Result<Exit, Failure> {
    let (schedule, plan) = match planned::read(&args.files, &args.planned)? {
        Some((schedule, plan)) => (schedule, Some(plan)),
        None => (schedule::read(&args.files)?, None),
    };
    let mut teller = Teller::new(args.format);
    teller.say(&schedule.summary());
    let pace = match (args.speed, args.virtual_clock) {
        (Some(speed), _) => Pace::Times(speed),
        (None, true) => Pace::Free,
        (None, false) => return end(host::run(args, schedule, plan, teller.for_real_time()?)?),
    };
    end(match plan {
        Some(plan) => virtual_plan::run(schedule, plan, pace, args.time, teller)?,
        None => virtual_clock::run(schedule, pace, args.time, teller)?,
    })
}

/// The numbers of the run, and how the program ends with them.
fn end(mut teller: Teller) -> Result<Exit, Failure> {
    let result = teller.result();
    teller.say(&result);
    teller.wanting().map_or(Ok(Exit::Done), |why| Err(Failure::failed(why)))
}
