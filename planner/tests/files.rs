//! Files: read, judged, written, and read again.

use faregate_planner::file::{self, Document, Loaded};
use faregate_planner::{Parameters, Plan, State};
use faregate_scheduler::format::{Diagnostic, render};

const PLAN: &str = include_str!("../templates/plan.xml");
const PARAMETERS: &str = include_str!("../templates/parameters.xml");
const STATE: &str = include_str!("../templates/state.xml");

fn good<T>(text: &str, read: Result<Loaded<T>, Vec<Diagnostic>>) -> T {
    let loaded = read.unwrap_or_else(|found| panic!("{}", render(&found, text.as_bytes(), false)));
    assert_eq!(loaded.warnings, [], "{}", render(&loaded.warnings, text.as_bytes(), false));
    loaded.value
}

fn parameters() -> Parameters {
    good(PARAMETERS, file::parameters("parameters.xml", PARAMETERS.as_bytes()))
}

fn plan() -> Plan {
    good(PLAN, file::plan("plan.xml", PLAN.as_bytes(), Some(&parameters())))
}

fn state() -> State {
    good(STATE, file::state("state.xml", STATE.as_bytes(), Some(&parameters())))
}

#[test]
fn the_templates_are_the_same_after_each_way_through_each_form() {
    let names = parameters();
    let all =
        [Document::Plan(plan()), Document::Parameters(parameters()), Document::State(state())];
    for document in all {
        for parameters in [Some(&names), None] {
            let xml = file::to_xml(&document, parameters);
            let read = file::read("a.xml", xml.as_bytes(), parameters);
            assert_eq!(read.map(|read| read.value).as_ref(), Ok(&document), "{xml}");
            let binary = file::to_binary(&document);
            let read = file::read("a.plan", &binary, parameters);
            assert_eq!(read.map(|read| read.value).as_ref(), Ok(&document));
        }
    }
}

/// What is wrong with a text: where, by which rule, and what is said.
fn wrong(text: &str, parameters: Option<&Parameters>) -> Vec<String> {
    let found = match file::read("a.xml", text.as_bytes(), parameters) {
        Ok(loaded) => loaded.warnings,
        Err(found) => found,
    };
    let line = |one: &Diagnostic| {
        let (sign, place) = (if one.is_error() { '!' } else { '?' }, &one.place);
        format!("{}:{} {sign}{}", place.line, place.column, one.rule.name())
    };
    found.iter().map(line).collect()
}

/// The template with pieces replaced: each must be in it exactly once.
fn with(template: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(template.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text.replace(from, to)
    })
}

/// Which rules a changed template breaks.
fn broken(template: &str, from: &str, to: &str) -> Vec<String> {
    let names = parameters();
    let rules = wrong(&with(template, &[(from, to)]), Some(&names));
    rules.iter().map(|one| one.split_once(' ').unwrap().1.to_owned()).collect()
}

#[test]
fn what_cannot_be_read_is_told_all_at_once_with_line_and_column() {
    let text = r#"<?xml version="1.0"?>
<plan version="1" name="a" handover="10:00" handover_min_soc="120 %" end="25:00" max_delta_data="1.5 B">
  <activity id="0" priority="-1" duration="25" marginal="12.0005 W" colour="red">
    <start from="10:61" to="soon" cutoff="9"/>
    <uses zone="mast" bit="3"/>
    <uses bit="128"/>
    <condition kind="XYZ" variable="a" min="5" max="4"/>
    <impact timeline="arm"/>
    text
    <nothing/>
  </activity>
  <activity id="2" priority="1" duration="25 km" energy="1e3 J" type="expandin" peak="5"/>
</plan>
"#;
    let found = wrong(text, None);
    let expected = [
        "2:63 !range",
        "2:75 !range",
        "2:98 !range",
        "3:17 !range",
        "3:30 !range",
        "3:58 !range",
        "3:69 !unknown",
        "4:18 !value",
        "4:29 !value",
        "5:28 !duplicate",
        "6:16 !range",
        "7:22 !unknown",
        "7:53 !limits",
        "8:6 !missing",
        "9:5 !unknown",
        "10:6 !unknown",
        "12:4 !missing",
        "12:43 !value",
        "12:58 !value",
        "12:71 !unknown",
        "12:87 !value",
    ];
    for one in expected {
        assert!(found.iter().any(|found| found == one), "{one} is not in {found:#?}");
    }
    let told = |one: &String| expected.contains(&one.as_str()) || one.ends_with("?assumed");
    assert!(found.iter().all(told), "{found:#?}");
}

#[test]
fn what_is_no_xml_is_told_with_its_place() {
    let plan = "<plan version=\"1\"";
    for (text, expected) in [
        ("", "1:1 !missing"),
        ("<plan>\n  <activity>\n</plan>", "3:1 !syntax"),
        ("<plan>\n", "1:2 !syntax"),
        ("<plan a=1 b='2'/>", "1:9 !syntax"),
        ("<plan a='1' a='2'/>", "1:13 !duplicate"),
        ("<plan a='&nobody;'/>", "1:10 !syntax"),
        ("<!DOCTYPE plan [<!ENTITY a 'b'>]><plan/>", "1:1 !syntax"),
        ("<?xml version='1.0' encoding='latin1'?><plan/>", "1:1 !encoding"),
        ("<sequence version='1'/>", "1:2 !format"),
        ("<plan version='2'/>", "1:16 !version"),
        (plan, "1:1 !syntax"),
    ] {
        let found = wrong(text, None);
        assert!(found.iter().any(|one| one == expected), "{text}: {found:?}");
    }
    let deep = "<plan>".repeat(100_000);
    assert!(wrong(&deep, None).contains(&"1:50 !unknown".to_owned()));
}

#[test]
fn plans_that_cannot_be_meant_are_refused_and_what_cannot_run_is_warned_of() {
    let rows = [
        ("handover=\"1T06:30\"", "handover=\"1T10:30\"", "!limits"),
        ("id=\"6\" name", "id=\"5\" name", "!duplicate"),
        ("from=\"17:00\" to=\"17:00\"", "from=\"17:00\" to=\"16:59\"", "!window"),
        ("cutoff=\"17:20\"", "cutoff=\"17:19:59.999\"", "!window"),
        ("minimum=\"30 min\"", "minimum=\"91 min\"", "!limits"),
        ("minimum=\"30 min\"", "", "!missing"),
        ("minimum=\"30 min\"", "minimum=\"0 s\"", "!range"),
        ("duration=\"20 min\"", "duration=\"0 min\"", "!range"),
        ("energy=\"180 Wh\"", "energy=\"182 Wh\"", "!energy"),
        ("energy=\"180 Wh\"", "energy=\"178 Wh\"", "!energy"),
        ("duration=\"20 min\"", "duration=\"20 min\" wakeup=\"1 min\"", "!kind"),
        ("wakeup=\"4 min\"", "wakeup=\"48 min\"", "!limits"),
        ("status=\"FAILED ABORTED\"", "status=\"SUCCEEDED\"", "!kind"),
        ("status=\"FAILED ABORTED\"", "status=\"FAILED FAILED\"", "!duplicate"),
        ("<after activity=\"2\"", "<after activity=\"12\"", "!unknown-activity"),
        ("<after activity=\"1\"", "<after activity=\"3\"", "!cycle"),
        ("<after activity=\"1\"", "<after activity=\"2\"", "!cycle"),
        ("priority=\"210\"", "priority=\"199\"", "?importance"),
        ("<uses zone=\"wheels\"/>", "<uses zone=\"wheel\"/>", "!unknown-name"),
        ("<uses zone=\"wheels\"/>", "<uses bit=\"0\"/>", "!duplicate"),
        ("timeline=\"arm\" set_at_start=\"2\"", "timeline=\"arm\" hold=\"2\"", "!kind"),
        (
            "timeline=\"arm\" set_at_start=\"2\"",
            "timeline=\"leg\" set_at_start=\"2\"",
            "!unknown-name",
        ),
        (
            "timeline=\"imaging_memory\" hold=\"1\"",
            "timeline=\"imaging_memory\" hold=\"0\"",
            "!range",
        ),
        ("timeline=\"arm\" min=\"0\" max=\"0\"", "timeline=\"arm\" min=\"4\"", "?never-runs"),
        ("peak=\"220 W\"", "peak=\"310.001 W\"", "?never-runs"),
        ("engines=\"2\"", "engines=\"5\"", "?never-runs"),
        ("data=\"25 MB\"", "data=\"120.000001 MB\"", "?never-runs"),
        ("value=\"100\" group=\"arm work\"", "value=\"100\" group=\"other\"", "?no-effect"),
        ("priority=\"255\" duration", "priority=\"255\" peak=\"5 W\" duration", "?no-effect"),
        (
            "from=\"09:00\" to=\"11:00\" cutoff=\"11:40\"",
            "from=\"13:30\" to=\"14:00\" cutoff=\"14:40\"",
            "?window",
        ),
        (
            "from=\"17:00\" to=\"17:00\" cutoff=\"17:20\"",
            "from=\"2T17:00\" to=\"2T17:00\" cutoff=\"2T17:20\"",
            "?never-runs",
        ),
        ("data=\"25 MB\"", "data=\"9223372036.8 GB\"", "!range"),
    ];
    for (from, to, rule) in rows {
        let found = broken(PLAN, from, to);
        assert!(found.iter().any(|one| one == rule), "{from} -> {to}: {found:?}, not {rule}");
    }
    // What is just right is right.
    let good = [
        ("cutoff=\"17:20\"", "cutoff=\"17:20:00.000\""),
        ("energy=\"180 Wh\"", "energy=\"181.8 Wh\""),
        ("minimum=\"30 min\"", "minimum=\"1 h 30 min\""),
        ("peak=\"220 W\"", "peak=\"310 W\""),
        ("data=\"25 MB\"", "data=\"120 MB\""),
        ("wakeup=\"4 min\"", "wakeup=\"47 min\""),
        ("handover=\"1T06:30\"", "handover=\"1T10:00\""),
        ("priority=\"210\"", "priority=\"200\""),
    ];
    for (from, to) in good {
        assert_eq!(broken(PLAN, from, to), [""; 0], "{from} -> {to}");
    }
}

#[test]
fn parameters_and_states_that_cannot_be_meant_are_refused() {
    let parameters = [
        ("hard_min_soc=\"30 %\"", "hard_min_soc=\"40.0001 %\"", "!limits"),
        ("max_soc=\"95 %\"", "max_soc=\"39 %\"", "!limits"),
        ("max_soc=\"95 %\"", "max_soc=\"100.1 %\"", "!range"),
        ("soft_samples=\"3\"", "soft_samples=\"0\"", "!range"),
        ("peak_limit=\"400 W\"", "peak_limit=\"89 W\"", "?never-runs"),
        ("<preheat from=\"09:30\"", "<preheat from=\"00:00\"", "!table"),
        ("<preheat from=\"09:30\"", "<preheat from=\"24:39:35.244\"", "!table"),
        ("<preheat from=\"00:00\" duration=\"2 h\"/>", "", "!table"),
        ("<timeline name=\"arm\"", "<timeline name=\"sample_tubes\"", "!duplicate"),
        ("initial=\"12\"", "initial=\"39\"", "!limits"),
        ("name=\"arm\" bit=\"1\"", "name=\"arm\" bit=\"0\"", "!duplicate"),
        ("length=\"88775.244\"", "length=\"0\"", "!range"),
        ("<day", "<day/><day", "!duplicate"),
        ("<awake marginal=\"75 W\" peak=\"90 W\"/>", "", "!missing"),
        ("rtg=\"110 W\"", "rtg=\"9223372036854775.807 W\"", "!range"),
    ];
    let states = [
        ("charge=\"1900 Wh\"", "charge=\"2400.001 Wh\"", "!limits"),
        ("capacity=\"2400 Wh\"", "capacity=\"0 Wh\"", "!range"),
        ("mode_since=\"-1T20:00\"", "mode_since=\"06:30:00.001\"", "!window"),
        ("end=\"08:12\"", "end=\"07:59\"", "!window"),
        ("<timeline name=\"arm\"", "<timeline name=\"leg\"", "!unknown-name"),
        ("name=\"camera_temperature\"", "name=\"drive_permitted\"", "!duplicate"),
        (
            "<uses resource=\"radio\"/>\n  </window>\n  <window",
            "<uses zone=\"mast\"/></window><window",
            "!unknown",
        ),
    ];
    let rows = parameters.map(|row| (PARAMETERS, row));
    for (text, (from, to, rule)) in rows.into_iter().chain(states.map(|row| (STATE, row))) {
        let found = broken(text, from, to);
        assert!(found.iter().any(|one| one == rule), "{from} -> {to}: {found:?}, not {rule}");
    }
    let ran =
        |what| with(STATE, &[("<variable name=\"drive", &format!("{what}<variable name=\"drive"))]);
    let names = self::parameters();
    for (what, rule) in [
        (r#"<ended activity="1" outcome="FAILED" started="05:00" ended="06:31"/>"#, "!window"),
        (r#"<ended activity="1" outcome="FAILED" started="05:00" ended="04:59"/>"#, "!window"),
        (r#"<running activity="1" started="06:31" ends="07:00" cutoff="08:00"/>"#, "!window"),
        (
            r#"<running activity="1" started="06:00" ends="07:00" cutoff="08:00" paused="05:00"/>"#,
            "!window",
        ),
        (r#"<cold zone="mast"/><cold zone="mast"/>"#, "!duplicate"),
        (r#"<heating zone="mast" since="06:31"/>"#, "!window"),
    ] {
        let found = wrong(&ran(what), Some(&names));
        assert!(found.iter().any(|one| one.ends_with(rule)), "{what}: {found:?}, not {rule}");
    }
}

#[test]
fn a_plan_and_a_state_are_judged_together() {
    let (plan, names) = (plan(), parameters());
    let judged = |from: &str, to: &str| {
        let text = with(STATE, &[(from, to)]);
        let state = good(&text, file::state("state.xml", text.as_bytes(), Some(&names)));
        let found = file::together(&plan, &names, &state, ("state.xml", text.as_bytes()));
        found.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(judged("now=\"06:30\"", "now=\"06:31\""), [""; 0]);
    let window = judged("start=\"08:00\" end=\"08:12\"", "start=\"19:49\" end=\"20:00\"");
    assert!(window[0].contains("needs the computer, which activity 7 shuts down"), "{window:?}");
    assert!(window[0].starts_with("state.xml:10:41: error"), "{window:?}");
    // The radio alone does not need the computer, and ends do not overlap.
    assert_eq!(judged("start=\"15:40\" end=\"15:55\"", "start=\"19:30\" end=\"20:00\""), [""; 0]);
    assert_eq!(judged("start=\"08:00\" end=\"08:12\"", "start=\"18:48\" end=\"19:00\""), [""; 0]);
    let with =
        |what: &str| judged("<variable name=\"drive_p", &format!("{what}<variable name=\"drive_p"));
    let ended = with(r#"<ended activity="77" outcome="FAILED" ended="05:00"/>"#);
    assert!(ended[0].contains("warning: the state: the plan has no activity 77"), "{ended:?}");
    let running = with(r#"<running activity="77" started="05:00" ends="08:00" cutoff="09:00"/>"#);
    assert!(running[0].contains("error: the state: the plan has no activity 77"), "{running:?}");
    // What each file by itself may say, and the planner could not count.
    let large = judged("capacity=\"2400 Wh\"", "capacity=\"2562047788 Wh\"");
    assert!(large[0].contains("the three together: energy: so large that sums"), "{large:?}");
}

#[test]
fn a_file_of_another_kind_is_refused_in_either_form() {
    let names = parameters();
    for bytes in [STATE.as_bytes().to_vec(), file::to_binary(&Document::State(state()))] {
        let found = file::plan("x", &bytes, Some(&names)).unwrap_err();
        assert!(found[0].to_string().contains("this is a state; expected a plan"), "{found:?}");
    }
}

#[test]
fn compact_files_are_judged_as_xml_is() {
    let names = parameters();
    let mut late = plan();
    late.handover = late.end.after(faregate_planner::units::Span::new(1));
    let found = file::read("x.bin", &file::to_binary(&Document::Plan(late)), Some(&names));
    let found = found.unwrap_err();
    assert!(
        found[0].to_string().contains("x.bin:1:1: error: the plan: the next plan takes over after")
    );
    let mut unsayable = plan();
    unsayable.name = "a\nb".into();
    let found = file::read("x.bin", &file::to_binary(&Document::Plan(unsayable)), Some(&names));
    assert!(found.is_err());
}

#[test]
fn compact_files_of_another_version_or_kind_are_refused() {
    use faregate_planner::file::binary::{self, NotRead};
    let good = binary::write(&plan());
    let mut newer = good.clone();
    newer[8] = 2;
    assert_eq!(binary::read::<Plan>(&newer), Err(NotRead::Version { found: 2 }));
    let wanted = NotRead::Kind { found: "a plan", wanted: "a state" };
    assert_eq!(binary::read::<State>(&good), Err(wanted));
    let timed = faregate_planner::TimedPlan::default();
    assert_eq!(binary::read(&binary::write(&timed)), Ok(timed));
    assert_eq!(binary::read::<Plan>(b"<plan/>"), Err(NotRead::Other));
}

#[test]
fn quantities_are_read_exactly_or_not_at_all() {
    let priority = |unit: &str, to: &str| {
        let text = with(PLAN, &[(unit, to)]);
        let names = parameters();
        file::plan("a.xml", text.as_bytes(), Some(&names)).map(|loaded| loaded.value)
    };
    let duration = |text: &str| {
        let read = priority("duration=\"20 min\"", &format!("duration=\"{text}\""));
        read.map(|plan| plan.activities[5].duration.get()).map_err(|found| found[0].rule.name())
    };
    assert_eq!(duration("1200"), Ok(1_200_000));
    assert_eq!(duration("1 h -5 min"), Err("value"));
    assert_eq!(duration("19.99999 min"), Err("range"), "59.9994 s are no whole milliseconds");
    assert_eq!(duration("0.0005 min"), Ok(30));
    assert_eq!(duration("15min 4 s 250ms"), Ok(904_250));
    assert_eq!(duration("99999999999999999999999999999999999999999 h"), Err("range"));
    assert_eq!(duration("-1 min"), Err("range"));
    assert_eq!(duration("1,5 min"), Err("value"));
    let data = |text: &str| {
        let read = priority("data=\"25 MB\"", &format!("data=\"{text}\""));
        read.map(|plan| plan.activities[3].data.get()).map_err(|found| found[0].rule.name())
    };
    assert_eq!(data("8 bit"), Ok(1));
    assert_eq!(data("12 bit"), Err("range"));
    assert_eq!(data("-1.5 KiB"), Ok(-1536));
    assert_eq!(data("25 Mb"), Err("value"), "bit or byte: it is not guessed");
    let time = |text: &str| {
        let read = priority("handover=\"1T06:30\"", &format!("handover=\"{text}\""));
        read.map(|plan| plan.handover.get()).map_err(|found| found[0].rule.name())
    };
    assert_eq!(time("1T06:30"), Ok(88_775_244 + 23_400_000));
    assert_eq!(time("-1T00:00:00.001"), Ok(-88_775_243));
    assert_eq!(time("-0.5"), Ok(-500));
    assert_eq!(time("24:39:35.243"), Ok(88_775_243));
    assert_eq!(time("24:39:35.244"), Err("range"), "the next sol's");
    assert_eq!(time("10:30:00.0001"), Err("range"));
    assert_eq!(time("1030"), Ok(1_030_000));
}

#[test]
fn files_of_this_version_can_still_be_read() {
    let files = [
        (&include_bytes!("compact/plan.bin")[..], Document::Plan(plan())),
        (&include_bytes!("compact/parameters.bin")[..], Document::Parameters(parameters())),
        (&include_bytes!("compact/state.bin")[..], Document::State(state())),
    ];
    let names = parameters();
    for (bytes, document) in files {
        let read = file::read("a.bin", bytes, Some(&names)).map(|loaded| loaded.value);
        let why = "the models have changed: so must file::VERSION, and tests/compact is to be \
                   written again with `faregate plan convert`; or a template has changed";
        assert_eq!(read.as_ref(), Ok(&document), "{why}");
        assert_eq!(file::to_binary(&document), bytes, "{why}");
    }
}
