//! The legend: each sign that is in the picture, and no other.

use svg::node::element::Group;

use crate::picture::lane::{self, Bar, Ending, Lane, Place};
use crate::picture::pen::{GREY, SMALL, length, text};
use crate::picture::rows::Row;
use crate::picture::scale::Scale;
use crate::units::Time;

/// Wide enough for every sign.
const SIGN: f64 = 28.0;

pub(super) fn draw(rows: &[Row], (left, middle): (f64, f64)) -> Group {
    let lanes: Vec<&Lane> = rows
        .iter()
        .filter_map(|row| match row {
            Row::Lane(lane) => Some(lane),
            Row::Heading(..) => None,
        })
        .collect();
    let mut x = left;
    let mut group = Group::new();
    for Sign { words, lane, is_in } in signs() {
        if lanes.iter().any(|other| is_in(other)) {
            let said = text(x + SIGN + 7.0, middle + 3.7, words);
            let said = said.set("fill", GREY).set("font-size", SMALL);
            group = group.add(sample(&lane, x, middle)).add(said);
            x += SIGN + length(words) * 0.93 + 24.0;
        }
    }
    group
}

/// The sign as the rows draw it.
fn sample(lane: &Lane, x: f64, middle: f64) -> Group {
    let scale = Scale::new(Time::ZERO, Time::new(10), (x, x + SIGN));
    lane::draw(lane, Place { top: middle - 9.0, height: 18.0 }, &scale)
}

/// A thing that can be in a picture.
struct Sign {
    words: &'static str,
    /// A row that has nothing else.
    lane: Lane,
    is_in: fn(&Lane) -> bool,
}

fn piece(from: i64, mandatory: bool) -> Bar {
    Bar {
        span: (Time::new(from), Time::new(10)),
        minimum: None,
        mandatory,
        ending: Ending::Quiet,
        early: false,
        words: String::new(),
        tip: String::new(),
    }
}

fn signs() -> [Sign; 11] {
    let whole = (Time::ZERO, Time::new(10));
    let bar = |bar| Lane { bars: vec![bar], ..Lane::default() };
    let ends = |ending| bar(Bar { ending, ..piece(0, true) });
    let ranges = vec![(Time::ZERO, Time::new(6), Time::new(10))];
    let ranges = Lane { ranges, ..Lane::default() };
    let heat = vec![(Time::ZERO, Time::new(10))];
    let middle = Some(Time::new(5));
    [
        Sign {
            words: "can start, until cutoff",
            lane: ranges,
            is_in: |lane| !lane.ranges.is_empty(),
        },
        Sign {
            words: "heats",
            lane: Lane { preheats: heat, ..Lane::default() },
            is_in: |lane| !lane.preheats.is_empty(),
        },
        Sign {
            words: "mandatory",
            lane: bar(piece(0, true)),
            is_in: |lane| has(lane, |bar| bar.mandatory),
        },
        Sign {
            words: "optional",
            lane: bar(piece(0, false)),
            is_in: |lane| has(lane, |bar| !bar.mandatory),
        },
        Sign {
            words: "expanded",
            lane: bar(Bar { minimum: Some(Time::new(3)), ..piece(0, true) }),
            is_in: |lane| has(lane, |bar| bar.minimum.is_some()),
        },
        Sign {
            words: "planned",
            lane: Lane { planned: vec![whole], ..Lane::default() },
            is_in: |lane| !lane.planned.is_empty(),
        },
        Sign {
            words: "paused",
            lane: Lane { pauses: vec![whole], ..Lane::default() },
            is_in: |lane| !lane.pauses.is_empty(),
        },
        Sign {
            words: "started early",
            lane: bar(Bar { early: true, ..piece(3, true) }),
            is_in: |lane| has(lane, |bar| bar.early),
        },
        Sign {
            words: "ended early",
            lane: bar(Bar {
                ending: Ending::Early,
                span: (Time::ZERO, Time::new(6)),
                ..piece(0, true)
            }),
            is_in: |lane| has(lane, |bar| bar.ending == Ending::Early),
        },
        Sign {
            words: "aborted, failed",
            lane: ends(Ending::Aborted),
            is_in: |lane| has(lane, |bar| matches!(bar.ending, Ending::Aborted | Ending::Failed)),
        },
        Sign {
            words: "where it does not fit",
            lane: Lane { out: Some((String::new(), middle)), ..Lane::default() },
            is_in: |lane| lane.out.as_ref().is_some_and(|(_, at)| at.is_some()),
        },
    ]
}

fn has(lane: &Lane, what: fn(&Bar) -> bool) -> bool {
    lane.bars.iter().any(what)
}
