//! Writes small worlds as lines of JSON, for an exact solver: how many
//! activities, the seed, a checksum of the world, the world, and two plans of
//! it, as numbers of activities with the instants at which they start: the one
//! pass's, and an improved one. Left out are those in which mandatory activities
//! exceed a limit.
//!
//! `cargo run -p faregate-planner --example small_worlds -- FIRST LAST SIZE..`

use std::process::ExitCode;

use faregate_planner::generate::Shape;
use faregate_planner::{Budget, Problem, TimedPlan, improve, schedule};
use serde_json::{Value, json};

/// What improvement may evaluate: enough for a good plan to begin with.
const BUDGET: Budget = Budget { evaluations: 10_000, seed: 1 };

fn main() -> ExitCode {
    let numbers: Result<Vec<u64>, _> = std::env::args().skip(1).map(|word| word.parse()).collect();
    let Ok([first, last, sizes @ ..]) = numbers.as_deref() else { return usage() };
    if sizes.is_empty() {
        return usage();
    }
    for &size in sizes {
        for seed in *first..=*last {
            match line(size, seed) {
                Ok(line) => println!("{line}"),
                Err(error) => {
                    eprintln!("{size} activities, seed {seed}: {error}");
                    return ExitCode::FAILURE;
                }
            }
        }
    }
    ExitCode::SUCCESS
}

fn usage() -> ExitCode {
    eprintln!("usage: small_worlds FIRST_SEED LAST_SEED SIZE..");
    ExitCode::from(2)
}

fn line(size: u64, seed: u64) -> Result<Value, String> {
    let shape = Shape::small(usize::try_from(size).map_err(|error| error.to_string())?, seed);
    let world = shape.draw();
    let problem = Problem::new(&world.plan, &world.parameters, &world.state);
    let problem = problem.map_err(|unfit| format!("{unfit:?}"))?;
    let improved = improve(&problem, None, BUDGET, &mut || false).timed;
    let mut plans = vec![schedule(&problem, None), improved];
    // Mandatory activities may exceed limits that the solver's model keeps.
    plans.retain(|timed| timed.excess.is_empty());
    Ok(json!({
        "activities": size,
        "seed": seed,
        "checksum": shape.checksum(),
        "plans": plans.iter().map(starts).collect::<Vec<_>>(),
        "world": world,
    }))
}

fn starts(timed: &TimedPlan) -> Vec<(u32, i64)> {
    let slots = timed.rows.iter().filter_map(|row| Some((row.id, timed.slot(row.id)?)));
    slots.map(|(id, slot)| (id.get(), slot.start.get())).collect()
}
