//! What goes over the wire: it comes back as it was, nothing that is sent
//! breaks who reads it, and the documented messages are those that are read.

use faregate_client::exit::Exit;
use faregate_client::wire::{command, control, line};
use faregate_client::{Error, RefusalKind, Refused};
use proptest::prelude::*;
use serde::de::DeserializeOwned;

/// The examples in the documentation, by what is written behind the fence.
fn examples(of: &str) -> Vec<String> {
    let page = include_str!("../../docs/ports.md");
    let blocks = page.split("```json ").skip(1).filter_map(|rest| {
        let (name, rest) = rest.split_once('\n')?;
        (name == of).then(|| rest.split("```").next().unwrap_or_default())
    });
    blocks.flat_map(str::lines).map(String::from).collect()
}

fn are_read<T: DeserializeOwned>(of: &str, at_least: usize) {
    let examples = examples(of);
    assert!(examples.len() >= at_least, "{} examples of {of}", examples.len());
    for example in examples {
        let read = serde_json::from_str::<T>(&example);
        assert!(read.is_ok(), "{example}: {:?}", read.err());
    }
}

#[test]
fn the_documented_messages_are_those_that_are_read() {
    for example in examples("command-asked") {
        command::parse(example.as_bytes()).unwrap();
    }
    for example in examples("control-asked") {
        control::parse(example.as_bytes()).unwrap();
    }
    are_read::<command::Said>("command-said", 5);
    are_read::<control::Said>("control-said", 5);
    assert!(examples("command-asked").len() >= 4 && examples("control-asked").len() >= 12);
}

#[test]
fn a_message_of_another_version_is_told_from_garbage() {
    let unreadable = command::parse(br#"{"id":3,"ask":{"fly":{}}}"#).unwrap_err();
    assert_eq!((unreadable.id, unreadable.why.kind), (Some(3), RefusalKind::UnknownRequest));
    assert!(unreadable.why.reason.starts_with("fly is not understood"));
    for garbage in [&b""[..], b"{}", b"[]", b"\"heartbeat\"", b"{\"ask\"", b"\xff", b"nul\0"] {
        let unreadable = command::parse(garbage).unwrap_err();
        assert_eq!((unreadable.id, unreadable.why.kind), (None, RefusalKind::Malformed));
    }
}

#[test]
fn what_a_newer_manager_refuses_is_still_a_refusal() {
    let newer = r#"{"kind":"phase_of_the_moon","reason":"it is full"}"#;
    let refused: Refused = serde_json::from_str(newer).unwrap();
    assert_eq!(refused, Refused::new(RefusalKind::Other, "it is full"));
    assert_eq!(Exit::from(refused.kind), Exit::Failed);
}

#[test]
fn every_exit_code_has_its_own_number_and_says_what_it_is() {
    let codes: Vec<_> = Exit::ALL.iter().map(|(exit, _)| exit.code()).collect();
    assert_eq!(codes, (0..=10).collect::<Vec<_>>());
    assert!(Exit::ALL.iter().all(|(_, says)| !says.is_empty()));
    let page = include_str!("../../docs/ports.md");
    for (exit, says) in Exit::ALL {
        let row = format!("| {} | {says} |", exit.code());
        assert!(page.contains(&row), "docs/ports.md has no row {row}");
    }
}

#[test]
fn a_script_knows_from_the_code_whether_to_try_again() {
    let exit = |kind| Exit::from(&Error::Refused(Refused::new(kind, "")));
    assert_eq!(exit(RefusalKind::Preempted), Exit::NotNow);
    assert_eq!(exit(RefusalKind::UnknownGate), Exit::Never);
    assert_eq!(exit(RefusalKind::Limit), Exit::Limit);
    assert_eq!(exit(RefusalKind::Faulted), Exit::Faulted);
    assert_eq!(Exit::from(&Error::Closed), Exit::Over);
    assert_eq!(Exit::from(&Error::NoPort(String::new())), Exit::NoPort);
}

proptest! {
    #[test]
    fn whatever_comes_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        // That they return is the claim.
        let _ = command::parse(&bytes);
        let _ = control::parse(&bytes);
    }

    #[test]
    fn a_broken_message_is_never_another_one(at in any::<prop::sample::Index>(), byte in any::<u8>()) {
        let whole = br#"{"id":7,"ask":{"command":{"gate":"a","command":"b","arguments":[]}}}"#;
        let mut broken = whole.to_vec();
        let at = at.index(broken.len());
        broken[at] = byte;
        if let Ok(asked) = command::parse(&broken) {
            // Only names and the number can differ.
            let is_command = matches!(asked.ask, command::Ask::Command { .. });
            prop_assert!(is_command);
        }
    }

    #[test]
    fn a_command_comes_over_as_it_was_meant(
        id in any::<Option<u64>>(), gate in ".*", name in ".*",
        arguments in prop::collection::vec(".*", 0..4),
    ) {
        let ask = command::Ask::Command { gate, command: name, arguments };
        let asked = faregate_client::wire::Asked { id, ask };
        let bytes = line(&asked).unwrap();
        // One line: nothing in it ends it before its end.
        prop_assert_eq!(bytes.iter().position(|&byte| byte == b'\n'), Some(bytes.len() - 1));
        prop_assert_eq!(command::parse(&bytes).unwrap(), asked);
    }
}
