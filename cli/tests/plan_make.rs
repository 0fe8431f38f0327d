//! `plan make`: what it prints, what it writes, how it ends.

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::path::Path;

use serde_json::Value;
use support::{Said, Scratch, call};

const PARAMETERS: &str = r#"<parameters version="1" mandatory_from="100"
    soft_min_soc="40 %" hard_min_soc="30 %" max_soc="95 %"
    peak_limit="400 W" engines="2" rtg="110 W" base="50 W"
    min_awake="10 min" min_sleep="30 min"
    commit="30 min" expansion_grace="2 min" handover_tolerance="5 s" soft_samples="3">
  <awake marginal="120 W" peak="140 W"/>
  <wakeup duration="5 min" marginal="90 W" peak="140 W"/>
  <shutdown duration="5 min" marginal="90 W" peak="140 W"/>
  <day length="88775.244" midnight="0"/>
  <resource name="arm" bit="2"/>
</parameters>"#;

const STATE: &str = r#"<state version="1" now="10:00" mode="awake" mode_since="09:00"
    charge="1800 Wh" capacity="2400 Wh"/>"#;

/// An activity that needs the arm for half an hour.
fn arm(id: u32, name: &str, priority: u32) -> String {
    format!(
        r#"<activity id="{id}" name="{name}" priority="{priority}" duration="30 min" marginal="20 W" peak="40 W">
             <start from="10:10" to="10:10" cutoff="11:00"/><uses resource="arm"/>
           </activity>"#
    )
}

fn plan(activities: &[String]) -> String {
    format!(
        r#"<plan version="1" name="arm work" handover="18:00" handover_min_soc="50 %" end="20:00"
             max_delta_data="10 MB">{}</plan>"#,
        activities.concat()
    )
}

/// Makes a timed plan of these files.
fn make(scratch: &Scratch, plan: &str, more: &[&str]) -> Said {
    let plan = scratch.file("plan.xml", plan);
    let parameters = scratch.file("parameters.xml", PARAMETERS);
    let state = scratch.file("state.xml", STATE);
    let mut words = vec!["plan", "make", text(&plan), "-p", text(&parameters), "-s", text(&state)];
    words.extend(more);
    call(&words)
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path of letters")
}

fn statuses(said: &Said) -> Vec<String> {
    let document = said.json();
    let rows = document["activities"].as_array().expect("rows");
    rows.iter().map(|row| row["status"].as_str().expect("a word").to_owned()).collect()
}

#[test]
fn the_table_says_who_has_what_another_one_needs() {
    let scratch = Scratch::new();
    let said = make(&scratch, &plan(&[arm(1, "place", 90), arm(2, "brush", 80)]), &[]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("arm in use at 10:10 by place"), "{}", said.out);
    assert!(said.out.contains("10:40"), "the end of the other one: {}", said.out);
}

#[test]
fn a_mandatory_activity_that_is_left_out_ends_it_with_2_and_an_optional_one_does_not() {
    let scratch = Scratch::new();
    let said = make(&scratch, &plan(&[arm(1, "place", 190), arm(2, "brush", 180)]), &[]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.out.contains("mandatory activities are left out: brush"), "{}", said.out);
    let said = make(&scratch, &plan(&[arm(1, "place", 190), arm(2, "brush", 99)]), &[]);
    assert_eq!(said.code, 0, "{said:?}");
}

#[test]
fn what_starts_within_the_commit_window_stays_where_the_incumbent_has_it() {
    let scratch = Scratch::new();
    let out = scratch.path("timed.json");
    let first = make(&scratch, &plan(&[arm(1, "brush", 80)]), &["--out", text(&out)]);
    assert_eq!(first.code, 0, "{first:?}");
    let more_important = plan(&[arm(1, "brush", 80), arm(2, "place", 90)]);
    let anew = make(&scratch, &more_important, &["--format", "json"]);
    assert_eq!(statuses(&anew), ["left_out", "scheduled"]);
    let words = ["--format", "json", "--incumbent", text(&out)];
    let replanned = make(&scratch, &more_important, &words);
    assert_eq!(statuses(&replanned), ["scheduled", "left_out"]);
    assert_eq!(replanned.json()["violations"], Value::Array(Vec::new()));
}

#[test]
fn an_explanation_says_what_would_let_it_in_and_it_does() {
    let scratch = Scratch::new();
    let crowded = plan(&[arm(1, "place", 90), arm(2, "brush", 80)]);
    let said = make(&scratch, &crowded, &["--explain"]);
    let line = "brush: without arm, held by place until 10:40; starts at 10:10";
    assert!(said.out.contains(line), "{}", said.out);
    let dropped = crowded.rsplit_once("<uses resource=\"arm\"/>").expect("it uses the arm");
    let without = [dropped.0, dropped.1].concat();
    let said = make(&scratch, &without, &["--format", "json"]);
    assert_eq!(statuses(&said), ["scheduled", "scheduled"]);
    assert_eq!(said.json()["activities"][1]["start_s"], Value::from(36_600), "{said:?}");
}

/// The one pass takes the first; the other one is worth more.
fn dear_and_cheap() -> String {
    let dear = arm(2, "brush", 80).replace("priority=\"80\"", "priority=\"80\" value=\"500\"");
    plan(&[arm(1, "place", 90), dear])
}

#[test]
fn a_search_finds_what_the_one_pass_does_not_and_the_same_for_the_same_seed() {
    let scratch = Scratch::new();
    let one_pass = make(&scratch, &dear_and_cheap(), &["--format", "json"]);
    assert_eq!(statuses(&one_pass), ["scheduled", "left_out"]);
    let words = ["--format", "json", "--improve", "200", "--seed", "7"];
    let improved = make(&scratch, &dear_and_cheap(), &words);
    assert_eq!(statuses(&improved), ["left_out", "scheduled"]);
    assert_eq!(improved.out, make(&scratch, &dear_and_cheap(), &words).out);
    let said = make(&scratch, &dear_and_cheap(), &["--improve", "200"]);
    assert!(said.out.contains("optional activities worth 500 instead of 90"), "{}", said.out);
}

/// Signals that a process has handlers for, by its status.
#[cfg(target_os = "linux")]
fn caught(pid: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or_default()
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_ends_the_search_and_what_was_found_is_printed() {
    const SIGINT: u32 = 2;
    let scratch = Scratch::new();
    let paths = [
        scratch.file("plan.xml", dear_and_cheap()),
        scratch.file("parameters.xml", PARAMETERS),
        scratch.file("state.xml", STATE),
    ];
    let [plan, parameters, state] = paths.each_ref().map(|path| text(path));
    let endless = ["--improve", "1000000000000000"];
    let mut command = support::faregate();
    command.args(["plan", "make", plan, "-p", parameters, "-s", state]).args(endless);
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    while caught(child.id()) >> (SIGINT - 1) & 1 == 0 {
        assert!(child.try_wait().expect("a child").is_none(), "it ended by itself");
        std::thread::yield_now();
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill is there").success());
    let said: Said = child.wait_with_output().expect("it ends").into();
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("interrupted after"), "{}", said.out);
}

#[test]
fn instants_are_seconds_and_a_fraction_is_said_where_there_is_one() {
    let scratch = Scratch::new();
    let whole = plan(&[arm(1, "brush", 80)]);
    let said = make(&scratch, &whole, &["--format", "json"]);
    assert_eq!(said.json()["activities"][0]["start_s"], Value::from(36_600), "{said:?}");
    let fraction = whole.replace("30 min", "1.5 s");
    let said = make(&scratch, &fraction, &["--format", "json"]);
    assert_eq!(said.json()["activities"][0]["end_s"], Value::from(36_601.5), "{said:?}");
}

#[test]
fn mistakes_end_with_1_and_are_told_with_their_lines() {
    let scratch = Scratch::new();
    let wrong = plan(&[arm(1, "brush", 80)]).replace("resource=\"arm\"", "resource=\"leg\"");
    let said = make(&scratch, &wrong, &[]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.out.is_empty(), "{said:?}");
    assert!(said.err.contains("plan.xml:3") && said.err.contains("leg"), "{}", said.err);
}

#[test]
fn a_state_of_another_plan_is_told_before_anything_is_planned() {
    let scratch = Scratch::new();
    let paths = [
        scratch.file("plan.xml", plan(&[arm(1, "brush", 80)])),
        scratch.file("parameters.xml", PARAMETERS),
        scratch.file(
            "state.xml",
            STATE.replace(
                "/>",
                r#"><running activity="7" started="09:50" ends="10:20" cutoff="11:00"/></state>"#,
            ),
        ),
    ];
    let [plan, parameters, state] = paths.each_ref().map(|path| text(path));
    let said = call(&["plan", "make", plan, "-p", parameters, "-s", state]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("state.xml") && said.err.contains('7'), "{}", said.err);
}

#[test]
fn a_file_that_is_no_timed_plan_is_no_incumbent() {
    let scratch = Scratch::new();
    let other = scratch.file("other.json", "{\"rows\": 3}");
    let said = make(&scratch, &plan(&[arm(1, "brush", 80)]), &["--incumbent", text(&other)]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("other.json is no timed plan"), "{}", said.err);
}

#[test]
fn a_picture_is_drawn_where_it_is_asked_for() {
    let scratch = Scratch::new();
    let svg = scratch.path("plan.svg");
    let said = make(&scratch, &plan(&[arm(1, "brush", 80)]), &["--svg", text(&svg)]);
    assert_eq!(said.code, 0, "{said:?}");
    let picture = std::fs::read_to_string(&svg).expect("a picture");
    assert!(picture.contains("arm work") && picture.contains("1  brush"), "{picture}");
    let nowhere = scratch.path("no/such/folder.svg");
    let said = make(&scratch, &plan(&[arm(1, "brush", 80)]), &["--svg", text(&nowhere)]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("folder.svg cannot be written"), "{}", said.err);
    assert!(said.out.is_empty(), "that is told before anything is planned: {}", said.out);
    let said = make(&scratch, &plan(&[arm(1, "brush", 80)]), &["--out", text(&scratch.path(""))]);
    assert!(said.code == 1 && said.err.contains("it is a directory"), "{said:?}");
    assert!(said.out.is_empty(), "{}", said.out);
}

#[test]
#[cfg(target_os = "linux")]
fn a_plan_whose_picture_cannot_be_written_is_not_lost() {
    let scratch = Scratch::new();
    let said = make(&scratch, &plan(&[arm(1, "brush", 80)]), &["--svg", "/dev/full"]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("/dev/full cannot be written"), "{}", said.err);
    assert!(said.out.contains("brush"), "{}", said.out);
}
