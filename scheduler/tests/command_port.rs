//! The command port, from both sides: what is asked comes to the devices or is
//! refused, and nobody's slowness or nonsense is anybody else's.
#![cfg(target_os = "linux")]

mod command_port {
    mod processes;
    pub(crate) mod stage;
    mod sys;
}

use std::io::IoSlice;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};

use command_port::stage::{LONG, Stage, until};
use faregate_client::wire::command::{MAX_MESSAGE, Notice};
use faregate_client::{CommandPort, Error, RefusalKind, Refused};
use faregate_scheduler::executive::{PortFactory, PortNotice};
use faregate_scheduler::manager::Event;
use faregate_scheduler::port::{MAX_CONNECTIONS, MAX_QUEUED};
use rustix::net::{RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags, recv, send};

fn refusal<T: std::fmt::Debug>(outcome: Result<T, Error>) -> Refused {
    match outcome {
        Err(Error::Refused(why)) => why,
        other => panic!("not refused: {other:?}"),
    }
}

/// Says something as it is, without the client.
fn say(socket: &OwnedFd, bytes: &[u8]) {
    send(socket, bytes, SendFlags::NOSIGNAL).unwrap();
}

/// The next message as it is; empty: the connection is over.
fn hear(socket: &OwnedFd) -> String {
    let mut bytes = vec![0; MAX_MESSAGE];
    let timeout = rustix::net::sockopt::Timeout::Recv;
    rustix::net::sockopt::set_socket_timeout(socket, timeout, Some(LONG)).unwrap();
    let (_, length) = recv(socket, &mut bytes[..], RecvFlags::empty()).unwrap();
    String::from_utf8(bytes[..length].into()).unwrap()
}

fn is_over(socket: &OwnedFd) -> bool {
    loop {
        if hear(socket).is_empty() {
            return true;
        }
    }
}

#[test]
fn a_command_is_issued_and_the_answer_comes_back() {
    let mut stage = Stage::new();
    let (_, mut port) = stage.connected();
    let reply = port.command("camera", "point", &["3", "4 5"]).unwrap();
    assert_eq!(reply.text, "3+4 5");
    assert_eq!(stage.devices.seen(), ["camera point"]);
    assert_eq!(stage.server.counts().done, 1);
}

#[test]
fn a_refusal_says_why_to_people_and_to_programs() {
    let mut stage = Stage::new();
    let (_, mut port) = stage.connected();
    let why = refusal(port.command("nowhere", "on", &[]));
    assert_eq!((why.kind, &*why.reason), (RefusalKind::UnknownGate, "no gate nowhere"));
    assert_eq!(why.taker, None, "nobody took anything");
    assert_eq!(stage.server.counts().refused, 1);
}

#[test]
fn while_its_tickets_are_taken_a_task_is_refused_and_hears_by_whom() {
    let mut stage = Stage::new();
    let (_, mut port) = stage.connected();
    port.command("camera", "on", &[]).unwrap();
    stage.devices.taken_by(Some("task 32"));
    let why = refusal(port.command("camera", "on", &[]));
    assert_eq!((why.kind, &*why.reason), (RefusalKind::Preempted, "pre-empted by task 32"));
    assert_eq!(why.taker.as_deref(), Some("task 32"), "a program need not read the reason");
    stage.devices.taken_by(None);
    port.command("camera", "off", &[]).unwrap();
    assert_eq!(stage.devices.seen(), ["camera on", "camera off"]);
}

#[test]
fn heartbeats_come_as_one_event_however_many_they_were() {
    let mut stage = Stage::new();
    let (attempt, mut port) = stage.connected();
    assert!(stage.events().is_empty() && !stage.waker.take());
    for _ in 0..100 {
        port.heartbeat().unwrap();
    }
    // Behind the heartbeats on the same connection.
    port.command("camera", "on", &[]).unwrap();
    assert!(stage.waker.take());
    assert_eq!(stage.events(), [Event::Heartbeat { attempt }]);
    assert!(stage.events().is_empty());
    assert_eq!(stage.server.counts().heartbeats, 100);
}

#[test]
fn a_slow_device_keeps_neither_heartbeats_nor_other_attempts_nor_the_manager_waiting() {
    let mut stage = Stage::new();
    let lets_go = stage.devices.slow_until();
    let (slow, mut port) = stage.connected();
    let (_, mut other) = stage.connected();
    let mut beside = port.another().unwrap();
    let waits = std::thread::spawn(move || port.command("slow", "turn", &[]));
    until(|| stage.devices.seen() == ["slow turn"]);

    other.command("camera", "on", &[]).unwrap();
    beside.heartbeat().unwrap();
    stage.woken();
    assert_eq!(stage.events(), [Event::Heartbeat { attempt: slow }]);

    stage.server.close(slow);
    assert!(!stage.server.is_quiet(slow), "its command is in progress");
    lets_go.send(()).unwrap();
    stage.woken();
    assert!(stage.server.is_quiet(slow));
    // The answer may come before the end of the connection.
    assert!(matches!(waits.join().unwrap(), Ok(_) | Err(Error::Closed)));
}

#[test]
fn what_waits_behind_a_command_in_progress_is_not_issued_after_the_end() {
    let mut stage = Stage::new();
    let lets_go = stage.devices.slow_until();
    let (attempt, inherited) = stage.open();
    say(&inherited, br#"{"ask":{"command":{"gate":"slow","command":"turn"}}}"#);
    for _ in 0..10 {
        say(&inherited, br#"{"ask":{"command":{"gate":"camera","command":"on"}}}"#);
    }
    say(&inherited, br#"{"ask":"heartbeat"}"#);
    until(|| stage.devices.seen() == ["slow turn"]);
    stage.woken();
    stage.server.close(attempt);
    drop(lets_go);
    until(|| stage.server.is_quiet(attempt));
    until(|| stage.server.counts().refused == 10);
    assert_eq!(stage.devices.seen(), ["slow turn"]);
}

#[test]
fn the_commands_of_an_attempt_are_issued_in_their_order() {
    let mut stage = Stage::new();
    let (_, inherited) = stage.open();
    for n in 0..50 {
        let ask =
            format!(r#"{{"id":{n},"ask":{{"command":{{"gate":"camera","command":"{n}"}}}}}}"#);
        say(&inherited, ask.as_bytes());
    }
    for n in 0..50 {
        assert!(hear(&inherited).contains(&format!("\"id\":{n},")));
    }
    let order: Vec<_> = (0..50).map(|n| format!("camera {n}")).collect();
    assert_eq!(stage.devices.seen(), order);
}

#[test]
fn processes_that_share_the_inherited_socket_do_not_read_each_others_answers() {
    let mut stage = Stage::new();
    let (_, inherited) = stage.open();
    let workers: Vec<_> = (0..8)
        .map(|n| (n, inherited.try_clone().unwrap()))
        .map(|(n, shared)| {
            std::thread::spawn(move || {
                for round in 0..50 {
                    // As a program does that a script calls: connects, asks, ends.
                    let mut port = CommandPort::over(shared.try_clone().unwrap()).unwrap();
                    let mine = format!("{n}.{round}");
                    assert_eq!(port.command("camera", "on", &[&mine]).unwrap().text, mine);
                }
            })
        })
        .collect();
    workers.into_iter().for_each(|worker| worker.join().unwrap());
    assert_eq!(stage.devices.seen().len(), 400);
}

#[test]
fn who_asked_hears_of_a_pause_and_of_the_devices_that_were_made_safe() {
    let mut stage = Stage::new();
    let (attempt, mut port) = stage.connected();
    port.command("camera", "on", &[]).unwrap();
    refusal(port.command("nowhere", "on", &[]));
    let mut notices = port.notices().unwrap();
    stage.server.tell(attempt, PortNotice::Resumed);
    assert_eq!(notices.wait().unwrap(), Notice::Resumed { safed: vec!["camera".into()] });
    let grace = faregate_scheduler::time::Duration::from_secs(3);
    stage.server.tell(attempt, PortNotice::Checkpoint { grace });
    assert_eq!(notices.wait().unwrap(), Notice::Checkpoint { grace_us: 3_000_000 });
    // Nobody else is disturbed by them.
    port.command("camera", "off", &[]).unwrap();
    stage.server.close(attempt);
    assert!(matches!(notices.wait(), Err(Error::Closed)));
}

#[test]
fn a_panic_on_the_way_is_the_commands_own() {
    let mut stage = Stage::new();
    let (attempt, mut port) = stage.connected();
    assert_eq!(refusal(port.command("panics", "on", &[])).kind, RefusalKind::Faulted);
    port.command("camera", "on", &[]).unwrap();
    stage.server.close(attempt);
    assert!(stage.server.is_quiet(attempt));
}

#[test]
fn an_answer_that_is_too_long_is_cut() {
    let mut stage = Stage::new();
    let (_, mut port) = stage.connected();
    let reply = port.command("talks", &MAX_MESSAGE.to_string(), &[]).unwrap();
    assert!(reply.text.ends_with('…') && reply.text.len() > MAX_MESSAGE / 10);
    assert_eq!(port.command("talks", "2", &[]).unwrap().text, "x\"x\"");
}

#[test]
fn garbage_ends_its_own_connection_with_a_reason_and_is_counted() {
    let mut stage = Stage::new();
    let (_, mut other) = stage.connected();
    let (_, inherited) = stage.open();
    let mut its_own = CommandPort::over(inherited.try_clone().unwrap()).unwrap();
    say(&inherited, b"\xff\0camera on");
    assert!(hear(&inherited).contains("malformed"));
    assert!(is_over(&inherited));
    assert_eq!(stage.server.counts().closed_over_garbage, 1);
    its_own.command("camera", "on", &[]).unwrap();
    other.command("camera", "on", &[]).unwrap();
}

#[test]
fn a_message_that_is_too_long_ends_its_connection() {
    let mut stage = Stage::new();
    let (_, inherited) = stage.open();
    say(&inherited, &vec![b' '; MAX_MESSAGE + 1]);
    assert!(is_over(&inherited));
    assert_eq!(stage.server.counts().closed_over_garbage, 1);
    let (_, mut port) = stage.connected();
    let long = "x".repeat(MAX_MESSAGE);
    assert!(matches!(port.command("camera", &long, &[]), Err(Error::TooLong { .. })));
    port.command("camera", "on", &[]).unwrap();
}

#[test]
fn what_a_newer_client_asks_is_refused_and_the_connection_stays() {
    let mut stage = Stage::new();
    let (_, inherited) = stage.open();
    say(&inherited, br#"{"id":3,"ask":{"calibrate":{}}}"#);
    let answer = hear(&inherited);
    assert!(answer.contains("\"id\":3,") && answer.contains("unknown_request"), "{answer}");
    // A field that is not known would change what is meant.
    say(&inherited, br#"{"id":4,"ask":{"command":{"gate":"camera","command":"on","dry":true}}}"#);
    assert!(hear(&inherited).contains("unknown_request"));
    assert!(stage.devices.seen().is_empty());
    say(&inherited, br#"{"id":5,"ask":{"command":{"gate":"camera","command":"on"}}}"#);
    assert!(hear(&inherited).contains("done"));
}

#[test]
fn who_does_not_read_its_answers_loses_its_connection_and_nobody_waits() {
    let mut stage = Stage::new();
    let (_, inherited) = stage.open();
    let (_, mut other) = stage.connected();
    let ask = br#"{"ask":{"command":{"gate":"talks","command":"4000"}}}"#;
    until(|| {
        let _ = send(&inherited, ask, SendFlags::NOSIGNAL | SendFlags::DONTWAIT);
        stage.server.counts().closed_unread == 1
    });
    other.command("camera", "on", &[]).unwrap();
    assert!(is_over(&inherited));
}

#[test]
fn connections_and_commands_in_waiting_have_a_limit() {
    let mut stage = Stage::new();
    let (_, inherited) = stage.open();
    let open = || CommandPort::over(inherited.try_clone().unwrap());
    let mut ports: Vec<_> = (1..MAX_CONNECTIONS).map(|_| open().unwrap()).collect();
    assert_eq!(refusal(open()).kind, RefusalKind::Busy);
    ports.pop();
    // The server has heard of it when it has served everybody else since.
    until(|| open().is_ok());

    let lets_go = stage.devices.slow_until();
    let (_, inherited) = stage.open();
    say(&inherited, br#"{"ask":{"command":{"gate":"slow","command":"turn"}}}"#);
    until(|| stage.devices.seen().len() == 1);
    for _ in 0..=MAX_QUEUED {
        say(&inherited, br#"{"ask":{"command":{"gate":"camera","command":"on"}}}"#);
    }
    assert!(hear(&inherited).contains("busy"));
    drop(lets_go);
    until(|| stage.devices.seen().len() == 1 + MAX_QUEUED);
}

#[test]
fn descriptors_that_a_process_sends_are_not_kept() {
    let mut stage = Stage::new();
    let (_, inherited) = stage.open();
    let (ours, theirs) = std::io::pipe().unwrap();
    for _ in 0..10 {
        let ends = [theirs.as_fd()];
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut passed = SendAncillaryBuffer::new(&mut space);
        assert!(passed.push(SendAncillaryMessage::ScmRights(&ends)));
        let message = [IoSlice::new(br#"{"ask":"heartbeat"}"#)];
        rustix::net::sendmsg(&inherited, &message, &mut passed, SendFlags::empty()).unwrap();
    }
    drop(theirs);
    // The pipe ends when nobody has its other side any more.
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut { ours }, &mut rest).unwrap();
    until(|| stage.server.counts().heartbeats == 10);
}

#[test]
fn the_end_of_the_server_is_the_end_of_every_port() {
    let mut stage = Stage::new();
    let (_, mut port) = stage.connected();
    port.command("camera", "on", &[]).unwrap();
    let Stage { server, .. } = stage;
    drop(server);
    assert!(matches!(port.command("camera", "on", &[]), Err(Error::Closed)));
}
