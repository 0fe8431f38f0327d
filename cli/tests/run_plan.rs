//! `run --plan`: the schedule manager executes what the planner plans.

#![cfg(target_os = "linux")]

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use serde_json::Value;
use support::run::Run;
use support::{Said, Scratch, call, root};

/// Executes an example sol on the virtual clock.
fn sol(name: &str) -> Said {
    let sols = root().join("examples/sols");
    let path = |name: &str| sols.join(name).to_str().expect("a path of letters").to_owned();
    let (plan, state) = (format!("{name}/plan.xml"), format!("{name}/state.xml"));
    let words = ["run", &path("rover.toml"), "--plan", &path(&plan), "-p", &path("parameters.xml")];
    let more = ["-s", &path(&state), "--virtual", "--format", "json"];
    call(&[&words[..], &more].concat())
}

/// What became of activities; other tasks are the planner's own.
fn outcomes(said: &Said) -> BTreeMap<u64, String> {
    let outcome = |line: &Value| {
        let ended = line["note"]["Ended"].as_object()?;
        let task = ended["occurrence"]["task"].as_u64().filter(|task| *task < 1_000)?;
        Some((task, ended["outcome"].as_str()?.to_owned()))
    };
    said.json_lines().iter().filter_map(outcome).collect()
}

fn planned(name: &str) -> BTreeSet<u64> {
    let sols = root().join("examples/sols");
    let path = |name: &str| sols.join(name).to_str().expect("a path of letters").to_owned();
    let (plan, state) = (format!("{name}/plan.xml"), format!("{name}/state.xml"));
    let words = ["plan", "make", &path(&plan), "-p", &path("parameters.xml"), "-s", &path(&state)];
    let made = call(&[&words[..], &["--format", "json"]].concat()).json();
    let rows = made["activities"].as_array().expect("rows").clone();
    let scheduled = rows.into_iter().filter(|row| row["status"] == "scheduled");
    scheduled.map(|row| row["id"].as_u64().expect("a number")).collect()
}

#[test]
fn everything_that_is_planned_for_the_busy_sol_is_executed() {
    let said = sol("busy");
    assert_eq!((said.code, &said.err[..]), (0, ""), "{said:?}");
    let outcomes = outcomes(&said);
    assert!(outcomes.values().all(|outcome| outcome == "Succeeded"), "{outcomes:?}");
    assert_eq!(outcomes.into_keys().collect::<BTreeSet<_>>(), planned("busy"));
    let again = said.json_lines().iter().filter(|line| line["planned"].is_string()).count();
    assert!(again > 1, "it is planned anew as it goes");
}

#[test]
fn a_sol_in_which_something_mandatory_is_left_out_ends_with_1_and_says_what() {
    assert_eq!(sol("winter").code, 0);
    assert_eq!(sol("conjunction").code, 0);
    let said = sol("too-much");
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("drive was not started"), "{said:?}");
    assert!(!said.err.contains("restart the computer"), "that is no task: {said:?}");
}

const ROVER: &str = "
[mission]
name = 'two lamps'
[mission.categories]
floodlight = 0
beacon = 1
'engine 1' = 64
'engine 2' = 65
[[mission.agent]]
name = 'bus'
supply_w = 42
[[mission.device]]
name = 'floodlight'
kind = 'heater'
parameters = { draw_w = 8 }
[[mission.device]]
name = 'beacon'
kind = 'heater'
parameters = { draw_w = 8 }
[[task]]
id = 1
name = 'flood'
step = [{ at = 0, gate = 'floodlight', command = 'on' }, { at = 0.2, gate = 'floodlight', command = 'off' }]
[[task]]
id = 2
name = 'signal'
step = [{ at = 0, gate = 'beacon', command = 'on' }, { at = 0.2, gate = 'beacon', command = 'off' }]
[[task]]
id = 3
name = 'flood for long'
step = [{ at = 0, gate = 'floodlight', command = 'on' }, { at = 600, gate = 'floodlight', command = 'off' }]
";

const PARAMETERS: &str = r#"<parameters version="1" mandatory_from="100" soft_min_soc="40 %"
    hard_min_soc="30 %" max_soc="100 %" peak_limit="42 W" engines="2" rtg="110 W" base="50 W"
    min_awake="0 s" min_sleep="0 s" commit="100 ms" expansion_grace="0 s" handover_tolerance="30 s"
    soft_samples="3">
  <awake/> <wakeup duration="0 s"/> <shutdown duration="0 s"/>
  <resource name="floodlight" bit="0"/> <resource name="beacon" bit="1"/>
</parameters>"#;

const STATE: &str = r#"<state version="1" now="10:00" mode="awake" mode_since="10:00"
    charge="2000 Wh" capacity="2400 Wh"/>"#;

/// A lamp, then another one; or a third one, where the first was not left alone.
fn plan(sequence: &str, duration: &str) -> String {
    let lamp = |id: u32, priority: u32, sequence: &str, duration: &str, more: &str| {
        let bit = if sequence == "signal" { "beacon" } else { "floodlight" };
        format!(
            r#"<activity id="{id}" name="lamp {id}" priority="{priority}" sequence="{sequence}"
                duration="{duration}" marginal="8 W" peak="8 W" engines="1" {more}
                <start from="10:00" to="10:40" cutoff="10:55"/><uses resource="{bit}"/>"#
        )
    };
    let begin = r#"<plan version="1" name="lamps" handover="11:00" handover_min_soc="50 %"
        end="11:00" max_delta_data="1 MB">"#;
    let first = lamp(1, 120, sequence, duration, ">");
    let then = lamp(2, 110, "signal", "300 ms", ">");
    let cleanup = lamp(3, 105, "signal", "300 ms", r#"type="cleanup">"#);
    format!(
        r#"{begin}{first}</activity>{then}<after activity="1" status="SUCCEEDED"/></activity>
        {cleanup}<after activity="1" status="FAILED ABORTED"/></activity></plan>"#
    )
}

/// The words of a run of this plan; the files go with the scratch.
fn words(scratch: &Scratch, plan: &str) -> Vec<String> {
    let text = |path: PathBuf| path.to_str().expect("a path of letters").to_owned();
    let [rover, plan, parameters, state] = [
        scratch.file("rover.toml", ROVER),
        scratch.file("plan.xml", plan),
        scratch.file("parameters.xml", PARAMETERS),
        scratch.file("state.xml", STATE),
    ]
    .map(text);
    [&rover[..], "--plan", &plan, "-p", &parameters, "-s", &state].map(str::to_owned).to_vec()
}

fn as_words(words: &[String]) -> Vec<&str> {
    words.iter().map(String::as_str).collect()
}

#[test]
fn a_plan_is_executed_in_real_time_on_tickets_of_its_devices() {
    let scratch = Scratch::new();
    let words = words(&scratch, &plan("flood", "300 ms"));
    let said = call(&[&["run"], &as_words(&words)[..], &["--format", "json"]].concat());
    assert_eq!(said.code, 0, "{said:?}");
    let notes = said.json_lines();
    let of = |note: &Value| Some((note["occurrence"]["task"].as_u64()?, note["number"].as_u64()?));
    let started: Vec<_> = notes
        .iter()
        .filter_map(|line| of(&line["note"]["Started"]))
        .map(|(task, _)| task)
        .collect();
    let lamps: Vec<_> = started.into_iter().filter(|task| *task < 1_000).collect();
    assert_eq!(lamps, [1, 2], "one after the other, and no cleanup");
    assert_eq!(outcomes(&said).into_values().collect::<Vec<_>>(), ["Succeeded", "Succeeded"]);
}

#[test]
fn who_takes_the_tickets_of_an_activity_has_it_aborted_and_cleaned_up_by_a_new_plan() {
    let scratch = Scratch::new();
    let words = words(&scratch, &plan("flood for long", "10 min"));
    // The cleanup waits for the emergency, and must not find the computer down.
    let patient = PARAMETERS.replace("min_awake=\"0 s\"", "min_awake=\"2 min\"");
    scratch.file("parameters.xml", patient);
    let mut run = Run::start(&scratch, &as_words(&words));
    run.until("started task 1 attempt 1, lamp 1");
    let emergency = "[[task]]\nid = 9000\nhold = true\ndur = 0.2\npri = 239\ndraw_w = 40\n";
    let emergency = scratch.file("emergency.toml", emergency);
    run.must(&["add", emergency.to_str().expect("a path of letters")]);
    run.until("started task 3 attempt 1, lamp 3");
    run.until("succeeded task 3 attempt 1, lamp 3");
    let said = run.end();
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("lamp 1 was aborted, lamp 2 was not started"), "{said:?}");
    assert!(said.out.contains("lamp 1 did not succeed"), "{said:?}");
}

#[test]
fn a_battery_that_holds_less_than_the_state_says_keeps_activities_out() {
    let scratch = Scratch::new();
    let words = words(&scratch, &plan("flood", "300 ms"));
    let battery = |percent: u32| {
        let device = "[[mission.device]]\nname = 'battery'\nkind = 'battery'\n";
        let holds = format!("capacity_wh = 2400, charge_percent = {percent}");
        let rover = format!("{ROVER}{device}parameters = {{ {holds}, generation_w = 0 }}\n");
        scratch.file("rover.toml", rover);
        call(&[&["run"], &as_words(&words)[..]].concat())
    };
    let said = battery(35);
    assert_eq!(said.code, 1, "below the soft minimum: {said:?}");
    assert!(said.err.contains("lamp 1 was not started"), "{said:?}");
    let said = battery(80);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("activities: 2 succeeded"), "{said:?}");
}

#[test]
fn a_plan_that_the_mission_cannot_execute_is_refused_with_everything_that_is_wrong() {
    let scratch = Scratch::new();
    let plan = plan("flood", "300 ms").replace("signal", "sing").replace("engines=\"1\"", "");
    let words = words(&scratch, &plan);
    let said = call(&[&["run"], &as_words(&words)[..], &["--virtual"]].concat());
    assert_eq!((said.code, &said.out[..]), (1, ""), "{said:?}");
    assert_eq!(said.err.matches("no sequence `sing` is known").count(), 2, "{said:?}");
}

#[test]
fn a_plan_needs_its_parameters_its_state_and_one_mission() {
    for more in [
        &["rover.toml", "--plan", "plan.xml"][..],
        &["rover.toml", "-p", "parameters.xml"],
        &["rover.toml", "more.toml", "--plan", "plan.xml", "-p", "p.xml", "-s", "s.xml"],
        &["rover.toml", "--plan", "a.xml", "-p", "p.xml", "-s", "s.xml", "--journal", "kept"],
    ] {
        let said = call(&[&["run"], more].concat());
        assert_eq!(said.code, 2, "{more:?}: {said:?}");
    }
}
