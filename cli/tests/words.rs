//! What every sub-command has in common: help, exit codes, bad usage, a reader
//! that goes away.

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::collections::BTreeMap;
use std::fs;
use std::process::Stdio;

use faregate_client::exit::Exit;
use faregate_devices_sim::payload::{KINDS, UnitSpec};
use proptest::prelude::*;
use support::{Said, Scratch, call, faregate, root};

/// The sub-commands, as `--help` lists them.
fn sub_commands() -> Vec<String> {
    let help = call(&["--help"]).out;
    let listed = help.split("Commands:").nth(1).expect("a list").split("Options:").next();
    let first_words = listed.into_iter().flat_map(str::lines).filter_map(|line| {
        // Further lines of a description stand deeper.
        let line = line.strip_prefix("  ").filter(|line| !line.starts_with(' '))?;
        line.split_whitespace().next().map(String::from)
    });
    first_words.filter(|word| word != "help").collect()
}

#[test]
fn every_sub_command_explains_itself_and_is_in_the_documentation() {
    let documentation = fs::read_to_string(root().join("docs/cli.md")).unwrap();
    let listed = sub_commands();
    assert!(listed.len() >= 15, "{listed:?}");
    for word in listed {
        let help = call(&[word.as_str(), "--help"]);
        assert_eq!(help.code, 0, "{word}: {help:?}");
        assert!(help.out.contains("Usage: faregate"), "{word}: {help:?}");
        assert!(documentation.contains(&format!("`{word}")), "docs/cli.md does not know {word}");
    }
}

#[test]
fn exit_codes_are_the_same_in_the_help_and_in_the_documentation() {
    let help = call(&["--help"]).out;
    let documentation = fs::read_to_string(root().join("docs/cli.md")).unwrap();
    for (exit, meaning) in Exit::ALL {
        assert!(help.contains(&format!("{:>2}  {meaning}", exit.code())), "{meaning}");
        let row = format!("| {} | {meaning} |", exit.code());
        assert!(documentation.contains(&row), "docs/cli.md has no {row}");
    }
}

#[test]
fn wrong_words_end_with_2_and_say_what_is_right() {
    for wrong in [
        &["fly"][..],
        &["check"],
        &["set", "3"],
        &["set", "3", "--priority", "300"],
        &["set", "3", "--window", "soon..late"],
        &["add"],
        &["add", "a.csv", "--line", "1 0 0 1 1 1 0 0 true"],
        &["run", "a.csv", "--speed", "0"],
        &["run", "a.csv", "--speed", "10", "--virtual"],
        &["analyze", "a.csv", "--at", "yesterday"],
        &["mode", "change", "manoeuvre"],
        &["command", "camera"],
    ] {
        let said = call(wrong);
        assert_eq!(said.code, 2, "{wrong:?}: {said:?}");
        assert!(said.err.contains("--help"), "{wrong:?}: {said:?}");
        assert!(said.out.is_empty(), "{wrong:?}: {said:?}");
    }
}

#[test]
fn where_nobody_listens_every_live_sub_command_ends_with_7_and_says_where_it_looked() {
    let scratch = Scratch::new();
    let path = scratch.path("nobody.sock");
    let socket = path.to_str().unwrap();
    for words in [
        &["status"][..],
        &["watch"],
        &["add", "--line", "1 0 0 1 1 1 0 0 true"],
        &["remove", "1"],
        &["set", "1", "--priority", "3"],
        &["clear"],
        &["hold", "1"],
        &["resume", "1"],
        &["mode", "enter", "manoeuvre"],
        &["shutdown"],
    ] {
        let said = call(&[words, &["--socket", socket]].concat());
        assert_eq!(said.code, i32::from(Exit::NoPort.code()), "{words:?}: {said:?}");
        assert!(said.err.contains(socket), "{words:?}: {said:?}");
    }
}

#[test]
fn outside_a_task_there_is_no_way_to_a_device() {
    for words in [&["command", "camera", "on"][..], &["heartbeat"]] {
        let said = call(words);
        assert_eq!(said.code, i32::from(Exit::NoPort.code()), "{said:?}");
        assert!(said.err.contains("FAREGATE_PORT"), "{said:?}");
        // A number that is a file, and no port.
        let output = faregate().args(words).env("FAREGATE_PORT", "1").output().unwrap();
        assert_eq!(output.status.code(), Some(i32::from(Exit::NoPort.code())), "{output:?}");
    }
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let scratch = Scratch::new();
    let missing = scratch.path("missing.csv");
    let missing = missing.to_str().unwrap();
    for words in [
        &["check", missing][..],
        &["analyze", missing],
        &["run", missing],
        &["convert", missing, "x.toml"],
        &["add", missing],
    ] {
        let said = call(words);
        assert_eq!(said.code, 1, "{words:?}: {said:?}");
        assert!(said.err.contains(missing), "{words:?}: {said:?}");
    }
}

#[test]
fn a_file_that_is_too_long_is_refused_before_it_fills_the_memory() {
    let scratch = Scratch::new();
    let long = |name: &str| {
        let path = scratch.path(name);
        // A hole: it takes no room on the disk.
        fs::File::create(&path).unwrap().set_len((64 << 20) + 1).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let (csv, xml) = (long("long.csv"), long("long.xml"));
    for words in [
        &["check", &csv][..],
        &["analyze", &csv],
        &["run", &csv],
        &["convert", &csv, "x.toml"],
        &["add", &csv],
        &["plan", "check", &xml],
        &["plan", "diff", &xml, &xml],
    ] {
        let said = call(words);
        assert_eq!(said.code, 1, "{words:?}: {said:?}");
        assert!(said.err.contains("is longer than 64 MiB"), "{words:?}: {said:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_file_without_an_end_is_refused_when_it_is_too_long() {
    let scratch = Scratch::new();
    let zero = scratch.path("zero.csv");
    std::os::unix::fs::symlink("/dev/zero", &zero).unwrap();
    // With a limit of memory, so that no host suffers where this fails.
    let output = std::process::Command::new("sh")
        .args(["-c", "ulimit -v 1000000; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_faregate")])
        .args(["check".as_ref(), zero.as_os_str()])
        .output()
        .unwrap();
    let said = Said::from(output);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.err.contains("is longer than 64 MiB"), "{said:?}");
}

#[test]
fn a_variable_that_is_empty_is_as_good_as_none() {
    let scratch = Scratch::new();
    let directory = scratch.path("");
    let output = faregate()
        .args(["status"])
        .env("FAREGATE_SOCKET", "")
        .env("XDG_RUNTIME_DIR", &directory)
        .output()
        .unwrap();
    let said = Said::from(output);
    assert_eq!(said.code, i32::from(Exit::NoPort.code()), "{said:?}");
    assert!(said.err.contains(directory.join("faregate.sock").to_str().unwrap()), "{said:?}");
}

#[test]
fn every_kind_of_device_is_documented_with_its_commands_and_parameters() {
    let documentation = fs::read_to_string(root().join("docs/cli.md")).unwrap();
    let odd = BTreeMap::from([("no_such_parameter".to_owned(), "1".to_owned())]);
    for kind in KINDS {
        let row = format!("| `{kind}` | ");
        let row = documentation.lines().find(|line| line.starts_with(&row)).expect(kind);
        for command in UnitSpec::new("it", kind, None, &BTreeMap::new()).unwrap().commands() {
            let argument =
                command.argument.map_or(String::new(), |argument| format!(" {argument}"));
            let words = format!("`{}{argument}`", command.name);
            assert!(row.contains(&words), "{words} in {row}");
        }
        let wrong = UnitSpec::new("it", kind, None, &odd).unwrap_err().join("");
        let known = wrong.rsplit("it has ").next().unwrap().split(", ");
        for parameter in known.filter(|name| !name.starts_with("sensor_")) {
            assert!(row.contains(&format!("`{parameter}`")), "{parameter} in {row}");
        }
    }
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let mut child = faregate()
        .args(["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Closed before anything is read.
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
}

#[test]
fn each_shell_gets_its_completions() {
    for shell in ["bash", "zsh", "fish"] {
        let said = call(&["completions", shell]);
        assert_eq!(said.code, 0);
        assert!(said.out.contains("analyze"), "{shell}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever is in a file, the program reads it, or says what is wrong. (A
    /// panic would end with 101.)
    #[test]
    fn no_file_makes_the_program_panic(
        bytes in proptest::collection::vec(any::<u8>(), 0..400),
        rows in proptest::collection::vec("[0-9+,. a-z\"'|#=\\[\\]]{0,40}", 0..8),
        which in 0_usize..3,
    ) {
        let scratch = Scratch::new();
        let name = ["it.csv", "it.txt", "it.toml"][which];
        let text = format!("id,st,et,dur,con,pri,type,interval,args\n{}\n", rows.join("\n"));
        for content in [&bytes[..], text.as_bytes()] {
            let path = scratch.file(name, content);
            let said = call(&["check".as_ref(), path.as_os_str()]);
            prop_assert!(matches!(said.code, 0 | 1), "{:?}", said);
        }
    }
}
