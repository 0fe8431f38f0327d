//! What can be read, and cannot be meant.

use faregate_planner::file;

use super::{PARAMETERS, PLAN, STATE, good, parameters, plan, with, wrong};

/// Which rules a changed template breaks.
fn broken(template: &str, from: &str, to: &str) -> Vec<String> {
    let names = parameters();
    let rules = wrong(&with(template, &[(from, to)]), Some(&names));
    rules.iter().map(|one| one.split_once(' ').unwrap().1.to_owned()).collect()
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
fn sums_that_could_overflow_are_refused_when_a_file_is_read() {
    let names = parameters();
    let told = |from: &str, to: &str| {
        let text = with(PLAN, &[(from, to)]);
        let found = file::plan("plan.xml", text.as_bytes(), Some(&names)).err().unwrap_or_default();
        found.iter().filter(|one| one.is_error()).map(ToString::to_string).collect::<Vec<_>>()
    };
    // Each by itself could be counted, and all together not.
    let peak = |mw: u64| format!("peak=\"{}.{:03} W\"", mw / 1_000, mw % 1_000);
    let others = other_peaks();
    let most = u64::try_from(i64::MAX).expect("it is positive") - others;
    assert_eq!(told("peak=\"220 W\"", &peak(most)), [""; 0]);
    let [found] = <[String; 1]>::try_from(told("peak=\"220 W\"", &peak(most + 1))).expect("one");
    assert!(found.contains("the sum of all peaks is too large to be counted"), "{found}");
}

/// What all activities of the plan but the one of 220 W draw at most.
fn other_peaks() -> u64 {
    let all = plan().activities.into_iter().map(|one| one.peak.get());
    all.sum::<u64>() - 220_000
}
