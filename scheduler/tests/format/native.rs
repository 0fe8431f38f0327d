//! The native format.

use faregate_agents::Categories;
use faregate_scheduler::format::{self, Against, Options, Rule};
use faregate_scheduler::task::{
    Body, CheckpointSignal, Dependency, Overrun, Preemption, Restart, Spread, Status, When, Window,
};
use faregate_scheduler::time::{Duration, UnixTime};
use faregate_scheduler::{Mission, TaskId};
use faregate_tickets::amount::Milliwatts;

use crate::support::{bad, good, only, told};

const EVERYTHING: &str = include_str!("everything.toml");

fn secs(s: u64) -> Duration {
    Duration::from_secs(s)
}

#[test]
fn every_field_of_a_task_can_be_said() {
    let tasks = good("everything.toml", EVERYTHING).tasks;
    let task = &tasks[0];
    assert_eq!(task.name.as_deref(), Some("image the coast"));
    let at = |s| When::At(UnixTime::from_secs(s));
    let windows = [
        Window { opens: at(1_772_366_400), closes: at(1_772_366_700) },
        Window { opens: When::AfterLoad(secs(5_400)), closes: When::Unrestricted },
    ];
    assert_eq!(task.windows, windows);
    assert_eq!(task.cutoff, When::AfterLoad(secs(7_200)));
    assert_eq!(task.duration, Duration::from_millis(1_500));
    let spread = Spread { shortest: secs(1), longest: secs(3) };
    assert_eq!((task.spread, task.interval), (Some(spread), Some(secs(86_400))));
    assert_eq!(task.categories, Categories::from_mask(0b1_0011));
    assert_eq!((task.priority.level(), task.battery, task.mandatory), (120, 20, true));
    assert_eq!((task.memory, task.storage, task.data), (3 << 20, 1_500_000_000, 2_048));
    let draws = (Milliwatts::new(4_500), Milliwatts::new(3_250));
    assert_eq!((task.peak_draw, task.average_draw), draws);
    assert_eq!(task.gates, ["camera", "gimbal"]);
    assert_eq!((task.gap, task.heartbeat), (secs(2), Some(secs(10))));
    let grace = secs(4);
    let checkpoint = Preemption::Checkpoint { grace, signal: CheckpointSignal::User2 };
    assert_eq!(task.preemption, checkpoint);
    assert_eq!(task.restart, Restart::OnFailure { limit: 3, back_off: Duration::from_millis(250) });
    assert_eq!(task.overrun, Overrun::AbortAndRestart);
    let after = |id, status| Dependency { task: TaskId::new(id).unwrap(), status };
    assert_eq!(task.after, [after(2, Status::Succeeded), after(3, Status::Finished)]);
    assert_eq!(task.cleanup, TaskId::new(4));
}

#[test]
fn every_body_can_be_said() {
    let bodies: Vec<Body> =
        good("everything.toml", EVERYTHING).tasks.into_iter().map(|task| task.body).collect();
    let kinds: Vec<&str> = bodies
        .iter()
        .map(|body| match body {
            Body::Process { .. } => "process",
            Body::Function { .. } => "function",
            Body::Sequence(_) => "sequence",
            Body::Hold => "hold",
            Body::BuiltIn(_) => "built-in",
        })
        .collect();
    let built_ins = ["built-in"; 6];
    assert_eq!(kinds[..4], ["process", "function", "sequence", "hold"]);
    assert_eq!(kinds[4..], built_ins);
    let Body::Sequence(steps) = &bodies[2] else { panic!("{:?}", bodies[2]) };
    assert_eq!((steps.len(), steps[1].offset, steps[1].continues), (2, secs(90), true));
    assert_eq!(steps[1].arguments, ["45", "north east"]);
}

#[test]
fn a_mission_can_be_said() {
    let mission = good("everything.toml", EVERYTHING).mission.unwrap();
    assert_eq!(mission.agents[0].supply, Some(Milliwatts::from_watts(42)));
    assert_eq!(mission.devices[0].categories, Categories::from_mask(1));
    assert_eq!(mission.devices[0].parameters["lag"], "2s");
    assert_eq!(mission.devices[0].parameters["gain"], "1.5");
    assert_eq!(mission.modes[0].reserves, ["camera"]);
    assert_eq!(mission.battery.unwrap().low, 15);
    assert_eq!((mission.memory, mission.memory_low), (Some(512 << 20), Some(64 << 20)));
    assert_eq!((mission.waiting_requests, mission.lease), (8, secs(3)));
}

#[test]
fn what_is_not_said_has_smaartes_defaults() {
    let task = only("a.toml", "[[task]]\nid = 1\nrun = \"sleep 3\"\n");
    let body = Body::Process { program: "sleep".into(), arguments: vec!["3".into()] };
    assert_eq!(task, faregate_scheduler::Task::new(TaskId::new(1).unwrap(), body));
}

#[test]
fn categories_have_the_names_of_the_mission_that_is_given() {
    let mission = good("everything.toml", EVERYTHING).mission.unwrap();
    let text = "[[task]]\nid = 1\nhold = true\ncon = [\"radio\"]\n";
    let options = Options { against: Against::Mission(&mission), ..Options::default() };
    let tasks = format::read_with(options, "a.toml", text.as_bytes()).unwrap().tasks;
    assert_eq!(tasks[0].categories, Categories::from_mask(0b1_0000));
    assert_eq!(bad("a.toml", text), [(4, 8, Rule::UnknownName)]);
    let two = format::read_with(options, "b.toml", EVERYTHING.as_bytes()).unwrap_err();
    assert!(told(&two).contains(&(1, 1, Rule::Duplicate)));
}

#[test]
fn an_unknown_key_is_told_with_the_one_that_is_meant() {
    let text = "[[task]]\nid = 1\nrun = \"true\"\nstart_time = 5\nprioritty = 3\n[mision]\n";
    let found = format::read("a.toml", text.as_bytes()).unwrap_err();
    assert_eq!(told(&found), [(4, 1, Rule::Unknown), (5, 1, Rule::Unknown), (6, 2, Rule::Unknown)]);
    let help: Vec<_> = found.iter().map(|one| one.help.as_deref().unwrap()).collect();
    assert_eq!(help, ["did you mean st?", "did you mean pri?", "did you mean mission?"]);
}

#[test]
fn every_wrong_value_is_told_at_its_place() {
    let text = "[[task]]\n\
                id = 0\n\
                run = [\"a\", 3]\n\
                dur = \"long\"\n\
                pri = 240\n\
                con = [200]\n\
                st = +5\n\
                [[task]]\n\
                hold = true\n\
                [[task]]\n\
                id = 3\n\
                [[task]]\n\
                id = 4\n\
                run = \"a\"\n\
                hold = true\n\
                after = [9]\n";
    let expected = [
        (2, 6, Rule::Range),
        (3, 7, Rule::Value),
        (4, 7, Rule::Value),
        (5, 7, Rule::Range),
        (6, 8, Rule::Range),
        (7, 6, Rule::Value),
        (8, 1, Rule::Missing),
        (10, 1, Rule::Missing),
        (15, 8, Rule::Duplicate),
    ];
    // 9 is not missed: one of the two numbers that cannot be read may be it.
    assert_eq!(bad("a.toml", text), expected);
}

#[test]
fn several_mistakes_of_syntax_are_told_at_once() {
    let text = "[[task]]\nid = \nrun = \"a\nhold = 3\n[[task]\nid = 5\nhold = true\n\
                [[task]]\nid = 6\nhold = 7\n[[task]]\nid 8\nhold = true";
    let expected = [
        (2, 6, Rule::Syntax),
        (3, 9, Rule::Syntax),
        (4, 8, Rule::Duplicate),
        (5, 8, Rule::Syntax),
        (10, 8, Rule::Value),
        (12, 4, Rule::Syntax),
    ];
    assert_eq!(bad("a.toml", text), expected);
}

#[test]
fn circles_are_told_once() {
    let task = |id: u32, rest: &str| format!("[[task]]\nid = {id}\nhold = true\n{rest}\n");
    let text = task(1, "after = [2]")
        + &task(2, "after = [3]")
        + &task(3, "after = [1]")
        + &task(4, "after = [1]")
        + &task(5, "after = [5]")
        + &task(6, "cleanup = 7")
        + &task(7, "cleanup = 6");
    let found = format::read("a.toml", text.as_bytes()).unwrap_err();
    let expected = [(4, 9, Rule::Cycle), (20, 9, Rule::Cycle), (24, 11, Rule::Cycle)];
    assert_eq!(told(&found), expected);
    assert_eq!(found[0].message, "task 1 waits for task 2 waits for task 3 waits for task 1");
}

#[test]
fn names_and_tasks_that_are_not_there_are_told() {
    let text = "[[task]]\nid = 1\nrun = \"a\"\nafter = [9]\ncleanup = 8\ngates = [\"camera\"]\n\
                [[task]]\nid = 2\nenter_mode = \"safe\"\n";
    let expected = [
        (4, 9, Rule::UnknownTask),
        (5, 11, Rule::UnknownTask),
        (6, 9, Rule::UnknownName),
        (9, 14, Rule::UnknownName),
    ];
    assert_eq!(bad("a.toml", text), expected);
    let options = Options { whole: false, against: Against::Nothing, ..Options::default() };
    assert!(format::read_with(options, "a.toml", text.as_bytes()).is_ok());
}

#[test]
fn what_can_never_run_is_loaded_and_warned_of() {
    let text = "[mission]\nmemory = 100\n[[mission.agent]]\nname = \"bus\"\nsupply_w = 10\n\
                [[mission.device]]\nname = \"camera\"\nkind = \"camera\"\ndraw_w = 8\n\
                [[task]]\nid = 1\nhold = true\nmemory = 101\ndraw_w = 3\ngates = [\"camera\"]\n";
    let loaded = good("a.toml", text);
    assert_eq!(told(&loaded.warnings), [(13, 10, Rule::NeverRuns), (15, 9, Rule::NeverRuns)]);
    assert_eq!(loaded.mission.unwrap().devices[0].agent, "bus");
}

#[test]
fn policies_that_make_no_sense_are_told() {
    let text = "[[task]]\nid = 1\nfunction = 16\npreempt = \"pause\"\n\
                [[task]]\nid = 2\nhold = true\ngrace = 2\n\
                [[task]]\nid = 3\nhold = true\ndur = 2\ndur_min = 3\n\
                [[task]]\nid = 4\nhold = true\nback_off = 2\n";
    let expected = [
        (4, 11, Rule::Preemption),
        (8, 9, Rule::NoEffect),
        (13, 11, Rule::Range),
        (17, 12, Rule::NoEffect),
    ];
    assert_eq!(bad("a.toml", text), expected);
}

#[test]
fn a_one_shot_that_may_run_twice_is_warned_of() {
    let text = "[[task]]\nid = 1\nrun = \"a\"\nrestart = \"on_failure\"\n";
    assert_eq!(told(&good("a.toml", text).warnings), [(4, 11, Rule::Restart)]);
    let routine = format!("{text}interval = 60\n");
    assert!(good("a.toml", &routine).warnings.is_empty());
}

#[test]
fn a_mission_alone_is_a_file() {
    let loaded = good("m.toml", "[mission]\nname = \"alone\"\n");
    let mission = Mission { name: Some("alone".into()), ..Mission::default() };
    assert_eq!((loaded.tasks.len(), loaded.mission), (0, Some(mission)));
}
