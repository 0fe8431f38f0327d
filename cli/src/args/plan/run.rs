//! Words of `plan run`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

#[derive(Debug, Args)]
#[command(after_help = RUN_HELP)]
pub(crate) struct PlanRunArgs {
    /// The plan: .xml, or its binary form.
    #[arg(value_name = "PLAN", required_unless_present = "random")]
    pub(crate) plan: Option<PathBuf>,
    /// What only the ground changes: limits, powers, preheat tables.
    #[arg(long, short, value_name = "FILE", required_unless_present = "random")]
    pub(crate) parameters: Option<PathBuf>,
    /// What is so at the begin: charge, mode, communication windows.
    #[arg(long, short, value_name = "FILE", required_unless_present = "random")]
    pub(crate) state: Option<PathBuf>,
    /// Plan, parameters and state are drawn from the seed, and so is what goes
    /// wrong. With a campaign, each seed is another plan, and it fails also when
    /// some kind of abort, a cleanup, an early start, a pause, a veto or a
    /// handover never came up.
    #[arg(long, conflicts_with_all = ["plan", "parameters", "state", "faults", "next"])]
    pub(crate) random: bool,
    /// What activities really take and the noise of the sensors are drawn from
    /// it; of a campaign, the first one.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// What goes wrong: a JSON list, as below.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) faults: Option<PathBuf>,
    /// The plan that takes over at handover.
    #[arg(long, value_name = "FILE")]
    pub(crate) next: Option<PathBuf>,
    /// Executes the first timed plan as it stands: no new plans, no early
    /// starts. Otherwise both are executed, and compared.
    #[arg(long = "static")]
    pub(crate) is_static: bool,
    /// Draws what happened into this file.
    #[arg(long, value_name = "OUT.svg", conflicts_with = "campaign")]
    pub(crate) svg: Option<PathBuf>,
    /// Leaves everything that the ground wants to have into this directory: each
    /// timed plan with its reasons, the state and the timelines that go with it,
    /// plans, parameters, versions, and what happened. It must be empty, or not
    /// there.
    #[arg(long, value_name = "DIR", conflicts_with = "campaign")]
    pub(crate) products: Option<PathBuf>,
    /// Executes the plan so many times, with a seed each, on bad days: what
    /// goes wrong is drawn, too. Prints the sums.
    #[arg(long, value_name = "EXECUTIONS", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) campaign: Option<u64>,
    /// How the result is printed: a line for each change, or a document.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: RunFormat,
}

const RUN_HELP: &str = r#"The rover is simulated, in virtual time. Planner and control thread see what
its sensors say; every execution is held against the rules by the independent
checker, which sees the truth.

Faults, with instants in milliseconds as everywhere in timed plans:
  [{"heater_dead": {"zone": "mast", "from": 36000000, "until": 39600000}},
   {"sensors_silent": {"from": 36000000, "until": 37000000}},
   {"drain": {"from": 40000000, "until": 50000000, "load": 150000}},
   {"discharge": {"at": 40000000, "energy": 1800000000000}},
   {"variable": {"at": 40000000, "name": "drive_permitted", "value": null}},
   {"window": {"at": 40000000, "index": 1, "becomes": null}},
   {"commandeered": {"from": 40000000, "until": 41000000, "draw": 300000,
                     "resources": 0}},
   {"veto": {"at": 40000000, "id": 7}},
   {"stop": {"at": 40000000, "id": 7}}]

Exit codes:
  0  executed, and no rule was broken
  1  a file cannot be read or has mistakes, a rule was broken, or what a random
     campaign is for never came up
  2  wrong usage

Examples:
  faregate plan run sol.xml -p parameters.xml -s state.xml --svg happened.svg
  faregate plan run sol.xml -p parameters.xml -s state.xml --products sol-7
  faregate plan run --random --campaign 1000
  faregate plan run --random --seed 77"#;

/// How an execution is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum RunFormat {
    /// A line for each change, and a summary.
    #[default]
    Text,
    /// One document at the end.
    Json,
}
