//! What is written is read again as it was.

use faregate_scheduler::format::{self, Against, Kind, NotHeld, Options, Rule};
use faregate_scheduler::task::{Body, BuiltIn, When, Window};
use faregate_scheduler::time::UnixTime;
use faregate_scheduler::{Mission, Task, TaskId};
use proptest::prelude::*;

use crate::support::good;
use crate::{arbitrary, missions};

fn read(kind: Kind, text: &str) -> format::Loaded {
    let against = Against::Nothing;
    let options = Options { kind: Some(kind), against, whole: false, ..Options::default() };
    match format::read_with(options, "written", text.as_bytes()) {
        Ok(loaded) => loaded,
        Err(found) => panic!("{}\n{text}", format::render(&found, text.as_bytes(), false)),
    }
}

/// What a row cannot hold is what it holds by default.
fn as_a_row(task: &Task) -> Task {
    let usual = Task::new(task.id, task.body.clone());
    Task {
        windows: vec![task.windows[0]],
        duration: task.duration,
        cutoff: task.cutoff,
        categories: task.categories,
        priority: task.priority,
        interval: task.interval,
        memory: task.memory,
        storage: task.storage,
        battery: task.battery,
        peak_draw: task.peak_draw,
        average_draw: task.peak_draw,
        gap: task.gap,
        preemption: task.preemption,
        gates: if gates_have_a_column(task) { task.gates.clone() } else { Vec::new() },
        ..usual
    }
}

fn gates_have_a_column(task: &Task) -> bool {
    let plain = |one: char| one.is_ascii_graphic() && !";,\"'\\".contains(one);
    task.gates.iter().all(|gate| gate != "-" && gate.chars().all(plain))
}

/// Whether a row can hold what the task does, and its one window its cutoff.
fn has_a_row(kind: Kind, task: &Task) -> bool {
    let words = match &task.body {
        Body::Sequence(_) => return false,
        Body::Process { program, arguments } => [vec![program.clone()], arguments.clone()].concat(),
        Body::Function { arguments, .. } => arguments.clone(),
        Body::BuiltIn(
            BuiltIn::Load(name) | BuiltIn::EnterMode(name) | BuiltIn::LeaveMode(name),
        ) => {
            vec![name.clone()]
        }
        Body::Hold | Body::BuiltIn(_) => Vec::new(),
    };
    let breaks = words.iter().any(|word| word.contains(['\n', '\r']));
    let first = task.windows[0];
    (kind == Kind::Csv || !breaks) && !arbitrary::is_before(task.cutoff, first.opens)
}

proptest! {
    #[test]
    fn the_native_format_holds_everything(
        tasks in arbitrary::tasks(),
        mission in proptest::option::of(missions::mission()),
    ) {
        let (text, lost) = format::write(Kind::Toml, &tasks, mission.as_ref());
        prop_assert_eq!(lost, Vec::new());
        let again = read(Kind::Toml, &text);
        prop_assert_eq!((again.tasks, again.mission), (tasks, mission));
    }

    #[test]
    fn a_row_holds_what_it_can_and_the_rest_is_listed(
        tasks in arbitrary::tasks(),
        txt in any::<bool>(),
    ) {
        let kind = if txt { Kind::Txt } else { Kind::Csv };
        let (text, lost) = format::write(kind, &tasks, None);
        let again = read(kind, &text).tasks;
        let left_out = |id: TaskId| lost.iter().any(|one| one.task == Some(id) && one.field == "task");
        let kept: Vec<_> = tasks.iter().filter(|task| !left_out(task.id)).collect();
        prop_assert_eq!(&again, &kept.iter().map(|task| as_a_row(task)).collect::<Vec<_>>());
        for (task, again) in kept.into_iter().zip(&again) {
            let listed = lost.iter().any(|one| one.task == Some(task.id));
            prop_assert_eq!(listed, task != again, "{:?}\n{:?}", task, lost);
        }
        for task in tasks.iter().filter(|task| has_a_row(kind, task)) {
            prop_assert!(!left_out(task.id), "{:?}", task);
        }
    }
}

fn hold(id: u32) -> Task {
    Task::new(TaskId::new(id).unwrap(), Body::Hold)
}

fn listed(lost: &[NotHeld]) -> Vec<(u32, &'static str)> {
    lost.iter().map(|one| (one.task.map_or(0, TaskId::get), one.field)).collect()
}

#[test]
fn what_a_row_cannot_hold_is_listed_field_by_field() {
    let everything = good("everything.toml", include_str!("everything.toml"));
    let (_, lost) = format::write(Kind::Csv, &everything.tasks, everything.mission.as_ref());
    let fields = [
        "name",
        "window",
        "dur_min",
        "average_draw_w",
        "data",
        "restart",
        "overrun",
        "heartbeat",
        "after",
        "cleanup",
        "mandatory",
    ];
    let mut expected: Vec<_> = fields.into_iter().map(|field| (1, field)).collect();
    expected.extend([(3, "task"), (0, "mission")]);
    assert_eq!(listed(&lost), expected);
}

#[test]
fn a_case_written_again_is_the_same_file() {
    for name in [
        "smaarte_fig4.csv",
        "smaarte_nine_tasks_gap.csv",
        "smaarte_preempt.csv",
        "smaarte_fig4.txt",
    ] {
        let text =
            std::fs::read_to_string(format!("{}/tests/cases/{name}", env!("CARGO_MANIFEST_DIR")))
                .unwrap();
        let kind = Kind::of(name).unwrap();
        assert_eq!(format::write(kind, &good(name, &text).tasks, None), (text, Vec::new()));
    }
}

#[test]
fn a_time_that_a_column_cannot_say_is_listed() {
    let mut task = hold(1);
    task.windows =
        vec![Window { opens: When::At(UnixTime::from_secs(-5)), closes: When::Unrestricted }];
    assert_eq!(listed(&format::write(Kind::Txt, &[task.clone()], None).1), [(1, "st")]);
    assert_eq!(format::write(Kind::Toml, &[task], None).1, []);
}

/// A task that no reader would accept must not spoil the file for the others.
#[test]
fn a_task_that_could_not_be_read_again_is_left_out() {
    let mut broken = hold(1);
    broken.windows.clear();
    let (text, lost) = format::write(Kind::Toml, &[broken, hold(2)], None);
    assert_eq!(listed(&lost), [(1, "task")]);
    assert_eq!(read(Kind::Toml, &text).tasks, [hold(2)]);
}

#[test]
fn a_mission_that_cannot_be_read_again_is_listed() {
    let mut mission = Mission::default();
    mission.agents.clear();
    assert_eq!(listed(&format::write(Kind::Toml, &[], Some(&mission)).1), [(0, "mission")]);
    let wrong = format::read("m.toml", b"[mission]\nagent = []\n").unwrap_err();
    assert_eq!(wrong[0].rule, Rule::Missing);
}
