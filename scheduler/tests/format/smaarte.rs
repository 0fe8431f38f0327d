//! SMAARTE's formats, as spreadsheets save them, too.

use faregate_agents::Categories;
use faregate_scheduler::format::{self, Conflict, Options, Rule};
use faregate_scheduler::task::{Body, BuiltIn, Preemption};
use faregate_scheduler::time::Duration;
use faregate_tickets::amount::Milliwatts;

use crate::support::{bad, good, only, told};

const HEADER: &str = "id,st,et,dur,con,pri,type,interval,args\n";

fn row(text: &str) -> String {
    format!("{HEADER}{text}\n")
}

#[test]
fn columns_are_found_by_their_names() {
    let text = "args,interval,type,pri,con,dur,et,st,id\n\"echo a,b\",0,0,2,0x5,0.15,0,+1,7\n";
    let task = only("a.csv", text);
    assert_eq!((task.id.get(), task.priority.level(), task.categories.mask()), (7, 2, 5));
    assert_eq!(task.duration, Duration::from_millis(150));
    let echo = Body::Process { program: "echo".into(), arguments: vec!["a,b".into()] };
    assert_eq!(task.body, echo);
}

#[test]
fn optional_columns_may_be_there_and_their_fields_empty() {
    let text = "id,st,et,dur,con,pri,type,interval,memory,storage,power,draw_w,gap,cutoff,preempt,gates,args\n\
                1,0,0,1,1,1,0,0,1024,2048,0,4.5,2,+9,kill:2.5,camera;gimbal,true\n\
                2,0,0,1,all,1,0,0,,,,,,,,,true\n";
    let options = Options { against: format::Against::Nothing, ..Options::default() };
    let tasks = format::read_with(options, "a.csv", text.as_bytes()).unwrap().tasks;
    assert_eq!(tasks[0].gates, ["camera", "gimbal"]);
    assert_eq!((tasks[0].memory, tasks[0].storage), (1_024, 2_048));
    assert_eq!(tasks[0].peak_draw, Milliwatts::new(4_500));
    assert_eq!(tasks[0].preemption, Preemption::Kill { grace: Duration::from_millis(2_500) });
    assert_eq!(tasks[1].preemption, Preemption::Pause);
    assert_eq!(tasks[1].categories, Categories::ALL);
}

#[test]
fn a_file_is_read_as_a_spreadsheet_saves_it() {
    let text = "\u{feff}id,st,et,dur,con,pri,type,interval,args,,\r\n\
                1,0,0,3,1,1,0,0,\"say \"\"a, b\"\"\",,\r\n\
                ,,,,,,,,,,\r\n\
                2,0,0,3,1,1,1,0\r\n\r\n\r\n";
    let tasks = good("a.csv", text).tasks;
    let say = Body::Process { program: "say".into(), arguments: vec!["a, b".into()] };
    assert_eq!(tasks[0].body, say);
    assert_eq!(tasks[1].body, Body::BuiltIn(BuiltIn::Clear { all: false }));
    let old_macintosh = row("1,0,0,3,1,1,0,0,true").replace('\n', "\r");
    assert_eq!(good("a.csv", &old_macintosh).tasks.len(), 1);
}

#[test]
fn a_file_with_spaces_may_have_a_header_and_arguments_are_the_rest_of_the_line() {
    let text = "id st et dur con pri type interval gap args\r\n\
                1  0  0  3   1   1   0    0        5   echo  'a  b',c \r\n\r\n";
    let task = only("a.txt", text);
    assert_eq!(task.gap, Duration::from_secs(5));
    let echo = Body::Process { program: "echo".into(), arguments: vec!["a  b,c".into()] };
    assert_eq!(task.body, echo);
    assert!(good("empty.txt", "").tasks.is_empty());
    let wrong = bad("a.txt", "id st et dur con pri args type interval\n");
    assert_eq!(wrong, [(1, 22, Rule::Header)]);
}

#[test]
fn functions_are_paused_by_nobody() {
    let tasks = good("a.csv", &row("1,0,0,3,1,1,16,0,a b\n2,0,0,3,1,1,6,0,")).tasks;
    assert_eq!((&tasks[0].preemption, &tasks[1].body), (&Preemption::Wait, &Body::Hold));
}

#[test]
fn no_task_comes_round_more_often_than_each_millisecond() {
    let text = row("1,0,0,3,1,1,0,0.001,true\n2,0,0,3,1,1,0,0.000999,true");
    let found = format::read("a.csv", text.as_bytes()).unwrap_err();
    assert_eq!(told(&found), [(3, 15, Rule::Range)]);
}

#[test]
fn equal_numbers_conflict_in_files_of_2018() {
    let text = "1 0 0 3 0 1 0 0 true\n2 0 0 3 3 1 0 0 true\n3 0 0 3 128 1 0 0 true\n";
    let options = Options { conflict: Conflict::Number, ..Options::default() };
    let found = format::read_with(options, "a.txt", text.as_bytes()).unwrap_err();
    assert_eq!(told(&found), [(3, 9, Rule::Range)]);
    let short = text.lines().take(2).collect::<Vec<_>>().join("\n");
    let tasks = format::read_with(options, "a.txt", short.as_bytes()).unwrap().tasks;
    assert_eq!((tasks[0].categories.mask(), tasks[1].categories.mask()), (1, 8));
}

#[test]
fn commas_without_quotes_are_told_with_what_to_do() {
    let found = format::read("a.csv", row("1,0,0,3,1,1,0,0,take 1,2,,").as_bytes()).unwrap_err();
    assert_eq!(told(&found), [(2, 24, Rule::ExtraFields)]);
    assert!(found[0].help.as_ref().unwrap().contains("quotes"));
}

#[test]
fn a_wrong_header_is_told_once_and_the_rest_is_read_all_the_same() {
    let text = "id,st,et,duration,con,pri,type,interval,args,colour\n1,0,0,3,x,1,0,0,true,red\n";
    let found = format::read("a.csv", text.as_bytes()).unwrap_err();
    let expected = [(1, 10, Rule::Unknown), (1, 46, Rule::Unknown), (2, 9, Rule::Value)];
    assert_eq!(told(&found), expected);
    assert_eq!(found[0].help.as_deref(), Some("did you mean dur?"));
    assert_eq!(bad("a.csv", "id,st,et,dur,con,pri,type,args\n"), [(1, 31, Rule::Header)]);
    assert_eq!(
        bad("a.csv", "id,id,st,et,dur,con,pri,type,interval,args\n"),
        [(1, 4, Rule::Duplicate)]
    );
    assert_eq!(bad("a.csv", "1,0,0,3,1,1,0,0,true\n"), [(1, 1, Rule::Header)]);
    assert_eq!(bad("a.csv", ""), [(1, 1, Rule::Header)]);
}

#[test]
fn a_quote_that_is_never_closed_hides_no_other_mistake() {
    let text = row(
        "1,0,0,3,1,1,0,0,\"say\n2,0,0,x,1,1,0,0,true\n3,0,0,3,1,1,0,0,\"a\"b\n4,0,0,3,1,1,0,0,say 'a",
    );
    let expected =
        [(2, 17, Rule::Quote), (3, 7, Rule::Value), (4, 17, Rule::Quote), (5, 17, Rule::Quote)];
    assert_eq!(bad("a.csv", &text), expected);
}

#[test]
fn what_needs_a_mission_is_an_error_without_one() {
    let text = "id,st,et,dur,con,pri,type,interval,power,args\n1,0,0,3,1,1,0,0,20,true\n2,0,0,0,0,9,4,0,0,safe\n";
    assert_eq!(bad("a.csv", text), [(2, 17, Rule::NoBattery), (3, 19, Rule::UnknownName)]);
    let options = Options { against: format::Against::Nothing, ..Options::default() };
    assert_eq!(format::read_with(options, "a.csv", text.as_bytes()).unwrap().tasks.len(), 2);
}

#[test]
fn who_wants_a_shell_is_told_that_there_is_none() {
    let warned = good("a.csv", &row("1,0,0,3,1,1,0,0,take > file")).warnings;
    assert_eq!(told(&warned), [(2, 17, Rule::NoShell)]);
}

#[test]
fn a_name_says_the_format() {
    assert_eq!(bad("schedule", "")[0].2, Rule::Format);
    assert_eq!(good("A.CSV", HEADER).tasks.len(), 0);
}

#[test]
fn what_is_no_schedule_at_all_is_read_until_it_is_hopeless() {
    let read = |rows: u32, rest: &str| {
        let rows: String = (1..=rows).map(|id| format!("{id},{rest}\n")).collect();
        format::read("log.csv", format!("{HEADER}{rows}").as_bytes())
    };
    let few = read(9_000, "x,0,3,1,1,0,0,sleep 3").unwrap_err();
    assert_eq!(few.len(), 9_000);
    let many = read(12_000, "x,0,3,1,1,0,0,sleep 3").unwrap_err();
    assert_eq!(many.len(), 10_000);
    let last = many.last().unwrap();
    assert_eq!(last.place.line, 10_001);
    assert!(last.help.as_ref().unwrap().contains("no further"), "{last:?}");
    // Warnings, however many, keep nothing from being read.
    let good = read(12_000, "0,0,3,1,1,0,0,sleep 3 # a while").unwrap();
    assert_eq!((good.tasks.len(), good.warnings.len()), (12_000, 12_000));
}
