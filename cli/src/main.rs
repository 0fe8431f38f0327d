//! The program `faregate`: checks, analyses, converts and runs schedules, and
//! commands a running schedule manager.
//!
//! | module | what |
//! |---|---|
//! | `args` | the words of the command line |
//! | `plan` | sub-commands about plans of the onboard planner |
//! | `live` | sub-commands that talk to a running manager |
//! | `inside` | sub-commands for scripts inside a task |
//! | `changes` | one line for each change |
//! | `out`, `exit`, `times` | what is printed; how it ends; times in words |
//! | `disk` | what is read and written |

mod analyze;
mod args;
mod changes;
mod check;
mod convert;
mod disk;
mod exit;
mod inside;
mod live;
mod out;
mod plan;
mod report;
mod run;
mod schedule;
mod simulation;
mod times;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use args::{CompletionsArgs, Faregate, What};
use exit::{Exit, Failure};

fn main() -> ExitCode {
    let exit = match run(&Faregate::parse().what) {
        Ok(exit) | Err(Failure::Said(exit)) => exit,
        Err(Failure::Because(exit, why)) => {
            out::complain(format_args!("{}: {why}", out::styled(out::BAD, "error")));
            exit
        }
        Err(Failure::NobodyReads) => Exit::Done,
    };
    exit.into()
}

fn run(what: &What) -> Result<Exit, Failure> {
    match what {
        What::Status(args) => live::status(args),
        What::Watch(args) => live::watch(args),
        What::Add(args) => live::add(args),
        What::Remove(args) => live::remove(args),
        What::Set(args) => live::set(args),
        What::Clear(args) => live::clear(args),
        What::Hold(args) => live::hold(args),
        What::Resume(args) => live::resume(args),
        What::Mode(action) => live::mode(action),
        What::Shutdown(args) => live::shut_down(args),
        What::Command(args) => inside::command(args),
        What::Heartbeat => inside::heartbeat(),
        What::Completions(args) => completions(args),
        What::Check(args) => check::check(args),
        What::Analyze(args) => analyze::analyze(args),
        What::Run(args) => run::run(args),
        What::Plan(action) => plan::plan(action),
        What::Convert(args) => convert::convert(args),
    }
}

fn completions(args: &CompletionsArgs) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Faregate::command(), "faregate", &mut script);
    out::bytes(&script)?;
    Ok(Exit::Done)
}
