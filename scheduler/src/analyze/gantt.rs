//! The picture of an analysis: what waits, runs, stands still and is missed,
//! and when, as SVG.

mod dense;
mod lane;
mod legend;
mod pen;
mod rows;
mod scale;

use svg::Document;
use svg::node::element::Group;

use crate::analyze::gantt::lane::Place;
use crate::analyze::gantt::pen::{
    EDGE, GREY, MARGIN, RULE, SHADE, bar, hatch, length, line, note, sheet, shortened, text,
};
use crate::analyze::gantt::rows::{Lane, Row, rows};
use crate::analyze::gantt::scale::{Scale, say};
use crate::analyze::report::Analysis;
use crate::time::Duration;

/// How a picture is to look.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// What stands above it.
    pub title: String,
    /// Until when it is drawn; none: until the last thing has ended, or the
    /// horizon.
    pub until: Option<Duration>,
    /// What the rows are.
    pub rows: Rows,
}

/// What the rows of a picture are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rows {
    /// Tasks; if they are too many for a picture, categories.
    #[default]
    Fitting,
    /// One for each task, under the first of its categories.
    Tasks,
    /// One for each category.
    Categories,
}

const WIDTH: f64 = 1_100.0;
/// Where the scale begins and ends.
const LEFT: f64 = 236.0;
const RIGHT: f64 = WIDTH - 26.0;
/// The title, what is said below it, and the legend.
const HEAD: f64 = 84.0;
/// The numbers of the scale, above and below the rows.
const NUMBERS: f64 = 26.0;
const HEADING: f64 = 22.0;
/// Rows are lower where there are many.
const HEIGHTS: [(usize, f64); 3] = [(12, 24.0), (48, 20.0), (usize::MAX, 14.0)];

/// Draws an analysis: the text of an SVG, the same for the same analysis.
#[must_use]
pub fn gantt(analysis: &Analysis, look: &Look) -> String {
    let rows = rows(analysis, look.rows);
    let until = look.until.unwrap_or_else(|| ends_at(&rows, analysis));
    let picture = Picture { rows, scale: Scale::new(until, LEFT, RIGHT) };
    format!("{}\n", picture.draw(analysis, look))
}

/// The horizon, or earlier when everything ends long before; later when gaps
/// are left.
fn ends_at(rows: &[Row], analysis: &Analysis) -> Duration {
    let lanes = || {
        rows.iter().filter_map(|row| match row {
            Row::Lane(lane) => Some(lane),
            Row::Heading(..) => None,
        })
    };
    let horizon = analysis.horizon;
    let gaps = lanes().flat_map(|lane| &lane.gaps).map(|gap| gap.1).max().unwrap_or_default();
    let ends = lanes().flat_map(|lane| {
        let spans = lane.waits.iter().chain(&lane.windows).map(|span| span.1);
        let runs = lane.runs.iter().map(|bar| bar.span.1);
        spans.chain(runs).chain(lane.misses.iter().copied())
    });
    let last = ends.max().unwrap_or(horizon).max(gaps);
    if last < long_before(horizon) { last } else { horizon.max(gaps) }
}

/// Nine tenths: what ends later would leave a scale that nearly ends at a round
/// number.
fn long_before(horizon: Duration) -> Duration {
    Duration::from_micros(horizon.as_micros() / 10 * 9)
}

struct Picture {
    rows: Vec<Row>,
    scale: Scale,
}

impl Picture {
    fn draw(&self, analysis: &Analysis, look: &Look) -> Document {
        let (first, last) = (HEAD + NUMBERS, HEAD + NUMBERS + self.height_of_rows());
        let height = last + NUMBERS + MARGIN;
        let title = if look.title.is_empty() { "Schedule" } else { &look.title };
        let about = self.about(analysis);
        sheet((WIDTH, height), (title, &about), [hatch()])
            .add(legend::draw(&self.rows, &self.scale, (MARGIN, 70.0)))
            .add(self.shades(first))
            .add(self.grid(first, last))
            .add(self.lanes(first))
    }

    fn about(&self, analysis: &Analysis) -> String {
        let tasks = analysis.tasks.len();
        let mut about = match tasks {
            1 => "1 task".to_owned(),
            _ => format!("{tasks} tasks"),
        };
        if let Some(makespan) = analysis.makespan {
            about.push_str(&format!("; the last one-shot ends at {}", say(makespan)));
        }
        match analysis.problems.len() {
            0 => about.push_str("; no problems"),
            1 => about.push_str("; 1 problem"),
            count => about.push_str(&format!("; {count} problems")),
        }
        about
    }

    fn row_height(&self) -> f64 {
        let lanes = self.rows.iter().filter(|row| matches!(row, Row::Lane(_))).count();
        let fitting = HEIGHTS.iter().find(|(most, _)| lanes <= *most);
        fitting.map_or(14.0, |(_, height)| *height)
    }

    fn height(&self, row: &Row) -> f64 {
        match row {
            Row::Heading(..) => HEADING,
            Row::Lane(_) => self.row_height(),
        }
    }

    fn height_of_rows(&self) -> f64 {
        self.rows.iter().map(|row| self.height(row)).sum()
    }

    /// Behind the headings, so that groups can be seen.
    fn shades(&self, first: f64) -> Group {
        let mut top = first;
        self.rows.iter().fold(Group::new(), |group, row| {
            let height = self.height(row);
            let at = top;
            top += height;
            match row {
                Row::Heading(..) => group.add(bar((MARGIN, RIGHT), at, height, SHADE)),
                Row::Lane(_) => group,
            }
        })
    }

    /// The scale: lines through all rows, with numbers above and below.
    fn grid(&self, first: f64, last: f64) -> Group {
        let (unit, ticks) = self.scale.ticks();
        let mut group = Group::new();
        for (at, number) in ticks {
            let x = self.scale.place(at);
            group = group.add(line((x, first), (x, last), RULE));
            for y in [first - 7.0, last + 16.0] {
                let number = text(x, y, &number.to_string()).set("text-anchor", "middle");
                group = group.add(number.set("fill", GREY));
            }
        }
        for y in [first, last] {
            group = group.add(line((LEFT, y), (RIGHT, y), EDGE));
        }
        for y in [first - 7.0, last + 16.0] {
            let unit = format!("time since the load, {}", unit.name);
            let unit = text(LEFT - 12.0, y, &unit).set("text-anchor", "end").set("fill", GREY);
            group = group.add(unit);
        }
        group
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
}

fn heading(name: &str, beside: &str, place: Place) -> Group {
    let y = place.top + place.height / 2.0 + 4.0;
    let name = shortened(name, LEFT - MARGIN - length(beside) - 16.0);
    let name = text(MARGIN + 4.0, y, &name).set("font-weight", "bold");
    Group::new().add(name).add(note(LEFT - 12.0, y, beside))
}

fn label(lane: &Lane, place: Place) -> Group {
    let y = place.top + place.height / 2.0 + 4.0;
    let name = shortened(&lane.label, LEFT - MARGIN - length(&lane.note) - 26.0);
    Group::new().add(text(MARGIN + 10.0, y, &name)).add(note(LEFT - 12.0, y, &lane.note))
}
