//! Writes small worlds as lines of JSON, for an exact solver: how many
//! activities, the seed, a checksum of the plan, and the world.
//!
//! `cargo run -p faregate-planner --example small_worlds -- FIRST LAST SIZE..`

use std::process::ExitCode;

use faregate_planner::generate::Shape;
use serde_json::json;

fn main() -> ExitCode {
    let numbers: Result<Vec<u64>, _> = std::env::args().skip(1).map(|word| word.parse()).collect();
    match numbers.as_deref() {
        Ok([first, last, sizes @ ..]) if !sizes.is_empty() => write(*first..=*last, sizes),
        _ => {
            eprintln!("usage: small_worlds FIRST_SEED LAST_SEED SIZE..");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

fn write(seeds: impl Iterator<Item = u64> + Clone, sizes: &[u64]) {
    for &size in sizes {
        for seed in seeds.clone() {
            let shape = Shape::small(usize::try_from(size).unwrap_or(usize::MAX), seed);
            let world = shape.draw();
            let line = json!({
                "activities": size,
                "seed": seed,
                "checksum": shape.checksum(),
                "world": world,
            });
            println!("{line}");
        }
    }
}
