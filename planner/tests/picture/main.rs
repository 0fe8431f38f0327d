//! The picture of a timed plan shows each activity, why it is left out, and the
//! timelines with their limits.

mod executed;
mod seen_first;

use std::collections::BTreeMap;

use faregate_planner::picture::{Scene, draw};
use faregate_planner::plan::{Outcome, StartRange};
use faregate_planner::state::{Mode, Window};
use faregate_planner::timed::{
    AwakePhase, Fate, Limit, Line, Preheat, Projection, Reason, Row, Slot,
};
use faregate_planner::trace::{Cause, Dispatch, Entry, Happened, Trace, Truth, Unstarted};
use faregate_planner::units::{Bytes, Ppm, Span, Time};
use faregate_planner::{Activity, ActivityId, Parameters, Plan, State, TimedPlan};
use faregate_tickets::amount::{Microjoules, Milliwatts};
use svg::parser::Event;

const MINUTE: i64 = 60_000;

fn at(minutes: i64) -> Time {
    Time::new(minutes * MINUTE)
}

fn id(number: u32) -> ActivityId {
    ActivityId::new(number).expect("not 0")
}

fn activity(number: u32, name: &str, priority: u32, minutes: i64) -> Activity {
    Activity {
        name: Some(name.into()),
        priority,
        starts: vec![StartRange { from: at(540), to: at(700), cutoff: at(800) }],
        ..Activity::new(id(number), Span::from_mins(minutes))
    }
}

fn plan() -> Plan {
    let drive = activity(1, "drive <north>", 90, 60);
    let zones = vec!["wheels".to_owned()];
    let mast = activity(2, "mast & more", 10, 30);
    Plan {
        name: "Sol 12".into(),
        handover: at(1_200),
        handover_min_soc: Ppm::new(600_000),
        end: at(1_440),
        max_delta_data: Bytes::new(50_000_000),
        activities: vec![Activity { zones, ..drive }, mast],
        ..Plan::default()
    }
}

fn parameters() -> Parameters {
    Parameters {
        mandatory_from: 50,
        soft_min_soc: Ppm::new(400_000),
        hard_min_soc: Ppm::new(300_000),
        max_soc: Ppm::new(950_000),
        peak_limit: Milliwatts::new(400_000),
        ..Parameters::default()
    }
}

fn state() -> State {
    let radio = Window {
        name: "overflight".into(),
        start: at(1_000),
        end: at(1_015),
        awake: false,
        marginal: Milliwatts::ZERO,
        peak: Milliwatts::ZERO,
        data: Bytes::ZERO,
        engines: 0,
        resources: faregate_agents::Categories::NONE,
    };
    State {
        now: at(480),
        capacity: Microjoules::new(1_000),
        windows: vec![radio],
        ..State::default()
    }
}

fn timed() -> TimedPlan {
    let reason = Reason::Limit {
        limit: Limit::SoftMinimum,
        at: at(610),
        amount: 36_000_000_000,
        with: None,
    };
    TimedPlan {
        rows: vec![
            Row {
                id: id(1),
                fate: Fate::Scheduled(Slot { start: at(600), end: at(660), range: 0 }),
            },
            Row { id: id(2), fate: Fate::Out(reason) },
        ],
        awake: vec![AwakePhase { wakeup: at(560), up: at(565), down: at(660), asleep: at(665) }],
        preheats: vec![Preheat { zone: "wheels".into(), start: at(570), end: at(600) }],
        ..TimedPlan::default()
    }
}

fn projection() -> Projection {
    let line = |name: &str, steps, points: &[(i64, i64)]| Line {
        name: name.into(),
        unit: String::new(),
        steps,
        points: points.iter().map(|(minute, value)| (at(*minute), *value)).collect(),
    };
    Projection {
        lines: vec![
            line("charge", false, &[(480, 700), (560, 800), (660, 450), (1_440, 940)]),
            line("peak", true, &[(480, 0), (560, 60_000), (600, 350_000), (660, 0)]),
            line("data", true, &[(480, 0), (600, 20_000_000)]),
        ],
    }
}

fn drawn(plan: &Plan, timed: &TimedPlan, trace: Option<&Trace>) -> String {
    let (parameters, state, projection) = (parameters(), state(), projection());
    let scene = Scene {
        plan,
        parameters: &parameters,
        state: &state,
        timed,
        projection: &projection,
        trace,
    };
    draw(&scene)
}

/// The texts that can be read, and how often. Fails on what is no XML.
fn texts(picture: &str) -> BTreeMap<String, usize> {
    let mut texts = BTreeMap::new();
    let mut depth = 0_i64;
    for event in svg::read(picture).expect("a document") {
        match event {
            Event::Error(error) => panic!("{error}"),
            Event::Tag(_, svg::node::element::tag::Type::Start, _) => depth += 1,
            Event::Tag(_, svg::node::element::tag::Type::End, _) => depth -= 1,
            Event::Text(text) => *texts.entry(text.trim().to_owned()).or_default() += 1,
            _ => {}
        }
    }
    assert_eq!(depth, 0, "every element is closed");
    texts
}

#[test]
fn a_left_out_activity_shows_its_reason_and_a_scheduled_one_its_times() {
    let texts = texts(&drawn(&plan(), &timed(), None));
    let has = |words: &str| texts.contains_key(words);
    assert!(has("10 Wh below the soft minimum of charge at 10:10"), "{texts:#?}");
    assert!(has("1  drive &lt;north&gt;: 10:00 to 11:00 (1 h)"), "{texts:#?}");
    assert!(has("2  mast &amp; more"), "{texts:#?}");
    assert!(has("08:00 to 24:00; 1 activity scheduled, 1 left out"), "{texts:#?}");
}

#[test]
fn limits_stand_beside_their_timelines_with_their_values() {
    let texts = texts(&drawn(&plan(), &timed(), None));
    for limit in ["maximum 95 %", "soft minimum 40 %", "hard minimum 30 %", "handover 60 %"] {
        assert!(texts.contains_key(limit), "{limit}: {texts:#?}");
    }
    assert!(texts.contains_key("limit 400 W"), "{texts:#?}");
    assert!(texts.contains_key("limit 50 MB"), "{texts:#?}");
}

#[test]
fn the_legend_has_what_is_in_the_picture_and_nothing_else() {
    let all = texts(&drawn(&plan(), &timed(), None));
    for sign in ["mandatory", "heats", "where it does not fit"] {
        assert!(all.contains_key(sign), "{sign}: {all:#?}");
    }
    for sign in ["expanded", "optional", "paused", "planned"] {
        assert!(!all.contains_key(sign), "{sign}: {all:#?}");
    }
    let mut timed = timed();
    timed.rows[1].fate = Fate::Scheduled(Slot { start: at(600), end: at(640), range: 0 });
    let all = texts(&drawn(&plan(), &timed, None));
    assert!(all.contains_key("optional") && all.contains_key("expanded"), "{all:#?}");
}

fn trace() -> Trace {
    let entry = |minute, what| Entry { at: at(minute), what };
    let dispatched = Dispatch {
        id: id(1),
        range: 0,
        ends: at(650),
        early: true,
        zones: Vec::new(),
        variables: Vec::new(),
    };
    let truth = Truth {
        charge: Microjoules::new(700),
        load: Milliwatts::ZERO,
        peak: Milliwatts::ZERO,
        engines: 0,
        data: Bytes::ZERO,
    };
    let planned = Happened::Planned {
        why: Vec::new(),
        state: Box::new(State { mode: Mode::Asleep, ..state() }),
        timed: Box::new(timed()),
    };
    let mut last = timed();
    last.rows[1].fate = Fate::Out(Reason::NoRangeLeft);
    let planned_again = Happened::Planned {
        why: Vec::new(),
        state: Box::new(State { mode: Mode::Asleep, ..state() }),
        timed: Box::new(last),
    };
    Trace {
        begin: at(480),
        end: at(1_440),
        windows: state().windows,
        entries: vec![
            entry(480, planned),
            entry(480, Happened::Truth(truth)),
            entry(550, Happened::Mode(Mode::WakingUp)),
            entry(555, Happened::Mode(Mode::Awake)),
            entry(590, Happened::Dispatched(Box::new(dispatched))),
            entry(600, Happened::Paused(id(1))),
            entry(610, Happened::Resumed(id(1))),
            entry(640, Happened::Aborted { id: id(1), cause: Cause::HardLimit, data: Bytes::ZERO }),
            entry(640, Happened::Mode(Mode::ShuttingDown)),
            entry(645, Happened::Mode(Mode::Asleep)),
            entry(690, planned_again),
            entry(700, Happened::NotStarted { id: id(2), why: Unstarted::NotPlanned }),
        ],
        ..Trace::default()
    }
}

#[test]
fn an_execution_is_drawn_over_its_plan() {
    let all = texts(&drawn(&plan(), &timed(), Some(&trace())));
    let signs = ["planned", "paused", "started early", "aborted, failed"];
    for words in signs.into_iter().chain(["aborted: hard limit of charge"]) {
        assert!(all.contains_key(words), "{words}: {all:#?}");
    }
    assert!(all.contains_key("10 Wh below the soft minimum of charge at 10:10"), "{all:#?}");
    for piece in ["09:50 to 10:00", "10:10 to 10:40"] {
        assert!(all.contains_key(&format!("1  drive &lt;north&gt;: {piece}")), "{piece}: {all:#?}");
    }
    assert!(all.contains_key("wakes up 09:10, is up 09:15 to 10:40, asleep 10:45"), "{all:#?}");
}

#[test]
fn what_ended_before_is_drawn_from_the_state() {
    let mut timed = timed();
    timed.rows[1].fate = Fate::Ended(Outcome::Failed);
    let (plan, parameters, projection) = (plan(), parameters(), projection());
    let mut state = state();
    state.ended.push(faregate_planner::state::Ended {
        id: id(2),
        outcome: Outcome::Failed,
        started: Some(at(400)),
        ended: at(420),
        data: Bytes::ZERO,
    });
    let picture = draw(&Scene {
        plan: &plan,
        parameters: &parameters,
        state: &state,
        timed: &timed,
        projection: &projection,
        trace: None,
    });
    assert!(texts(&picture).contains_key("activity 2: 06:40 to 07:00"), "{picture}");
}

#[test]
fn a_plan_of_thousands_is_packed_into_few_rows() {
    let (mut plan, mut timed) = (plan(), timed());
    plan.activities = (1..=2_000).map(|number| activity(number, "short", 10, 1)).collect();
    timed.rows = (1..=2_000)
        .map(|number| {
            let start = Time::new(i64::from(number) * 40_000 + 29_000_000);
            let slot = Slot { start, end: start.after(Span::from_mins(1)), range: 0 };
            Row { id: id(number), fate: Fate::Scheduled(slot) }
        })
        .collect();
    let picture = drawn(&plan, &timed, None);
    let height = picture.split("height=\"").nth(1).and_then(|rest| rest.split('"').next());
    let height: f64 = height.and_then(|height| height.parse().ok()).expect("a height");
    assert!(height < 800.0, "{height}");
}
