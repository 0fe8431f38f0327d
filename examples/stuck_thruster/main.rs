//! The stuck-thruster emergency: why tickets save the spacecraft where the
//! usual designs lose it.
//!
//! A thruster valve sticks open and the spacecraft spins up. The cutoff valve
//! needs more power than is left while the camera is on, and a monitor thread
//! keeps the camera on, because that is its job. First one run on real threads
//! in real time, told as it happened; then a campaign of seeded runs in virtual
//! time, in which the same threads are interleaved at every switch point, over
//! ten designs: tickets with two policies, the three designs that Gat (2000)
//! shows to fail, and tickets with one part left out. It ends with an error if
//! a ticket design loses a spacecraft, or if one of the others never does.

mod bodies;
mod campaign;
mod design;
mod flight;
mod picture;
mod report;
mod rivals;
mod scene;
mod stage;
mod tape;
mod tickets;
mod watch;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use faregate::runtime::host::HostStrategy;
use faregate_devices_sim::interleave::SimLocked;
use indicatif::{ProgressBar, ProgressStyle};

use campaign::Campaign;
use design::{Design, Rival};
use flight::Flight;
use scene::Scene;
use stage::Stage;
use tape::Tape;
use tickets::Variant;

/// Flies the stuck-thruster emergency: once on real threads, then a campaign.
#[derive(Parser)]
#[command(after_help = "Exit code: 0 if every ticket design saved every spacecraft and, from 200 \
                        runs on, every other design lost at least one; 1 if not.")]
struct Options {
    /// The first seed of the campaign.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// How many seeds every design flies.
    #[arg(long, default_value_t = 1_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    runs: u64,
    /// Write a picture of one run, with tickets and without.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Print the campaign's results as JSON, and nothing else.
    #[arg(long)]
    json: bool,
    /// Tell one run of this design with this seed, and nothing else.
    #[arg(long, value_name = "DESIGN")]
    replay: Option<String>,
}

fn main() -> ExitCode {
    let options = Options::parse();
    match run(&options) {
        Ok(complaints) if complaints.is_empty() => ExitCode::SUCCESS,
        Ok(complaints) => {
            complaints.iter().for_each(|complaint| eprintln!("error: {complaint}"));
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<Vec<String>, Box<dyn Error>> {
    if let Some(name) = &options.replay {
        return replay(name, options.seed).map(|()| Vec::new());
    }
    let mut complaints = Vec::new();
    if !options.json {
        complaints.extend(demonstrate(options.seed));
    }
    if let Some(file) = &options.svg {
        draw(file, options.seed)?;
    }
    let seeds = options.seed..options.seed.saturating_add(options.runs);
    let progress = progress(options);
    let campaign = Campaign::fly(&seeds, &progress);
    progress.finish_and_clear();
    if options.json {
        println!("{}", serde_json::to_string_pretty(&campaign)?);
    } else {
        println!("\n{} seeds, from {} on, in virtual time\n", options.runs, options.seed);
        println!("{}\n\n{}", report::table(&campaign), report::remarks(&campaign));
    }
    complaints.extend(campaign.complaints());
    Ok(complaints)
}

/// One run with the power margin policy, on real threads and in real time.
fn demonstrate(seed: u64) -> Option<String> {
    println!("One run on real threads: tickets with the power margin policy\n");
    let scene = Scene::demonstration(seed);
    let stage = Stage::real_time(scene.ends_at).telling();
    let flight =
        Design::Tickets(Variant::PowerMargin).fly::<HostStrategy>(&scene, &stage, &Tape::off());
    println!("{}", report::timeline(&stage.story()));
    let saved = flight.lost.is_none();
    println!("\n{}", if saved { "saved" } else { "LOST" });
    (!saved).then(|| "the run on real threads lost the spacecraft".into())
}

fn replay(name: &str, seed: u64) -> Result<(), Box<dyn Error>> {
    let design = Design::ALL.into_iter().find(|design| design.name() == name).ok_or_else(|| {
        let names: Vec<_> = Design::ALL.iter().map(|design| design.name()).collect();
        format!("there is no design \"{name}\"; there are: {}", names.join("; "))
    })?;
    let scene = Scene::new(seed);
    let stage = Stage::virtual_time(scene.ends_at).telling();
    let flight = design.fly::<SimLocked>(&scene, &stage, &Tape::off());
    println!("{name}, seed {seed}, in virtual time\n\n{}", report::timeline(&stage.story()));
    println!(
        "\n{}",
        flight.lost.map_or("saved".into(), |(at, law)| format!("LOST at {at}: {law}"))
    );
    Ok(())
}

fn draw(file: &Path, seed: u64) -> Result<(), Box<dyn Error>> {
    let scene = Scene::demonstration(seed);
    let filmed = |design: Design| -> Flight {
        let stage = Stage::virtual_time(scene.ends_at);
        design.fly::<SimLocked>(&scene, &stage, &Tape::on())
    };
    let with = filmed(Design::Tickets(Variant::PowerMargin));
    let without = filmed(Design::Rival(Rival::BareCommands));
    let panel = |title, flight| picture::Panel { title, flight, scene: &scene };
    let left = panel("Tickets, power margin policy", &with);
    let right = panel("Bare commands", &without);
    let svg = picture::draw(&left, &right)?;
    std::fs::write(file, svg)
        .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    Ok(())
}

fn progress(options: &Options) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} flights, {msg}");
    let bar = ProgressBar::new(Campaign::flights(options.runs));
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
