//! The picture of a schedule.

mod support;

use std::collections::HashMap;

use faregate_scheduler::analyze::{Analysis, Look, Options, Rows, analyze, gantt};
use faregate_scheduler::mission::Mission;
use faregate_scheduler::task::{CheckpointSignal, Preemption, Task, When};
use svg::node::Value;
use svg::node::element::tag::Type;
use svg::parser::Event;

use support::{analysis, due, every, s, task, until, week};

/// Everything that a picture can show.
fn rich() -> Vec<Task> {
    let grace = s(4);
    let named = |mut task: Task, name: &str| {
        task.name = Some(name.into());
        task
    };
    let mut survey = named(every(task(1, 12, 0b001, 5), 30), "survey");
    survey = until(survey, 6);
    let mut spectrum = named(due(task(2, 25, 0b001, 3), 14), "spectrum");
    spectrum.preemption = Preemption::Checkpoint { grace, signal: CheckpointSignal::default() };
    let mut stars = named(due(task(3, 20, 0b001, 2), 42), "star field");
    stars.preemption = Preemption::Kill { grace };
    let mut slew = named(due(task(4, 10, 0b010, 8), 8), "slew");
    slew.gap = s(6);
    let calibrate = named(due(task(5, 30, 0b010, 4), 2), "calibrate");
    let mut compress = named(due(task(6, 40, 0b100, 4), 20), "compress");
    compress.cutoff = When::AfterLoad(s(50));
    let late = named(until(due(task(7, 10, 0b100, 2), 25), 45), "late look");
    let beacon = named(every(task(8, 1, 0, 9), 10), "beacon");
    let long = named(due(task(9, 100, 0b1000, 2), 60), "long exposure with a name that is long");
    vec![survey, spectrum, stars, slew, calibrate, compress, late, beacon, long]
}

fn picture(analysis: &Analysis, rows: Rows) -> String {
    gantt(analysis, &Look { title: "Two minutes".into(), rows, ..Look::default() })
}

fn of(tasks: &[Task], horizon: u64) -> String {
    picture(&analysis(tasks, &Mission::default(), horizon), Rows::Tasks)
}

/// Everything between the tags: what a reader sees.
fn words(picture: &str) -> Vec<&str> {
    let ends = picture.split('>').filter_map(|part| part.split_once('<'));
    ends.map(|(words, _)| words.trim()).filter(|words| !words.is_empty()).collect()
}

const LEGEND: [&str; 9] = [
    "window",
    "waits",
    "runs",
    "paused",
    "to be run again",
    "failed or ended",
    "goes on",
    "gap",
    "missed",
];

fn legend(picture: &str) -> Vec<&str> {
    words(picture).into_iter().filter(|word| LEGEND.contains(word)).collect()
}

/// The attributes of all elements of this name, which must be well-formed.
fn elements(picture: &str, name: &str) -> Vec<HashMap<String, String>> {
    let mut found = Vec::new();
    let mut depth = 0_i32;
    for event in svg::read(picture).unwrap() {
        match event {
            Event::Tag(tag, kind, attributes) => {
                depth += match kind {
                    Type::Start => 1,
                    Type::End => -1,
                    Type::Empty => 0,
                };
                if tag == name && kind != Type::End {
                    let text = |(key, value): (String, Value)| (key, value.to_string());
                    found.push(attributes.into_iter().map(text).collect());
                }
            }
            Event::Error(error) => panic!("{error}"),
            _ => {}
        }
    }
    assert_eq!(depth, 0, "every element is closed");
    found
}

/// From and until of every bar in this colour, below the legend.
fn bars(picture: &str, colour: &str) -> Vec<(f64, f64)> {
    let number = |bar: &HashMap<String, String>, key: &str| bar[key].parse::<f64>().unwrap();
    let bars = elements(picture, "rect").into_iter();
    bars.filter(|bar| bar["fill"] == colour && number(bar, "y") > 84.0)
        .map(|bar| (number(&bar, "x"), number(&bar, "x") + number(&bar, "width")))
        .collect()
}

const RUN: &str = "#0072B2";
const WAIT: &str = "#E69F00";
/// Where the scale begins and ends.
const SCALE: (f64, f64) = (236.0, 1_074.0);

fn place(second: f64, of: f64) -> f64 {
    let place = SCALE.0 + (SCALE.1 - SCALE.0) * second / of;
    (place * 10.0).round() / 10.0
}

fn is_at((from, until): (f64, f64), (start, end): (f64, f64), of: f64) -> bool {
    (from - place(start, of)).abs() < 0.11 && (until - place(end, of)).abs() < 0.11
}

#[test]
fn windows_waits_runs_pauses_ends_and_misses_have_signs_of_their_own() {
    assert_eq!(legend(&of(&rich(), 120)), LEGEND);
}

#[test]
fn a_sign_that_is_not_in_the_picture_is_not_explained() {
    assert_eq!(legend(&of(&[task(1, 5, 1, 1)], 10)), ["runs"]);
    assert_eq!(legend(&of(&[task(1, 5, 1, 2), task(2, 5, 1, 1)], 10)), ["waits", "runs"]);
}

#[test]
fn bars_stand_where_the_scale_says() {
    let picture = of(&[task(1, 5, 1, 2), task(2, 5, 1, 1)], 10);
    let [first, second] = bars(&picture, RUN)[..] else { panic!("{picture}") };
    assert!(is_at(first, (0.0, 5.0), 10.0), "{first:?}");
    assert!(is_at(second, (5.0, 10.0), 10.0), "{second:?}");
    let [wait] = bars(&picture, WAIT)[..] else { panic!("{picture}") };
    assert!(is_at(wait, (0.0, 5.0), 10.0), "{wait:?}");
}

#[test]
fn a_pause_stands_between_the_pieces_of_its_run() {
    let picture = of(&[task(1, 20, 1, 1), due(task(2, 6, 1, 5), 5)], 26);
    let [pause] = bars(&picture, "url(#still)")[..] else { panic!("{picture}") };
    assert!(is_at(pause, (5.0, 11.0), 26.0), "{pause:?}");
    let runs = bars(&picture, RUN);
    assert!(runs.iter().any(|run| is_at(*run, (11.0, 26.0), 26.0)), "{runs:?}");
}

#[test]
fn a_miss_is_a_cross_where_its_window_closed() {
    let picture = of(&[task(1, 20, 1, 2), until(task(2, 5, 1, 1), 12)], 20);
    let crosses = elements(&picture, "path").into_iter().map(|path| path["d"].clone());
    let at = format!("M{},", ((place(12.0, 20.0) - 3.6) * 10.0).round() / 10.0);
    let crosses: Vec<_> = crosses.collect();
    assert!(crosses.iter().any(|cross| cross.starts_with(&at)), "{at} {crosses:?}");
}

#[test]
fn each_task_has_a_row_under_its_category() {
    let picture = of(&rich(), 120);
    let words = words(&picture);
    let rows =
        ["category 0 (con 1)", "1  survey", "3  star field", "category 1 (con 2)", "4  slew"];
    let mut places = rows.map(|row| words.iter().position(|word| *word == row));
    assert!(places.iter().all(Option::is_some), "{places:?} {words:?}");
    let before = places;
    places.sort_unstable();
    assert_eq!(places, before, "in this order");
}

#[test]
fn the_scale_has_a_unit_and_round_numbers() {
    let picture = of(&rich(), 120);
    let words = words(&picture);
    assert!(words.contains(&"time since the load, s"));
    for number in ["0", "10", "110", "120"] {
        assert!(words.contains(&number), "{number}");
    }
}

#[test]
fn the_same_schedule_gives_the_same_bytes() {
    assert_eq!(of(&rich(), 120), of(&rich(), 120));
    assert_ne!(of(&rich(), 120), of(&rich(), 121));
}

#[test]
fn a_name_cannot_break_the_picture() {
    let mut named = task(1, 5, 1, 1);
    named.name = Some("<b>&\"'".into());
    let picture = of(&[named], 10);
    assert_eq!(elements(&picture, "b"), []);
    assert!(words(&picture).iter().any(|word| word.contains("&lt;b")), "{picture}");
}

#[test]
fn a_schedule_of_no_tasks_has_a_picture() {
    let picture = of(&[], 0);
    assert!(words(&picture).iter().any(|word| word.starts_with("0 tasks")));
    assert_eq!(bars(&picture, RUN), []);
}

/// Thousands of runs in a row of a thousand pixels are shades, and the file
/// stays small.
#[test]
fn a_week_of_a_satellite_is_drawn_by_category() {
    let options = Options { horizon: Some(week::ENDS), ..Options::default() };
    let analysis = analyze(&week::tasks(), &week::mission(), &options).unwrap();
    let picture = gantt(&analysis, &Look::default());
    assert!(picture.len() < 300_000, "{} bytes", picture.len());
    let words = words(&picture);
    let rows = words.iter().filter(|word| word.starts_with("category ")).count();
    assert_eq!(rows, analysis.utilisation.categories.len());
    assert!(
        words.contains(&"paler: part of the time") && words.contains(&"time since the load, d")
    );
}

/// A minute's task over a day is an even shade: not a solid bar, which would
/// say that it always runs.
#[test]
fn a_routine_task_of_a_day_is_not_drawn_as_if_it_always_ran() {
    let picture = of(&[every(task(1, 20, 1, 1), 60)], 86_400);
    let shades = elements(&picture, "rect").into_iter().filter(|bar| bar["fill"] == RUN);
    let shades: Vec<f64> = shades.filter_map(|bar| bar.get("fill-opacity")?.parse().ok()).collect();
    assert!(!shades.is_empty());
    assert!(shades.iter().all(|shade| *shade < 0.8), "{shades:?}");
}
