//! Real processes that try to keep what their attempt gave them.

use std::io::{IoSlice, IoSliceMut, Read};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::process::{Child, Command, Stdio};

use faregate_client::wire::command::PORT;
use faregate_client::{CommandPort, Error};
use faregate_scheduler::executive::PortFactory;
use rustix::io::{FdFlags, fcntl_setfd};
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, sendmsg,
};

use crate::command_port::stage::{Stage, until};

/// Which of the parts below this process plays.
const PART: &str = "FAREGATE_TEST_PART";
/// The socket to or from the process that is given a port.
const CHANNEL: &str = "FAREGATE_TEST_CHANNEL";

/// This test program once more, in a part.
fn play(part: &str) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "command_port::processes::a_part_of_the_tests_below", "--nocapture"]);
    command.env(PART, part).stdin(Stdio::null()).stdout(Stdio::piped());
    command
}

/// Starts it with this descriptor, whose number it finds in this variable.
fn start_with(mut command: Command, variable: &str, inherited: &OwnedFd) -> Child {
    fcntl_setfd(inherited, FdFlags::empty()).unwrap();
    let child = command.env(variable, inherited.as_raw_fd().to_string()).spawn().unwrap();
    fcntl_setfd(inherited, FdFlags::CLOEXEC).unwrap();
    child
}

#[test]
fn a_part_of_the_tests_below() {
    match std::env::var(PART).as_deref() {
        Ok("commands once") => once(),
        Ok("asks for its port") => println!("<{}>", CommandPort::from_env().unwrap_err()),
        Ok("leaves") => leave("leaves its session"),
        Ok("leaves its session") => {
            rustix::process::setsid().unwrap();
            leave("hammers");
        }
        Ok("hammers") => hammer(CommandPort::from_env().unwrap()),
        Ok("gives its port away") => give_away(),
        Ok("takes a port") => hammer(CommandPort::over(take()).unwrap()),
        _ => {}
    }
}

fn once() {
    let reply = CommandPort::from_env().unwrap().command("camera", "on", &["3"]);
    println!("<{}>", reply.unwrap().text);
}

/// Starts the next part and ends before it.
#[expect(clippy::zombie_processes, reason = "outliving the parent is what is tried")]
fn leave(next: &str) {
    play(next).stdout(Stdio::inherit()).spawn().unwrap();
}

/// Commands as long as it can, and tells how that ended.
fn hammer(mut port: CommandPort) {
    let end = loop {
        match port.command("camera", "on", &[]) {
            // Refused at the very end: the attempt is over.
            Ok(_) | Err(Error::Refused(_)) => {}
            Err(end) => break end,
        }
    };
    let closed = matches!(end, Error::Closed);
    // A way in that is tried anew finds the same.
    let again = CommandPort::from_env().err();
    println!("<closed: {closed}, again: {again:?}>");
}

/// What this process inherited, by the variable with its number.
fn given(variable: &str) -> OwnedFd {
    crate::command_port::sys::inherited(&std::env::var(variable).unwrap())
}

fn give_away() {
    let port = given(PORT);
    let ends: [BorrowedFd<'_>; 1] = [port.as_fd()];
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut passed = SendAncillaryBuffer::new(&mut space);
    assert!(passed.push(SendAncillaryMessage::ScmRights(&ends)));
    sendmsg(given(CHANNEL), &[IoSlice::new(b"!")], &mut passed, SendFlags::empty()).unwrap();
}

fn take() -> OwnedFd {
    let mut byte = [0];
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut passed = RecvAncillaryBuffer::new(&mut space);
    let into = &mut [IoSliceMut::new(&mut byte)];
    recvmsg(given(CHANNEL), into, &mut passed, RecvFlags::empty()).unwrap();
    let taken = passed.drain().find_map(|message| match message {
        RecvAncillaryMessage::ScmRights(mut descriptors) => descriptors.next(),
        _ => None,
    });
    taken.unwrap()
}

/// What a process and all it started have printed, when all have ended.
fn printed(child: &mut Child) -> String {
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert!(child.wait().unwrap().success(), "{text}");
    text
}

#[test]
fn a_process_finds_its_port_by_the_environment() {
    let mut stage = Stage::new();
    let (_, inherited) = stage.open();
    let mut child = start_with(play("commands once"), PORT, &inherited);
    let text = printed(&mut child);
    assert!(text.contains("<3>"), "{text}");
    assert_eq!(stage.devices.seen(), ["camera on"]);
}

#[test]
fn leaving_the_session_and_outliving_the_parent_gains_nothing_after_the_end() {
    let mut stage = Stage::new();
    let (first, inherited) = stage.open();
    let mut child = start_with(play("leaves"), PORT, &inherited);
    drop(inherited);
    assert!(child.wait().unwrap().success());
    until(|| stage.devices.seen_by(first) > 10);

    stage.server.close(first);
    until(|| stage.server.is_quiet(first));
    let by_the_end = stage.devices.seen_by(first);
    // The next attempt of the occurrence has the same tickets.
    let (second, _its_port) = stage.open();
    let text = printed(&mut child);
    assert!(text.contains("<closed: true, again: Some(Closed)>"), "{text}");
    assert_eq!(stage.devices.seen_by(first), by_the_end);
    assert_eq!(stage.devices.seen_by(second), 0);
}

#[test]
fn passing_the_socket_to_another_process_gains_nothing_after_the_end() {
    let mut stage = Stage::new();
    let (ours, its) = UnixStream::pair().unwrap();
    let mut taker = start_with(play("takes a port"), CHANNEL, &its.into());
    let (attempt, inherited) = stage.open();
    let mut giver = play("gives its port away");
    fcntl_setfd(&ours, FdFlags::empty()).unwrap();
    giver.env(CHANNEL, ours.as_raw_fd().to_string());
    let mut giver = start_with(giver, PORT, &inherited);
    drop((ours, inherited));
    printed(&mut giver);
    // While the attempt lasts, the socket is the authority, whoever has it.
    until(|| stage.devices.seen_by(attempt) > 10);

    stage.server.close(attempt);
    until(|| stage.server.is_quiet(attempt));
    let by_the_end = stage.devices.seen_by(attempt);
    let text = printed(&mut taker);
    assert!(text.contains("<closed: true"), "{text}");
    assert_eq!(stage.devices.seen_by(attempt), by_the_end);
}

#[test]
fn without_a_manager_there_is_no_way_in() {
    let mut stage = Stage::new();
    let (attempt, _inherited) = stage.open();
    let (_, stranger) = std::io::pipe().unwrap();
    let mut child = start_with(play("asks for its port"), PORT, &stranger.into());
    assert!(printed(&mut child).contains("<FAREGATE_PORT is"));
    let mut child = play("asks for its port").env_remove(PORT).spawn().unwrap();
    assert!(printed(&mut child).contains("<FAREGATE_PORT is not set"));
    assert_eq!(stage.devices.seen_by(attempt), 0);
}
