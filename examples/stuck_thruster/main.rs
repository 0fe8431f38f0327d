//! The stuck-thruster emergency (scratch main).
mod bodies;
mod design;
mod flight;
mod rivals;
mod scene;
mod stage;
mod tape;
mod tickets;
mod watch;

use design::Design;
use faregate_devices_sim::interleave::SimLocked;

fn main() {
    let runs: u64 = std::env::args().nth(1).and_then(|runs| runs.parse().ok()).unwrap_or(200);
    for design in Design::ALL {
        let start = std::time::Instant::now();
        let (mut lost, mut after, mut refused, mut cut, mut over, mut restored, mut allowed) = (0, 0, 0, 0, 0, 0, 0);
        let mut worst = 0.0_f64;
        let mut first = None;
        let mut laws = std::collections::BTreeMap::<String, u32>::new();
        for seed in 0..runs {
            let scene = scene::Scene::new(seed);
            let stage = stage::Stage::virtual_time(scene.ends_at);
            let flight = design.fly::<SimLocked>(&scene, &stage, &tape::Tape::off());
            if let Some((_, law)) = flight.lost {
                lost += 1;
                first = first.or(Some(seed));
                *laws.entry(law.to_string().chars().take(10).collect::<String>()).or_insert(0) += 1;
            }
            after += flight.after_quiescence;
            refused += flight.valid_refused;
            cut += u32::from(flight.cutoff_after.is_some());
            if let (Some(took), Some(bound)) = (flight.cutoff_after, flight.bound) {
                let ratio = took.as_micros() as f64 / bound.as_micros() as f64;
                worst = worst.max(ratio);
                if took > bound { over += 1; }
            }
            if let Some(done) = flight.restored { allowed += 1; restored += u32::from(done); }
        }
        println!("{:40} lost {lost:4} first {first:?} after {after} refused {refused} cut {cut} over {over} worst {worst:.2} restored {restored}/{allowed} {:?} in {:?}", design.name(), laws, start.elapsed());
    }
}
