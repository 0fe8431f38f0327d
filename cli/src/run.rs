//! `run`: the stand-alone executive.

mod descriptors;
mod display;
mod host;
mod outside;
mod tally;
mod teller;
mod virtual_clock;

use crate::args::RunArgs;
use crate::exit::{Exit, Failure};
use crate::schedule;
use teller::Teller;
use virtual_clock::Pace;

pub(crate) fn run(args: &RunArgs) -> Result<Exit, Failure> {
    let schedule = schedule::read(&args.files)?;
    let mut teller = Teller::new(args.format);
    teller.say(&schedule.summary());
    let teller = match (args.speed, args.virtual_clock) {
        (Some(speed), _) => virtual_clock::run(schedule, Pace::Times(speed), args.time, teller)?,
        (None, true) => virtual_clock::run(schedule, Pace::Free, args.time, teller)?,
        (None, false) => host::run(args, schedule, teller.for_real_time()?)?,
    };
    end(teller)
}

/// The numbers of the run, and how the program ends with them.
fn end(mut teller: Teller) -> Result<Exit, Failure> {
    teller.say(&teller.tally.to_string());
    teller.tally.wanting().map_or(Ok(Exit::Done), |why| Err(Failure::failed(why)))
}
