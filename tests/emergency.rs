//! The emergency in the campaign's harness, as a test: ticket designs save
//! every spacecraft, and each design without them, or with a part of them left
//! out, loses some by the law that its missing part names.
#![expect(dead_code, reason = "the example's modules, of which the test uses some")]

#[path = "../examples/stuck_thruster/bodies.rs"]
mod bodies;
#[path = "../examples/stuck_thruster/campaign.rs"]
mod campaign;
#[path = "../examples/stuck_thruster/design.rs"]
mod design;
#[path = "../examples/stuck_thruster/flight.rs"]
mod flight;
#[path = "../examples/stuck_thruster/rivals.rs"]
mod rivals;
#[path = "../examples/stuck_thruster/scene.rs"]
mod scene;
#[path = "../examples/stuck_thruster/stage.rs"]
mod stage;
#[path = "../examples/stuck_thruster/tape.rs"]
mod tape;
#[path = "../examples/stuck_thruster/tickets.rs"]
mod tickets;
#[path = "../examples/stuck_thruster/watch.rs"]
mod watch;

use campaign::{Campaign, Row};
use indicatif::ProgressBar;

fn row<'a>(campaign: &'a Campaign, name: &str) -> &'a Row {
    campaign.designs.iter().find(|row| row.name == name).expect("the design is there")
}

#[test]
fn ticket_designs_save_every_spacecraft_and_all_others_lose_some() {
    let campaign = Campaign::fly(&(0..200), &ProgressBar::hidden());
    assert_eq!(campaign.complaints(), Vec::<String>::new());
    for name in ["tickets, exclusive", "tickets, power margin"] {
        let row = row(&campaign, name);
        assert_eq!((row.lost, row.cutoffs_actuated, row.runs), (0, 200, 200), "{name}");
        assert_eq!((row.commands_after_quiescence, row.valid_refused), (0, 0), "{name}");
        assert!(row.restorable > 50 && row.restored == row.restorable, "{name}");
    }
    for (name, law) in [
        ("bare commands", "bus trip"),
        ("suspended monitor", "bus trip"),
        ("allocations by convention", "bus trip"),
        ("without quiescence (bare flag)", "bus trip"),
        ("without safing", "spin-up"),
        ("without confirmation", "bus trip"),
        ("with stale estimates", "bus trip"),
        ("without a lease", "spin-up"),
    ] {
        assert!(row(&campaign, name).lost_by.contains_key(law), "{name} loses none by {law}");
    }
    assert!(row(&campaign, "without quiescence (bare flag)").commands_after_quiescence > 0);
}

#[test]
fn a_seed_reproduces_a_run() {
    for design in design::Design::ALL {
        for seed in 0..5 {
            let fly = || format!("{:?}", campaign::fly(design, &scene::Scene::new(seed)));
            assert_eq!(fly(), fly(), "{} with seed {seed}", design.name());
        }
    }
}
