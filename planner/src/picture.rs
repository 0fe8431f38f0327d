//! The picture of a timed plan, or of its execution, as SVG: what the computer
//! and the radio do, a row for each activity, and the timelines with their
//! limits.

mod computer;
mod happened;
mod lane;
mod legend;
mod notices;
mod panel;
mod panels;
mod pen;
mod rows;
mod scale;

use svg::Document;
use svg::node::element::Group;

use crate::parameters::Parameters;
use crate::picture::lane::Place;
use crate::picture::pen::{
    EDGE, GREY, INK, MANDATORY, MARGIN, OPTIONAL, RULE, SHADE, bar, haloed, length, line, more,
    note, sheet, shortened, text, tip,
};
use crate::picture::rows::{Row, rows};
use crate::picture::scale::Scale;
use crate::plan::{Outcome, Plan};
use crate::state::State;
use crate::timed::{Fate, Projection, TimedPlan};
use crate::trace::Trace;
use crate::units::Time;
use crate::words::Words;

/// What there is to be seen.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// What the ground wrote.
    pub plan: &'a Plan,
    /// Its limits.
    pub parameters: &'a Parameters,
    /// What it was planned from.
    pub state: &'a State,
    /// What was planned.
    pub timed: &'a TimedPlan,
    /// What timelines were to be.
    pub projection: &'a Projection,
    /// What happened. With it, the plan is drawn as outlines.
    pub trace: Option<&'a Trace>,
}

const WIDTH: f64 = 1_200.0;
/// Where the scale begins and ends.
const LEFT: f64 = 262.0;
const RIGHT: f64 = WIDTH - 50.0;
/// The title, what is said below it, the legend and the instants' names.
const HEAD: f64 = 106.0;
/// The first line below what is said of the whole.
const NOTICES: f64 = 65.0;
/// The numbers of the scale, above and below.
const NUMBERS: f64 = 24.0;
const HEADING: f64 = 22.0;
/// The rows of the computer and the radio.
const BAND: f64 = 24.0;
/// Between two panels.
const GAP: f64 = 12.0;

/// Draws it: the text of an SVG, the same for the same scene.
#[must_use]
pub fn draw(scene: &Scene<'_>) -> String {
    let (from, until) = extent(scene);
    let scale = Scale::new(from, until, (LEFT, RIGHT));
    let (rows, panels) = (rows(scene), panels::panels(scene));
    let picture = Picture { scene, notices: notices::notices(scene), rows, panels, scale };
    format!("{}\n", picture.document())
}

/// From the first thing that is known to the plan's end.
fn extent(scene: &Scene<'_>) -> (Time, Time) {
    let started = scene.state.running.iter().map(|running| running.started);
    let ended = scene.state.ended.iter().filter_map(|ended| ended.started);
    let from = started.chain(ended).chain([scene.state.now]).min().unwrap_or_default();
    match scene.trace {
        Some(trace) => (from.min(trace.begin), trace.end.max(scene.plan.end)),
        None => (from, scene.plan.end),
    }
}

struct Picture<'a> {
    scene: &'a Scene<'a>,
    notices: Vec<String>,
    rows: Vec<Row>,
    panels: Vec<panel::Panel>,
    scale: Scale,
}

impl Picture<'_> {
    fn document(&self) -> Document {
        let first = self.head() + NUMBERS;
        let rows = first + 2.0 * BAND + 6.0;
        let panels = rows + self.rows.iter().map(|row| self.height(row)).sum::<f64>() + GAP;
        let last = panels + self.panels.iter().map(|panel| panel.height + GAP).sum::<f64>() - GAP;
        let height = last + NUMBERS + MARGIN;
        let title = if self.scene.plan.name.is_empty() { "Plan" } else { &self.scene.plan.name };
        let patterns = [more("more-mandatory", MANDATORY), more("more-optional", OPTIONAL)];
        sheet((WIDTH, height), (title, &self.about()), patterns)
            .add(notices::draw(&self.notices, (MARGIN, NOTICES)))
            .add(legend::draw(&self.rows, (MARGIN, self.head() - 36.0)))
            .add(self.shades(rows))
            .add(computer::shades(self.scene, (first, panels - GAP), &self.scale))
            .add(self.grid(first, panels - GAP, last))
            .add(self.bands(first))
            .add(self.lanes(rows))
            .add(self.curves(panels))
            .add(self.instants(first, last))
    }

    /// What stands above the scale.
    fn head(&self) -> f64 {
        HEAD + notices::height(&self.notices)
    }

    fn about(&self) -> String {
        let words = Words::new(self.scene.plan, self.scene.parameters);
        let (from, until) = (words.time(self.scale.from), words.time(self.scale.until));
        let said = self.scene.trace.map_or_else(|| self.planned(), |trace| self.executed(trace));
        format!("{from} to {until}; {said}")
    }

    fn planned(&self) -> String {
        let rows = &self.scene.timed.rows;
        let count = |what: fn(&Fate) -> bool| rows.iter().filter(|row| what(&row.fate)).count();
        let within = count(|fate| matches!(fate, Fate::Scheduled(_) | Fate::Running(_)));
        let out = count(|fate| matches!(fate, Fate::Out(_)));
        let plural = if within == 1 { "activity" } else { "activities" };
        format!("{within} {plural} scheduled, {out} left out")
    }

    /// What became of the plan's activities.
    fn executed(&self, trace: &Trace) -> String {
        let outcomes = self.scene.plan.activities.iter();
        let outcomes: Vec<_> = outcomes.map(|one| happened::outcome(trace, one.id)).collect();
        let count = |is: &[Option<Outcome>]| outcomes.iter().filter(|one| is.contains(one)).count();
        let counts = [
            (count(&[Some(Outcome::Succeeded)]), "succeeded"),
            (count(&[Some(Outcome::Failed)]), "failed"),
            (count(&[Some(Outcome::Aborted)]), "aborted"),
            (count(&[None, Some(Outcome::NotStarted)]), "not started"),
        ];
        let told = counts.iter().filter(|(count, word)| *count > 0 || *word == "succeeded");
        let told: Vec<_> = told.map(|(count, word)| format!("{count} {word}")).collect();
        format!("executed: {}", told.join(", "))
    }

    /// Rows are lower where there are many.
    fn height(&self, row: &Row) -> f64 {
        match row {
            Row::Heading(..) => HEADING,
            Row::Lane(_) if self.rows.len() <= 50 => 19.0,
            Row::Lane(_) if self.rows.len() <= 90 => 15.0,
            Row::Lane(_) => 12.0,
        }
    }

    /// Behind the headings, so that groups can be seen.
    fn shades(&self, first: f64) -> Group {
        let mut top = first;
        self.rows.iter().fold(Group::new(), |group, row| {
            let at = top;
            top += self.height(row);
            match row {
                Row::Heading(..) => group.add(bar((MARGIN, RIGHT), at, HEADING, SHADE)),
                Row::Lane(_) => group,
            }
        })
    }

    /// The scale: lines through rows and panels, with times above and below.
    fn grid(&self, first: f64, rows: f64, last: f64) -> Group {
        let mut group = Group::new();
        for tick in self.scale.ticks(self.scene.parameters) {
            let x = self.scale.place(tick.at);
            let colour = if tick.midnight { EDGE } else { RULE };
            group = group.add(line((x, first), (x, last), colour));
            for y in [first - 7.0, last + 16.0] {
                let label = text(x, y, &tick.label).set("text-anchor", "middle").set("fill", GREY);
                let weight = if tick.midnight { "bold" } else { "normal" };
                group = group.add(label.set("font-weight", weight));
            }
        }
        for y in [first, rows] {
            group = group.add(line((LEFT, y), (RIGHT, y), EDGE));
        }
        [first - 7.0, last + 16.0]
            .into_iter()
            .fold(group, |group, y| group.add(note(LEFT - 34.0, y, "local time of day")))
    }

    fn bands(&self, first: f64) -> Group {
        let (computer, radio) = (
            Place { top: first + 2.0, height: BAND },
            Place { top: first + 2.0 + BAND, height: BAND },
        );
        let name = |place: Place, name: &str| {
            text(MARGIN + 4.0, place.middle() + 3.7, name).set("font-weight", "bold")
        };
        Group::new()
            .add(name(computer, "Computer"))
            .add(computer::band(self.scene, computer, &self.scale))
            .add(name(radio, "Communication windows"))
            .add(computer::radio(self.scene, radio, &self.scale))
    }

    fn lanes(&self, first: f64) -> Group {
        let mut top = first;
        self.rows.iter().fold(Group::new(), |group, row| {
            let place = Place { top, height: self.height(row) };
            top += place.height;
            match row {
                Row::Heading(name, note) => group.add(heading(name, note, place)),
                Row::Lane(lane) => {
                    group.add(label(lane, place)).add(lane::draw(lane, place, &self.scale))
                }
            }
        })
    }

    fn curves(&self, first: f64) -> Group {
        let sleeps = computer::sleeps(&computer::awake(self.scene), &self.scale);
        let mut top = first;
        self.panels.iter().fold(Group::new(), |group, panel| {
            let at = top;
            top += panel.height + GAP;
            group.add(panel::draw(panel, at, (MARGIN + 4.0, LEFT - 12.0), &sleeps, &self.scale))
        })
    }

    /// Instants that the plan names.
    fn instants(&self, first: f64, last: f64) -> Group {
        let plan = self.scene.plan;
        let named = [(self.scene.state.now, "now"), (plan.handover, "handover"), (plan.end, "end")];
        let mut free = LEFT - 20.0;
        named.into_iter().fold(Group::new(), |group, (at, name)| {
            let Some((x, _)) = self.scale.seen(at, at) else { return group };
            let wire = line((x, first - 20.0), (x, last), INK).set("stroke-width", 1);
            let group = group.add(wire.set("stroke-dasharray", "1 3"));
            let wide = length(name) / 2.0;
            if x - wide < free {
                return group;
            }
            free = x + wide + 6.0;
            group.add(haloed(x, first - 23.0, name).set("text-anchor", "middle"))
        })
    }
}

fn heading(name: &str, note_of: &str, place: Place) -> Group {
    let y = place.middle() + 4.0;
    let name = text(MARGIN + 4.0, y, name).set("font-weight", "bold");
    Group::new().add(name).add(note(LEFT - 12.0, y, note_of))
}

fn label(lane: &lane::Lane, place: Place) -> Group {
    let y = place.middle() + 3.9;
    let name = shortened(&lane.label, LEFT - MARGIN - length(&lane.note) - 26.0);
    let weight = if lane.mandatory { "bold" } else { "normal" };
    let name = text(MARGIN + 10.0, y, &name).set("font-weight", weight).set("font-size", 11);
    Group::new().add(tip(&lane.label)).add(name).add(note(LEFT - 12.0, y, &lane.note))
}
