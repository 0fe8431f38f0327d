//! `faregate-audit`: see `README.md`.

mod cli;

use std::process::ExitCode;

use clap::Parser as _;

use crate::cli::{Arguments, Verdict};

fn main() -> ExitCode {
    match cli::run(Arguments::parse()) {
        Ok(Verdict::Holds) => ExitCode::SUCCESS,
        Ok(Verdict::Broken) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("faregate-audit: {error:#}");
            ExitCode::from(2)
        }
    }
}
