//! What an analysis says, and what it says nothing of.

mod support;

use faregate_scheduler::analyze::{
    Analysis, Options, ProblemKind, RunOutcome, Surroundings, analyze, analyze_in,
};
use faregate_scheduler::executive::LoadedFile;
use faregate_scheduler::mission::{BatterySpec, Mission};
use faregate_scheduler::task::{
    Body, BuiltIn, CheckpointSignal, Dependency, Preemption, Spread, Status, Task, When, Window,
};
use faregate_scheduler::time::{Duration, UnixTime};
use serde_json::{Value, json};

use support::{analysis, due, every, id, report, s, seconds, segments, task, until};

fn plain(tasks: &[Task]) -> Analysis {
    analyze(tasks, &Mission::default(), &Options::default()).unwrap()
}

fn kinds(analysis: &Analysis) -> Vec<(ProblemKind, Option<u32>)> {
    let kind = |task: Option<faregate_scheduler::TaskId>| task.map(faregate_scheduler::TaskId::get);
    analysis.problems.iter().map(|problem| (problem.kind, kind(problem.task))).collect()
}

#[test]
fn a_report_has_these_fields_and_no_others() {
    let tasks = [task(1, 4, 1, 2), until(task(2, 4, 1, 1), 3)];
    let written = serde_json::to_value(plain(&tasks)).unwrap();
    let run = json!({
        "start_s": 0.0, "end_s": 4.0, "outcome": "succeeded", "segments": [[0.0, 4.0]]
    });
    let expected = json!({
        "makespan_s": 4.0,
        "tasks": [
            { "id": 1, "runs": [run], "waited_s": 0.0, "reason": null },
            {
                "id": 2, "runs": [], "waited_s": 3.0,
                "reason": "waited for categories 0x1, which task 1 has"
            },
        ],
        "problems": [{
            "kind": "missed", "task": 2, "with": null, "at_s": 3.0, "every_s": null,
            "message": "task 2 misses an occurrence: its window closed"
        }],
    });
    assert_eq!(written, expected);
}

#[test]
fn a_schedule_without_one_shots_has_no_makespan() {
    let analysis = analysis(&[every(task(1, 4, 1, 2), 10)], &Mission::default(), 25);
    assert_eq!(serde_json::to_value(&analysis).unwrap()["makespan_s"], Value::Null);
    assert_eq!(report(&analysis, 1).runs.len(), 3);
}

#[test]
fn what_starts_at_the_horizon_is_beyond_it_and_what_ends_there_is_not() {
    let analysis = analysis(&[every(task(1, 10, 1, 2), 20)], &Mission::default(), 30);
    assert_eq!(segments(&analysis, 1), [[(0, 10)], [(20, 30)]]);
    assert_eq!(report(&analysis, 1).runs[1].outcome, RunOutcome::Succeeded);
    let analysis = support::analysis(&[every(task(1, 10, 1, 2), 20)], &Mission::default(), 20);
    assert_eq!(segments(&analysis, 1), [[(0, 10)]]);
}

/// Its latest start lies so far back that whoever looks at each occurrence of
/// it never comes to an end.
#[test]
fn occurrences_that_were_over_long_ago_are_counted() {
    let mut late = every(task(1, 1, 1, 2), 1);
    late.windows[0].closes = When::At(UnixTime::from_secs(5));
    let at = UnixTime::from_secs(1_700_000_000);
    let options = Options { at, horizon: Some(s(3)), ..Options::default() };
    let analysis = analyze(&[late], &Mission::default(), &options).unwrap();
    let [problem] = &analysis.problems[..] else { panic!("{:?}", analysis.problems) };
    assert_eq!(problem.kind, ProblemKind::Missed);
    assert_eq!(problem.message, "task 1 misses 1699999997 occurrences: its window closed");
    let shown = &analysis.tasks[0].more;
    assert!(shown.misses.len() < 10 && shown.windows.len() < 10, "{}", shown.misses.len());
}

#[test]
fn a_run_that_is_cut_short_by_the_horizon_has_no_end() {
    let analysis = analysis(&[task(1, 50, 1, 2)], &Mission::default(), 30);
    let [run] = &report(&analysis, 1).runs[..] else { panic!() };
    assert_eq!((run.end, run.outcome), (None, RunOutcome::Unfinished));
    assert_eq!(segments(&analysis, 1), [[(0, 30)]]);
    assert_eq!(analysis.makespan, None);
}

/// A checkpoint takes its grace, and is a run of its own; so is a kill.
#[test]
fn who_is_run_again_has_two_runs() {
    let mut victim = task(1, 20, 1, 1);
    victim.preemption = Preemption::Kill { grace: s(3) };
    let analysis = plain(&[victim, due(task(2, 5, 1, 2), 5)]);
    assert_eq!(segments(&analysis, 1), [[(0, 5)], [(10, 30)]]);
    let outcomes: Vec<_> = report(&analysis, 1).runs.iter().map(|run| run.outcome).collect();
    assert_eq!(outcomes, [RunOutcome::Preempted, RunOutcome::Succeeded]);
    assert_eq!(seconds(report(&analysis, 1).waited), 5);
}

/// Who takes from a task that is checkpointed waits for its grace, and no
/// longer.
#[test]
fn a_taker_waits_for_the_grace_of_a_checkpoint() {
    let mut victim = task(1, 20, 1, 1);
    let signal = CheckpointSignal::default();
    victim.preemption = Preemption::Checkpoint { grace: s(3), signal };
    let analysis = plain(&[victim, due(task(2, 5, 1, 2), 5)]);
    assert_eq!(segments(&analysis, 2), [[(8, 13)]]);
    // Five seconds of work were saved, and the grace was none.
    assert_eq!(segments(&analysis, 1), [[(0, 8)], [(13, 28)]]);
}

#[test]
fn a_task_that_depends_on_a_less_important_one_is_named() {
    let mut dependant = task(1, 2, 0, 9);
    dependant.after = vec![Dependency { task: id(2), status: Status::Succeeded }];
    let analysis = plain(&[dependant.clone(), task(2, 8, 0, 3)]);
    let [problem] = &analysis.problems[..] else { panic!("{:?}", analysis.problems) };
    assert_eq!(problem.kind, ProblemKind::Inversion);
    assert_eq!((problem.task, problem.with, problem.at), (Some(id(1)), Some(id(2)), Some(s(0))));
    assert_eq!(seconds(report(&analysis, 1).waited), 8);
    // The other way round there is nothing to say.
    assert_eq!(kinds(&plain(&[dependant, task(2, 8, 0, 10)])), []);
}

#[test]
fn a_task_that_waits_for_a_less_important_one_which_cannot_be_stopped_is_named() {
    let mut rude = task(1, 20, 1, 1);
    rude.preemption = Preemption::Wait;
    let analysis = plain(&[rude, due(task(2, 5, 1, 9), 5)]);
    assert_eq!(kinds(&analysis), [(ProblemKind::Inversion, Some(2))]);
    assert_eq!(segments(&analysis, 2), [[(20, 25)]]);
}

#[test]
fn a_cutoff_that_ends_a_run_is_told() {
    let mut task = task(1, 20, 1, 1);
    task.cutoff = When::AfterLoad(s(8));
    let analysis = plain(&[task]);
    assert_eq!(kinds(&analysis), [(ProblemKind::Cutoff, Some(1))]);
    assert_eq!(analysis.problems[0].at, Some(s(8)));
    assert_eq!(report(&analysis, 1).runs[0].outcome, RunOutcome::Aborted);
}

#[test]
fn a_task_that_can_never_run_is_told_with_its_reason() {
    let mission = Mission { memory: Some(1_000), ..Mission::default() };
    let mut large = task(1, 5, 1, 9);
    large.memory = 1_001;
    let analysis = analyze(&[large, task(2, 5, 1, 1)], &mission, &Options::default()).unwrap();
    assert_eq!(kinds(&analysis), [(ProblemKind::NeverRuns, Some(1))]);
    assert!(report(&analysis, 1).runs.is_empty());
    let reason = report(&analysis, 1).reason.clone().unwrap_or_default();
    assert!(reason.contains("memory"), "{reason}");
    // It blocks nobody.
    assert_eq!(segments(&analysis, 2), [[(0, 5)]]);
}

#[test]
fn a_task_whose_prior_ended_otherwise_never_runs() {
    let mut dependant = task(1, 2, 0, 1);
    dependant.after = vec![Dependency { task: id(2), status: Status::Failed }];
    let analysis = plain(&[dependant, task(2, 8, 0, 3)]);
    assert_eq!(kinds(&analysis), [(ProblemKind::NeverRuns, Some(1))]);
    assert_eq!(analysis.problems[0].at, Some(s(8)));
}

#[test]
fn a_duration_that_is_not_stated_is_no_time_and_is_listed() {
    let analysis = plain(&[task(1, 0, 1, 1), task(2, 3, 1, 2)]);
    assert_eq!(kinds(&analysis), [(ProblemKind::NoDuration, Some(1))]);
    assert_eq!(segments(&analysis, 1), [[(3, 3)]]);
}

#[test]
fn who_has_not_run_at_the_horizon_is_listed() {
    let analysis = analysis(&[task(1, 50, 1, 2), task(2, 5, 1, 1)], &Mission::default(), 30);
    assert_eq!(kinds(&analysis), [(ProblemKind::Waiting, Some(2))]);
    let message = &analysis.problems[0].message;
    assert!(message.contains("task 1 has"), "{message}");
    // Not due yet is no problem.
    let analysis = support::analysis(&[due(task(1, 5, 1, 2), 40)], &Mission::default(), 30);
    assert_eq!(kinds(&analysis), []);
}

#[test]
fn the_battery_is_taken_to_be_full() {
    let mission = Mission { battery: Some(BatterySpec { low: 20 }), ..Mission::default() };
    let mut hungry = task(1, 5, 1, 9);
    hungry.battery = 90;
    let analysis = analyze(&[hungry], &mission, &Options::default()).unwrap();
    assert_eq!(segments(&analysis, 1), [[(0, 5)]]);
}

#[test]
fn a_schedule_is_looked_at_as_if_loaded_at_that_time_of_day() {
    let at = |s| When::At(UnixTime::from_secs(s));
    let mut task = task(1, 5, 1, 1);
    task.windows = vec![Window { opens: at(1_000), closes: at(1_010) }];
    let loaded = |s| {
        let options = Options { at: UnixTime::from_secs(s), ..Options::default() };
        analyze(&[task.clone()], &Mission::default(), &options).unwrap()
    };
    assert_eq!(segments(&loaded(970), 1), [[(30, 35)]]);
    assert_eq!(segments(&loaded(1_004), 1), [[(0, 5)]]);
    assert_eq!(kinds(&loaded(1_011)), [(ProblemKind::Missed, Some(1))]);
}

/// Has one file.
struct Files;

impl Surroundings for Files {
    fn load(&mut self, path: &str) -> LoadedFile {
        if path == "more.csv" { Ok(vec![task(7, 3, 1, 1)]) } else { Err("no such file".into()) }
    }
}

#[test]
fn tasks_of_a_file_that_is_loaded_in_flight_are_in_the_report() {
    let load = |path: &str| due(Task::new(id(1), Body::BuiltIn(BuiltIn::Load(path.into()))), 10);
    let analyzed = |path| {
        analyze_in(&[load(path)], &Mission::default(), &Options::default(), &mut Files).unwrap()
    };
    assert_eq!(segments(&analyzed("more.csv"), 7), [[(10, 13)]]);
    assert_eq!(report(&analyzed("less.csv"), 1).runs[0].outcome, RunOutcome::Failed);
}

#[test]
fn a_schedule_that_the_manager_refuses_is_not_analyzed() {
    let twice = [task(1, 5, 1, 1), task(1, 6, 1, 1)];
    let refused = analyze(&twice, &Mission::default(), &Options::default()).unwrap_err();
    assert!(refused.to_string().contains("task 1"), "{refused}");
}

/// Has no patience.
struct Impatient(usize);

impl Surroundings for Impatient {
    fn reached(&mut self, at: Duration, limit: Option<Duration>, runs: usize) -> bool {
        assert!(Some(at) < limit);
        runs < self.0
    }
}

/// Each millisecond of a day would be eighty million runs.
#[test]
fn a_schedule_with_too_many_runs_is_looked_at_in_part_and_that_is_said() {
    let mut frantic = task(1, 0, 0, 1);
    frantic.interval = Some(Duration::from_millis(1));
    frantic.duration = Duration::from_micros(1);
    let (mission, options) = (Mission::default(), Options::default());
    let analysis = analyze_in(&[frantic], &mission, &options, &mut Impatient(10_000)).unwrap();
    assert_eq!(kinds(&analysis), [(ProblemKind::More, None)]);
    assert!(analysis.horizon < s(60), "{}", analysis.horizon);
    assert!(report(&analysis, 1).runs.len() >= 10_000);
}

/// Who waits each millisecond and never runs fills the memory, too.
#[test]
fn a_schedule_with_too_many_waits_is_looked_at_in_part() {
    let mut holder = task(1, 80_000, 1, 2);
    holder.preemption = Preemption::Wait;
    let mut frantic = due(task(2, 0, 1, 1), 1);
    frantic.interval = Some(Duration::from_millis(1));
    let (mission, horizon) = (Mission::default(), Some(s(60)));
    let options = Options { horizon, ..Options::default() };
    let mut impatient = Impatient(10_000);
    let analysis = analyze_in(&[holder, frantic], &mission, &options, &mut impatient).unwrap();
    assert!(analysis.horizon < s(30), "{}", analysis.horizon);
    assert!(kinds(&analysis).contains(&(ProblemKind::More, None)));
}

fn varying() -> [Task; 2] {
    let mut first = task(1, 10, 1, 2);
    first.spread = Some(Spread { shortest: s(8), longest: s(20) });
    [first, until(task(2, 5, 1, 1), 14)]
}

fn sampled(samples: u32, seed: u64) -> Analysis {
    let options = Options { samples, seed, ..Options::default() };
    analyze(&varying(), &Mission::default(), &options).unwrap()
}

#[test]
fn samples_tell_how_probable_a_miss_is() {
    let samples = sampled(2_000, 1).samples.unwrap();
    let [first, second] = &samples.tasks[..] else { panic!() };
    let end = first.end.unwrap();
    assert!(s(8) <= end.p05 && end.p05 < end.p50 && end.p50 < end.p95 && end.p95 <= end.max);
    assert!(end.max <= s(20), "{end:?}");
    // A triangle over 8, 10, 20 is above 14 with (20-14)^2 / (12 * 10).
    let expected = 0.3;
    let seen = second.miss_probability;
    assert!((seen - expected).abs() < 0.05, "{seen}");
    assert_eq!(first.miss_probability, 0.0);
}

#[test]
fn the_same_seed_draws_the_same_and_another_one_does_not() {
    assert_eq!(sampled(50, 7), sampled(50, 7));
    let tasks = |seed| sampled(50, seed).samples.unwrap().tasks;
    assert_ne!(tasks(7), tasks(8));
}

#[test]
fn samples_without_a_spread_are_not_printed_but_said_to_be_pointless() {
    let options = Options { samples: 100, ..Options::default() };
    let analysis = analyze(&[task(1, 5, 1, 1)], &Mission::default(), &options).unwrap();
    assert_eq!(analysis.samples, None);
    assert_eq!(kinds(&analysis), [(ProblemKind::NoSpread, None)]);
}

#[test]
fn use_of_categories_is_what_ran() {
    let analysis = plain(&[task(1, 10, 0b01, 1), task(2, 30, 0b10, 1)]);
    let busy: Vec<_> = analysis
        .utilisation
        .categories
        .iter()
        .map(|one| (one.category, seconds(one.busy)))
        .collect();
    assert_eq!(busy, [(0, 10), (1, 30)]);
    assert_eq!(analysis.utilisation.over, s(30));
}

/// Every activity of the week starts, in its window, and nothing runs beside
/// what it shares a category with.
#[test]
fn a_week_of_a_satellite_is_analyzed() {
    use support::week;
    let tasks = week::tasks();
    assert_eq!(tasks.len(), week::PLANNED);
    let options = Options { horizon: Some(week::ENDS), ..Options::default() };
    let analysis = analyze(&tasks, &week::mission(), &options).unwrap();
    let mut busy: Vec<(Duration, Duration, u128)> = Vec::new();
    for task in &analysis.tasks {
        let ran = !task.runs.is_empty() || !task.more.misses.is_empty();
        assert!(ran, "{} is lost", task.id);
        let segments = task.runs.iter().flat_map(|run| &run.segments);
        busy.extend(segments.map(|(from, to)| (*from, *to, task.more.categories.mask())));
    }
    busy.sort_unstable();
    for (index, (_, end, mask)) in busy.iter().enumerate() {
        let meanwhile = busy[index + 1..].iter().take_while(|(from, ..)| from < end);
        for (from, _, other) in meanwhile {
            assert_eq!(mask & other, 0, "two run in one category at {from}");
        }
    }
    let [bus] = &analysis.utilisation.agents[..] else { panic!() };
    assert!(bus.supply.is_some_and(|supply| bus.peak <= supply), "{bus:?}");
}

#[test]
fn a_cleanup_that_is_never_needed_is_no_problem_and_waits_for_nothing() {
    let mut cleaned = task(1, 4, 1, 2);
    cleaned.cleanup = Some(id(9));
    let analysis = plain(&[cleaned, task(9, 1, 1, 1)]);
    assert_eq!(kinds(&analysis), []);
    assert_eq!(report(&analysis, 9).waited, s(0));
    assert!(report(&analysis, 9).runs.is_empty());
}

/// One that is ended by its overrun policy was aborted.
#[test]
fn a_cleanup_that_is_needed_is_due_when_it_starts() {
    let mut cleaned = due(task(1, 4, 1, 2), 0);
    cleaned.cleanup = Some(id(9));
    cleaned.cutoff = When::AfterLoad(s(3));
    let analysis = plain(&[cleaned, task(9, 1, 0, 1)]);
    assert_eq!(kinds(&analysis), [(ProblemKind::Cutoff, Some(1))]);
    assert_eq!(report(&analysis, 9).waited, s(0));
    assert_eq!(report(&analysis, 9).runs[0].start, s(3));
}
