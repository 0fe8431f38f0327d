//! What cannot be read.

use faregate_planner::file;

use super::{PLAN, parameters, with, wrong};

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
fn one_mistake_is_one_message() {
    let names = parameters();
    for (from, to, expected) in [
        // Nobody has the number that stands in for it.
        ("id=\"2\" name", "id=\"0\" name", "16:17 !range"),
        // Nobody knows whether that type has a minimum.
        ("type=\"expanding\"", "type=\"expand\"", "16:39 !unknown"),
    ] {
        let text = with(PLAN, &[(from, to)]);
        assert_eq!(wrong(&text, Some(&names)), [expected], "{to}");
    }
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
