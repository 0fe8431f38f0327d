//! A task that an operator adds as a line.
#![cfg(target_os = "linux")]

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use support::Scratch;
use support::run::Run;

#[test]
fn a_line_is_called_a_line_and_what_is_wrong_with_it_is_told() {
    let scratch = Scratch::new();
    let mission = scratch.file("mission.toml", "[mission]\nname = 'a mission'\n");
    let run = Run::start(&scratch, &[mission.to_str().unwrap()]);
    let said = run.operate(&["add", "--line", "41 0 0 2 0 250 0 0 sleep 2"]);
    assert_eq!(said.code, 5, "{said:?}");
    assert!(said.err.contains("the line: nothing of it was added: it has mistakes"), "{said:?}");
    assert!(said.err.contains("line 1, column 12: pri: `250`"), "{said:?}");
    assert_eq!(run.must(&["add", "--line", "41 +60 0 2 0 25 0 0 true"]).out, "the line: added\n");
    assert_eq!(run.end().code, 0);
}
