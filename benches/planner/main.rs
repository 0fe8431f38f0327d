//! What planning costs, how it grows, and what its plans are worth.
//!
//! `cargo bench --bench planner`. Rows 18 to 21 of the targets in
//! `docs/performance.md`. The peer is the scheduler that is written first: a
//! minute's grid, and a look at everything that is placed for each start.

mod growth;
mod later;
mod naive;
mod replan;
#[path = "../support/mod.rs"]
mod support;
mod tightness;
mod value;

use std::process::ExitCode;

use faregate_planner::Problem;
use faregate_planner::generate::World;

fn main() -> ExitCode {
    support::run("planner", |bench| {
        growth::measure(bench)?;
        replan::measure(bench)?;
        value::measure(bench)
    })
}

/// The world as the planner takes it.
fn problem(world: &World) -> Result<Problem, support::Failure> {
    let problem = Problem::new(&world.plan, &world.parameters, &world.state);
    problem.map_err(|unfit| format!("a drawn world is not fit: {unfit:?}").into())
}
