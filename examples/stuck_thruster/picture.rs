//! The picture of two flights side by side: what they drew, how they spun, and
//! who held which ticket, over the same time.

mod pen;
mod reading;
#[cfg(test)]
mod tests;

use std::fmt;

use faregate::tickets::clock::Instant;
use faregate_devices_sim::{Law, Truth};
use svg::Document;
use svg::node::Text as Words;
use svg::node::element::{Description, Group, Rectangle, Title};

use self::pen::{
    Axis, BLUE, GREEN, GREY, INK, LINE, ORANGE, PURPLE, RULE, SHADE, SKY, TEXT, VERMILLION, bar,
    curve, length, line, steps, text, through,
};
use self::reading::{
    Mark, comes_back, degrees, limit, marks, runs, seconds, spin_up, sticks_at, verdict, watts,
};
use crate::flight::Flight;
use crate::scene::Scene;
use crate::tape::Hold;

/// One column: a flight, flown with a tape that is on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panel<'a> {
    pub(crate) title: &'a str,
    pub(crate) flight: &'a Flight,
    pub(crate) scene: &'a Scene,
}

/// The flight of this title has no samples: its tape was off.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Untaped(String);

impl fmt::Display for Untaped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "nothing to draw of \"{}\": its tape was off", self.0)
    }
}

impl std::error::Error for Untaped {}

const WIDTH: f32 = 960.0;
const HEIGHT: f32 = 496.0;
/// Where each column begins, and how wide it is.
const LEFTS: [f32; 2] = [94.0, 532.0];
const COLUMN: f32 = 412.0;
/// Top and bottom of the rows.
const POWER: (f32, f32) = (104.0, 232.0);
const RATE: (f32, f32) = (248.0, 344.0);
const LANES: [(f32, &str); 4] =
    [(360.0, "camera on"), (382.0, "coil on"), (408.0, "camera ticket"), (430.0, "valve ticket")];
const LANE_HEIGHT: f32 = 18.0;
/// Where the labels of marks stand.
const MARKS: [f32; 3] = [67.0, 81.0, 95.0];
/// Where the axis of time stands.
const TIME: f32 = 454.0;

/// Draws both flights: the text of an SVG, the same for the same flights.
///
/// # Errors
///
/// [`Untaped`] if there is nothing to draw.
pub(crate) fn draw(left: &Panel<'_>, right: &Panel<'_>) -> Result<String, Untaped> {
    let panels = [left, right];
    if let Some(panel) = panels.iter().find(|panel| panel.flight.samples.is_empty()) {
        return Err(Untaped(panel.title.into()));
    }
    let columns = LEFTS.map(|left| Column::new(panels, left));
    let picture = Document::new()
        .set("viewBox", (0, 0, WIDTH, HEIGHT))
        .set("width", WIDTH)
        .set("height", HEIGHT)
        .set("role", "img")
        .set("font-family", "Helvetica, Arial, 'Liberation Sans', sans-serif")
        .set("font-size", TEXT)
        .add(Title::new(
            "A thruster sticks open while the camera has the power that the valve needs",
        ))
        .add(Description::new().add(Words::new(panels.map(describe).join(" "))))
        .add(paper())
        .add(columns[0].scales())
        .add(columns[0].draw(left))
        .add(columns[1].draw(right));
    Ok(format!("{picture}\n"))
}

/// For those who do not see the picture.
fn describe(panel: &Panel<'_>) -> String {
    let marks = marks(panel).into_iter();
    let marks: Vec<_> =
        marks.map(|mark| format!("{} at {:.3} s", mark.what, seconds(mark.at))).collect();
    format!("{}: {}; {}.", panel.title, marks.join(", "), verdict(panel.flight))
}

/// The millisecond at which the axis of time may end: a loss has an aftermath.
fn ends_at(flight: &Flight) -> f32 {
    let flown = flight.samples.last().map_or(0.0, |last| seconds(last.at) * 1e3);
    if flight.lost.is_some() { flown + 150.0 } else { flown }
}

/// White, in dark themes too: the colours are chosen for it.
fn paper() -> Rectangle {
    bar((0.5, WIDTH - 0.5), 0.5, HEIGHT - 1.0, "white").set("rx", 10).set("stroke", RULE)
}

/// One column's axes. Those of both differ only in where they begin.
#[derive(Clone, Debug)]
struct Column {
    /// In milliseconds, so that ticks are whole.
    time: Axis,
    power: Axis,
    rate: Axis,
}

impl Column {
    /// Axes that hold both flights, from shortly before the thruster sticks.
    fn new(panels: [&Panel<'_>; 2], left: f32) -> Self {
        let samples = || panels.into_iter().flat_map(|panel| &panel.flight.samples);
        let sticks = panels.into_iter().filter_map(|panel| sticks_at(panel.scene)).min();
        let from =
            sticks.unwrap_or(Instant::START).as_micros().saturating_sub(100_000) as f32 / 1e3;
        let until =
            panels.into_iter().map(|panel| ends_at(panel.flight)).fold(from + 1.0, f32::max);
        let power =
            samples().map(|sample| watts(sample.draw.max(sample.supply))).fold(0.0, f32::max);
        let rate = panels.into_iter().map(|panel| limit(panel.scene)).fold(0.0, f32::max);
        Self {
            time: Axis::new(from..=until, (left, left + COLUMN)),
            power: Axis::new(0.0..=power * 1.13, (POWER.1, POWER.0)),
            rate: Axis::new(0.0..=rate * 1.25, (RATE.1, RATE.0)),
        }
    }

    fn x(&self, at: Instant) -> f32 {
        self.time.place(seconds(at) * 1e3)
    }

    /// The samples that are on the axis of time.
    fn seen<'f>(&self, flight: &'f Flight) -> &'f [Truth] {
        let before =
            flight.samples.partition_point(|sample| seconds(sample.at) * 1e3 < self.time.low());
        &flight.samples[before..]
    }

    /// What stands left of the first column, for both.
    fn scales(&self) -> Group {
        let beside = self.time.ends().0 - 8.0;
        let mut group = Group::new().set("fill", GREY).set("text-anchor", "end");
        for (axis, step, name) in
            [(&self.power, 50, "bus power, W"), (&self.rate, 5, "body rate, °/s")]
        {
            for tick in axis.ticks(step) {
                group = group.add(text(beside, axis.place(tick) + 4.0, &tick.to_string()));
            }
            let middle = f32::midpoint(axis.ends().0, axis.ends().1);
            let turned = format!("translate(46 {middle}) rotate(-90)");
            group = group
                .add(text(0.0, 0.0, name).set("text-anchor", "middle").set("transform", turned));
        }
        LANES
            .into_iter()
            .fold(group, |group, (top, name)| group.add(text(beside, top + 13.0, name)))
    }

    fn draw(&self, panel: &Panel<'_>) -> Group {
        let left = self.time.ends().0;
        let colour = if panel.flight.lost.is_some() { VERMILLION } else { GREEN };
        let title = text(left, 27.0, panel.title).set("font-size", 16).set("fill", INK);
        Group::new()
            .add(title.set("font-weight", "bold"))
            .add(text(left, 46.0, &verdict(panel.flight)).set("font-size", 13).set("fill", colour))
            .add(self.grid(panel))
            .add(self.marks(panel))
            .add(self.power_row(panel))
            .add(self.rate_row(panel))
            .add(self.device_lanes(panel))
            .add(self.ticket_lanes(panel))
    }

    fn grid(&self, panel: &Panel<'_>) -> Group {
        let (left, right) = self.time.ends();
        let mut group = Group::new().set("fill", GREY).set("text-anchor", "middle");
        if let Some((at, _)) = panel.flight.lost {
            group = group.add(bar((self.x(at), right), POWER.0, TIME - POWER.0, SHADE));
        }
        let levels = self.power.ticks(50).map(|tick| self.power.place(tick));
        for y in levels.chain(self.rate.ticks(5).map(|tick| self.rate.place(tick))) {
            group = group.add(line((left, y), (right, y), RULE));
        }
        let step = if self.time.high() - self.time.low() > 1_000.0 { 500 } else { 100 };
        for tick in self.time.ticks(step) {
            let x = self.time.place(tick);
            let number = text(x, TIME + 17.0, &format!("{:.1}", tick / 1e3));
            group = group.add(line((x, TIME), (x, TIME + 4.0), GREY)).add(number);
        }
        let axis = line((left, TIME), (right, TIME), GREY);
        group.add(axis).add(text(f32::midpoint(left, right), TIME + 33.0, "time, s"))
    }

    /// A label stands behind its line, or before it at the right end; in the
    /// first line of text where the label before leaves room.
    fn marks(&self, panel: &Panel<'_>) -> Group {
        let (mut lines, mut labels) = (Group::new(), Group::new().set("fill", INK));
        let mut taken = [0.0_f32; MARKS.len()];
        for Mark { at, what } in marks(panel) {
            let x = self.x(at);
            let from = self.beside(x, what);
            let row = taken.iter().position(|taken| *taken <= from).unwrap_or(MARKS.len() - 1);
            taken[row] = from + length(what) + 5.0;
            lines = lines
                .add(line((x, MARKS[row] - 10.0), (x, TIME), LINE).set("stroke-dasharray", "2 3"));
            labels = labels.add(text(from, MARKS[row], what));
        }
        lines.add(labels)
    }

    /// Where these words begin beside this place: behind it, or before it if
    /// they would run into the next column.
    fn beside(&self, x: f32, words: &str) -> f32 {
        let runs_over = x + 5.0 + length(words) > self.time.ends().1 + 12.0;
        if runs_over { x - 5.0 - length(words) } else { x + 5.0 }
    }

    fn power_row(&self, panel: &Panel<'_>) -> Group {
        let seen = self.seen(panel.flight);
        let (Some(first), Some(last)) = (seen.first(), seen.last()) else { return Group::new() };
        let at = |truth: &Truth, power| (self.x(truth.at), self.power.place(watts(power)));
        let (x, top) = at(first, first.supply);
        let supply = text(x + 5.0, top - 6.0, &format!("supply {:.0} W", watts(first.supply)));
        let draw = text(x + 5.0, at(first, first.draw).1 + 15.0, "draw");
        let limit = curve(steps(seen.iter().map(|truth| at(truth, truth.supply))), VERMILLION);
        let group = Group::new()
            .add(supply.set("fill", VERMILLION))
            .add(draw.set("fill", BLUE))
            .add(limit.set("stroke-dasharray", "6 4"))
            .add(curve(steps(seen.iter().map(|truth| at(truth, truth.draw))), BLUE));
        match panel.flight.lost {
            Some((_, Law::BusTripped { .. })) => {
                group.add(self.cross(at(last, last.draw), "bus trip"))
            }
            Some((_, Law::PropulsionTripped { .. })) => {
                group.add(self.cross(at(last, last.draw), "converter trip"))
            }
            _ => group,
        }
    }

    fn rate_row(&self, panel: &Panel<'_>) -> Group {
        let limit = limit(panel.scene);
        let (left, right) = self.time.ends();
        let y = self.rate.place(limit);
        let at = |truth: &Truth| (self.x(truth.at), self.rate.place(degrees(truth.rate_urad_s)));
        let seen = self.seen(panel.flight);
        let name = text(left + 5.0, y + 15.0, &format!("unrecoverable above {limit:.1} °/s"));
        let group = Group::new()
            .add(curve(through([(left, y), (right, y)]), VERMILLION).set("stroke-dasharray", "6 4"))
            .add(name.set("fill", VERMILLION))
            .add(curve(through(seen.iter().map(at)), GREEN));
        match (panel.flight.lost, seen.last()) {
            (Some((_, Law::SpunUp { .. })), Some(last)) => {
                group.add(self.cross(at(last), "spun up"))
            }
            (Some(_), Some(last)) => group.add(self.spins_on(panel.scene, last)),
            _ => group,
        }
    }

    /// Without power nobody shuts the valve, and the rate goes on as it did.
    /// This is worked out, not flown, and the picture says so.
    fn spins_on(&self, scene: &Scene, last: &Truth) -> Group {
        if !last.thruster_open || last.cutoff_shut {
            return Group::new();
        }
        let (from, rate, gain) = (seconds(last.at), degrees(last.rate_urad_s), spin_up(scene));
        let too_fast_at = from + (limit(scene) - rate) / gain;
        let until = too_fast_at.min(self.time.high() / 1e3);
        let end = (self.time.place(until * 1e3), self.rate.place(rate + gain * (until - from)));
        let on = curve(through([(self.x(last.at), self.rate.place(rate)), end]), GREEN);
        let name = format!("extrapolated: unrecoverable at {too_fast_at:.1} s");
        let name = text(end.0 - 4.0, end.1 - 9.0, &name).set("text-anchor", "end");
        Group::new().add(on.set("stroke-dasharray", "2 3")).add(name.set("fill", GREEN))
    }

    fn device_lanes(&self, panel: &Panel<'_>) -> Group {
        let is_on: [fn(&Truth) -> bool; 2] =
            [|truth| truth.camera_on, |truth| truth.cutoff_coil_on];
        let mut group = Group::new();
        for ((top, _), is_on) in LANES.into_iter().zip(is_on) {
            for (from, until) in runs(self.seen(panel.flight), is_on) {
                group = group.add(self.span(from, until, top, GREY));
            }
        }
        group
    }

    fn ticket_lanes(&self, panel: &Panel<'_>) -> Group {
        let Flight { holds, samples, .. } = panel.flight;
        let ended = samples.last().map_or(Instant::START, |truth| truth.at);
        let mut group = Group::new().set("fill", INK);
        for ((top, _), device) in LANES.into_iter().skip(2).zip(["camera", "cutoff valve"]) {
            let seen = holds.iter().filter(|hold| seconds(hold.until) * 1e3 > self.time.low());
            for hold in seen.filter(|hold| hold.device == device) {
                group = group.add(self.hold(hold, hold.until.min(ended), top));
            }
        }
        if !holds.is_empty() {
            return group;
        }
        let name = match comes_back(panel.flight) {
            0 => "no tickets".into(),
            times => format!("no tickets: the camera comes on again, {times} times"),
        };
        group.add(
            text(self.time.ends().0 + 5.0, LANES[2].0 + 24.0, &name).set("font-style", "italic"),
        )
    }

    /// The holder's name stands in its bar, or behind it.
    fn hold(&self, hold: &Hold, until: Instant, top: f32) -> Group {
        let colour = match hold.by {
            "monitor" => SKY,
            "rescuer" => ORANGE,
            _ => PURPLE,
        };
        let width = self.x(until) - self.x(hold.from);
        let fits = width > length(hold.by) + 8.0;
        let name = text(self.x(if fits { hold.from } else { until }) + 5.0, top + 13.0, hold.by);
        let name = if fits { name.set("stroke", "none") } else { name };
        Group::new().add(self.span(hold.from, until, top, colour)).add(name)
    }

    /// A bar over this time, wide enough to be seen.
    fn span(&self, from: Instant, until: Instant, top: f32, colour: &str) -> Rectangle {
        let (from, until) = (self.x(from), self.x(until));
        bar((from, until.max(from + 2.0)), top, LANE_HEIGHT, colour)
    }

    /// Where the flight ended, and how.
    fn cross(&self, (x, y): (f32, f32), name: &str) -> Group {
        let strokes = [-6.0, 6.0].map(|rise| through([(x - 6.0, y - rise), (x + 6.0, y + rise)]));
        let cross =
            strokes.into_iter().map(|stroke| curve(stroke, VERMILLION).set("stroke-width", 3));
        let beside = self.beside(x, name);
        // Before the cross is the curve: the name goes above it.
        let (x, y) = if beside > x { (beside + 6.0, y + 4.0) } else { (beside, y - 10.0) };
        let name = text(x, y, name).set("fill", VERMILLION).set("font-weight", "bold");
        cross.fold(Group::new(), Group::add).add(name)
    }
}
