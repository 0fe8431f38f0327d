//! What the picture says about a flight in words and instants.

use faregate::tickets::amount::Milliwatts;
use faregate::tickets::clock::{Duration, Instant};
use faregate_devices_sim::{Fault, Law, Truth};

use super::Panel;
use crate::flight::Flight;
use crate::scene::Scene;

pub(super) fn seconds(at: Instant) -> f32 {
    at.as_micros() as f32 / 1e6
}

pub(super) fn watts(power: Milliwatts) -> f32 {
    power.get() as f32 / 1e3
}

pub(super) fn degrees(urad: u64) -> f32 {
    (urad as f32 / 1e6).to_degrees()
}

/// The rate from which the body cannot be brought back.
pub(super) fn limit(scene: &Scene) -> f32 {
    degrees(scene.parameters.unrecoverable_rate_urad_s.into())
}

/// By how much the rate grows in a second, while the thruster is open.
pub(super) fn spin_up(scene: &Scene) -> f32 {
    let parameters = &scene.parameters;
    degrees((parameters.thruster_torque_unm / parameters.inertia_kgm2).into())
}

pub(super) fn sticks_at(scene: &Scene) -> Option<Instant> {
    scene.script.iter().find_map(|fault| match fault {
        Fault::ThrusterSticksOpen { at } => Some(at),
        _ => None,
    })
}

/// What came of it, in a line.
pub(super) fn verdict(flight: &Flight) -> String {
    if let Some((at, law)) = flight.lost {
        return format!("lost at {:.2} s: {}", seconds(at), breach(law));
    }
    let Some(after) = flight.cutoff_after else { return "the valve was never commanded".into() };
    let bound = flight.bound.map(|bound| format!(" (bound {})", in_ms(bound))).unwrap_or_default();
    let restored = if flight.restored == Some(true) { "; observes again" } else { "" };
    format!("saved: valve commanded in {}{bound}{restored}", in_ms(after))
}

fn breach(law: Law) -> String {
    match law {
        Law::BusTripped { draw, supply } => {
            format!("{:.0} W drawn from a bus that gives {:.0} W", watts(draw), watts(supply))
        }
        Law::PropulsionTripped { draw, supply } => {
            format!("{:.0} W drawn from a converter of {:.0} W", watts(draw), watts(supply))
        }
        Law::SpunUp { rate_urad_s } => {
            format!("spins at {:.1} °/s, unrecoverable", degrees(rate_urad_s))
        }
    }
}

/// Rounded up: a bound stays one.
fn in_ms(duration: Duration) -> String {
    format!("{} ms", duration.as_micros().div_ceil(1_000))
}

/// An instant that the reader should find in all rows.
pub(super) struct Mark {
    pub(super) at: Instant,
    pub(super) what: &'static str,
}

/// What happened, in order.
pub(super) fn marks(panel: &Panel<'_>) -> Vec<Mark> {
    let Flight { samples, holds, lost, .. } = panel.flight;
    let shut = first(samples, Instant::START, |truth| truth.cutoff_shut);
    let off = shut.and_then(|shut| first(samples, shut, |truth| !truth.camera_on));
    let back = off.and_then(|off| first(samples, off, |truth| truth.camera_on));
    let asked = if holds.is_empty() { "rescue begins" } else { "valve requested" };
    let marks = [
        (sticks_at(panel.scene), "thruster sticks open"),
        (asked_at(panel.flight), asked),
        (shut, "valve shut"),
        (back, "camera back on"),
        (lost.map(|(at, _)| at), "spacecraft lost"),
    ];
    let marks = marks.into_iter().filter_map(|(at, what)| Some(Mark { at: at?, what }));
    let mut marks: Vec<_> = marks.collect();
    marks.sort_by_key(|mark| mark.at);
    marks
}

/// The first sample from then on that says so.
fn first(samples: &[Truth], from: Instant, is: fn(&Truth) -> bool) -> Option<Instant> {
    samples.iter().find(|sample| sample.at >= from && is(sample)).map(|sample| sample.at)
}

/// When the rescuer went to work: as long before the coil was driven as the
/// flight says. A flight that never drove it does not tell.
fn asked_at(flight: &Flight) -> Option<Instant> {
    let driven = first(&flight.samples, Instant::START, |truth| truth.cutoff_coil_on)?;
    let asked = driven.since(Instant::START).saturating_sub(flight.cutoff_after?);
    Some(Instant::START.after(asked))
}

/// How often the camera came on between the request and the valve's end.
pub(super) fn comes_back(flight: &Flight) -> usize {
    let shut = first(&flight.samples, Instant::START, |truth| truth.cutoff_shut);
    let Some(asked) = asked_at(flight) else { return 0 };
    let camera = runs(&flight.samples, |truth| truth.camera_on);
    camera.iter().filter(|(on, _)| *on > asked && shut.is_none_or(|shut| *on < shut)).count()
}

/// The times during which it was so, each until the first sample that says
/// otherwise.
pub(super) fn runs(samples: &[Truth], is: fn(&Truth) -> bool) -> Vec<(Instant, Instant)> {
    let alike = samples.chunk_by(|one, next| is(one) == is(next));
    let mut at = 0;
    let runs = alike.filter_map(|alike| {
        at += alike.len();
        let until = samples.get(at).or(alike.last())?.at;
        alike.first().filter(|first| is(first)).map(|first| (first.at, until))
    });
    runs.collect()
}
