//! The picture: a histogram of each row, over one logarithmic axis of time.

use svg::Document;
use svg::node::Text as Words;
use svg::node::element::{Description, Group, Line, Rectangle, Text, Title};

use super::results::Played;
use super::rows::{Case, Expected};

// Okabe and Ito's colours, which colour-blind people can tell apart.
const OURS: &str = "#0072B2";
const PEER: &str = "#8C959F";
const WRONG: &str = "#C04F00";
const HOST: &str = "#007A5A";
const INK: &str = "#24292F";
const GREY: &str = "#57606A";
const RULE: &str = "#D0D7DE";

const LEGEND: &str = "Heights: the root of the part of the rounds. Black line: 99th percentile. Dashed: its target. \
                      Blue: gates of ours; grey: locks; red: cannot wait, or do not; green: the host alone.";

const LEFT: f64 = 240.0;
const RIGHT: f64 = 900.0;
const WIDTH: f64 = 960.0;
const ROW: f64 = 24.0;
/// The tallest bar of a row.
const TALL: f64 = 19.0;
const TOP: f64 = 28.0;
/// The powers of ten of a microsecond that the axis begins and ends with.
const AXIS: (i32, i32) = (-2, 4);
/// Bars to each power of ten.
const BARS: i32 = 12;

/// Draws all rows: the text of an SVG, the same for the same rows.
pub(crate) fn draw(played: &[Played]) -> String {
    let mut y = TOP;
    let mut rows = Group::new();
    for case in Case::ALL {
        let of_case: Vec<_> = played.iter().filter(|row| row.case == case).collect();
        if of_case.is_empty() {
            continue;
        }
        y += ROW * 0.75;
        rows = rows.add(text(8.0, y, case.title()).set("font-weight", "bold"));
        for row in of_case {
            y += ROW;
            rows = rows.add(draw_row(row, y));
        }
        y += ROW * 0.5;
    }
    let height = y + 24.0;
    let paper = Rectangle::new().set("width", WIDTH).set("height", height).set("fill", "white");
    let picture = Document::new()
        .set("viewBox", (0, 0, WIDTH, height))
        .set("width", WIDTH)
        .set("height", height)
        .set("role", "img")
        .set("font-family", "Helvetica, Arial, 'Liberation Sans', sans-serif")
        .set("font-size", 11.5)
        .set("fill", INK)
        .add(Title::new("How long each lock keeps the most important thread waiting"))
        .add(Description::new().add(Words::new(describe(played))))
        .add(paper)
        .add(axis(height))
        .add(rows)
        .add(text(8.0, height - 10.0, LEGEND).set("fill", GREY));
    format!("{picture}\n")
}

/// For those who do not see the picture.
fn describe(played: &[Played]) -> String {
    let row = |row: &Played| match row.measured.quantile_us(0.5) {
        Some(us) if !row.never() => format!("{}: median {us:.1} us.", row.name()),
        _ => format!("{}: never.", row.name()),
    };
    played.iter().map(row).collect::<Vec<_>>().join(" ")
}

fn x(us: f64) -> f64 {
    let (first, last) = (f64::from(AXIS.0), f64::from(AXIS.1));
    let part = (us.max(1e-9).log10().clamp(first, last) - first) / (last - first);
    tenth(LEFT + part * (RIGHT - LEFT))
}

fn tenth(place: f64) -> f64 {
    (place * 10.0).round() / 10.0
}

fn axis(height: f64) -> Group {
    let names = ["10 ns", "100 ns", "1 us", "10 us", "100 us", "1 ms", "10 ms"];
    (AXIS.0..).zip(names).fold(Group::new(), |axis, (power, name)| {
        let at = x(10_f64.powi(power));
        let name = text(at, TOP - 10.0, name).set("text-anchor", "middle");
        axis.add(line(at, (TOP - 4.0, height - 26.0), RULE)).add(name)
    })
}

fn draw_row(row: &Played, y: f64) -> Group {
    let colour = match row.expected {
        Expected::Ours(_) | Expected::OursLendingNone => OURS,
        Expected::Peer | Expected::PeerLendingNone => PEER,
        Expected::Spinning | Expected::Late => WRONG,
        Expected::Host => HOST,
    };
    let name = format!("{}, {}", row.who, row.placement.name());
    let group = Group::new().add(text(LEFT - 10.0, y, &name).set("text-anchor", "end"));
    if row.never() {
        return group.add(text(RIGHT, y, "never").set("fill", WRONG).set("text-anchor", "end"));
    }
    let group = bars(row).into_iter().fold(group, |group, (from, to, tall)| {
        let bar =
            Rectangle::new().set("x", from).set("width", tenth(to - from)).set("fill", colour);
        group.add(bar.set("y", tenth(y - tall)).set("height", tall))
    });
    let group = match row.measured.quantile_us(0.99) {
        Some(us) => group.add(line(x(us), (y - TALL, y), INK)),
        None => group,
    };
    let group = match row.target_us {
        Some(us) => {
            let target = line(x(f64::from(us)), (y - TALL, y), WRONG);
            group.add(target.set("stroke-dasharray", "3 2"))
        }
        None => group,
    };
    let wrong = format!("wrong in {} of {}", row.measured.late, row.measured.rounds());
    match row.measured.late {
        0 => group,
        _ => group.add(text(RIGHT, y, &wrong).set("fill", WRONG).set("text-anchor", "end")),
    }
}

/// Left, right and height of each bar. The height is the root of the part of
/// the rounds, so that a few late ones are seen.
fn bars(row: &Played) -> Vec<(f64, f64, f64)> {
    let edge = |bar: i32| 10_f64.powf(f64::from(bar) / f64::from(BARS));
    let bars = AXIS.0 * BARS..AXIS.1 * BARS;
    let parts = bars.map(|bar| (edge(bar), edge(bar + 1))).map(|(from, to)| {
        (x(from), x(to), tenth(TALL * row.measured.part_within(from, to).sqrt()))
    });
    parts.filter(|(.., tall)| *tall > 0.0).collect()
}

fn text(x: f64, y: f64, words: &str) -> Text {
    Text::new(words).set("x", tenth(x)).set("y", tenth(y))
}

fn line(x: f64, y: (f64, f64), colour: &str) -> Line {
    let line = Line::new().set("x1", x).set("x2", x).set("y1", tenth(y.0)).set("y2", tenth(y.1));
    line.set("stroke", colour)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::run::measured::Measured;
    use crate::run::rights::Placement;
    use crate::run::stage::Answer;

    fn played(expected: Expected, answer: Answer, late: u64) -> Played {
        let mut measured = Measured::new().expect("the bounds are in order");
        (1..=100).for_each(|us| measured.add(Duration::from_micros(us), true, answer));
        measured.late = late;
        let placement = Placement { holder_cpu: 0, revoker_cpu: 0 };
        let who = "Locked<parking_lot> gate";
        Played { case: Case::Command, who, expected, target_us: None, placement, measured }
    }

    #[test]
    fn the_bars_of_a_row_hold_all_its_rounds() {
        let bars = bars(&played(Expected::Peer, Answer::Done, 0));
        let parts: f64 = bars.iter().map(|(.., tall)| (tall / TALL).powi(2)).sum();
        assert!((parts - 1.0).abs() < 0.02, "{parts} of the rounds in {bars:?}");
    }

    #[test]
    fn what_cannot_wait_and_what_does_not_is_written_beside_it() {
        let never = draw(&[played(Expected::Spinning, Answer::GaveUp, 0)]);
        assert!(never.contains(">\nnever\n<"), "{never}");
        let wrong = draw(&[played(Expected::Late, Answer::Done, 7)]);
        assert!(wrong.contains("wrong in 7 of 100") && !wrong.contains(">\nnever\n<"));
    }

    #[test]
    fn names_are_words_and_not_markup() {
        let picture = draw(&[played(Expected::Peer, Answer::Done, 0)]);
        assert!(picture.contains("Locked&lt;parking_lot&gt; gate, one CPU"));
        assert!(!picture.contains("Locked<"));
    }
}
