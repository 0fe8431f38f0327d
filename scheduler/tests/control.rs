//! The control port, from both sides: what is asked comes to the manager, every
//! ask has its answer, and nothing that comes over the socket disturbs anybody.
#![cfg(target_os = "linux")]

mod control {
    mod socket;
    pub(crate) mod stage;
}

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, mpsc};

use control::stage::{LONG, Stage, THERE, id, now, until};
use faregate_client::wire::control::{MAX_LINE, State, StatusQuery, When, Window};
use faregate_client::{Change, Control, Error, RefusalKind, Refused};
use faregate_scheduler::control::{Link, MAX_CLIENTS, MAX_NOTES, SocketLink};
use faregate_scheduler::executive::Waker;
use faregate_scheduler::manager::{Note, Telecommand};
use faregate_scheduler::task::TaskPriority;
use faregate_scheduler::time::{Duration, UnixTime};
use proptest::prelude::*;

fn refusal<T: std::fmt::Debug>(outcome: Result<T, Error>) -> Refused {
    match outcome {
        Err(Error::Refused(why)) => why,
        other => panic!("not refused: {other:?}"),
    }
}

/// A client that says what it likes, after the hello.
fn raw(stage: &Stage) -> BufReader<UnixStream> {
    let stream = UnixStream::connect(&stage.path).unwrap();
    stream.set_read_timeout(Some(LONG)).unwrap();
    let mut stream = BufReader::new(stream);
    assert!(hear(&mut stream).contains("hello"));
    stream
}

fn hear(stream: &mut BufReader<UnixStream>) -> String {
    let mut line = String::new();
    stream.read_line(&mut line).unwrap();
    line
}

#[test]
fn every_telecommand_comes_to_the_manager_as_it_was_asked() {
    use faregate_scheduler::task::{When as Said, Window as SaidWindow};
    let stage = Stage::new();
    let mut control = stage.client();
    assert!(control.program().starts_with("faregate "));
    control.add("upload.list", "31 32").unwrap();
    control.set_priority(31, 200).unwrap();
    let windows = [
        Window { opens: When::AfterUs(5), closes: When::AfterUs(9) },
        Window { opens: When::UnixUs(-1), closes: When::Unrestricted },
    ];
    control.set_windows(31, &windows).unwrap();
    control.hold(31).unwrap();
    control.resume(31).unwrap();
    control.remove(&[32]).unwrap();
    control.enter_mode("recovery").unwrap();
    control.leave_mode("recovery").unwrap();
    control.clear(false).unwrap();
    control.clear(true).unwrap();
    control.shut_down().unwrap();

    let mut heard = stage.heard();
    let Telecommand::Add(added) = heard.remove(0) else { panic!("{heard:?}") };
    assert_eq!(added.iter().map(|added| added.task.id).collect::<Vec<_>>(), [id(31), id(32)]);
    let after = |us| Said::AfterLoad(Duration::from_micros(us));
    let expected = [
        Telecommand::SetPriority(id(31), TaskPriority::new(200).unwrap()),
        Telecommand::SetWindows(
            id(31),
            vec![
                SaidWindow { opens: after(5), closes: after(9) },
                SaidWindow {
                    opens: Said::At(UnixTime::from_micros(-1)),
                    closes: Said::Unrestricted,
                },
            ],
        ),
        Telecommand::Hold(id(31)),
        Telecommand::Resume(id(31)),
        Telecommand::Remove(vec![id(32)]),
        Telecommand::EnterMode("recovery".into()),
        Telecommand::LeaveMode("recovery".into()),
        Telecommand::Clear { all: false },
        Telecommand::Clear { all: true },
        Telecommand::ShutDown,
    ];
    assert_eq!(heard, expected);
}

#[test]
fn what_the_manager_refuses_is_told_with_its_reason() {
    let stage = Stage::new();
    let mut control = stage.client();
    let why = refusal(control.remove(&[7]));
    assert_eq!((why.kind, &*why.reason), (RefusalKind::NotDone, "task 7 cannot be spared"));
}

#[test]
fn what_is_not_there_is_refused_as_unknown_whatever_is_asked_of_it() {
    let stage = Stage::new();
    let mut control = stage.client();
    let windows = [Window::default()];
    let about_20 = [
        control.remove(&[1, 20]),
        control.set_priority(20, 1),
        control.set_windows(20, &windows),
        control.hold(20),
        control.resume(20),
    ];
    for outcome in about_20 {
        let why = refusal(outcome);
        assert_eq!(why.kind, RefusalKind::UnknownTask);
        assert_eq!(why.reason, "task 20 is not in the schedule");
    }
    for outcome in [control.enter_mode("spring"), control.leave_mode("spring")] {
        let why = refusal(outcome);
        assert_eq!(why.kind, RefusalKind::Invalid);
        assert!(why.reason.contains("no mode spring"), "{why}");
    }
    assert!(stage.heard().is_empty(), "the manager was asked");
    control.hold(1).unwrap();
}

#[test]
fn what_cannot_be_meant_never_comes_to_the_manager() {
    let stage = Stage::new();
    let mut control = stage.client();
    let never = [Window { opens: When::AfterUs(9), closes: When::AfterUs(5) }];
    let refused = [
        control.set_priority(1, 240),
        control.set_priority(0, 1),
        control.hold(0),
        control.remove(&[]),
        control.remove(&[3, 0]),
        control.set_windows(1, &[]),
        control.set_windows(1, &never),
        control.add("empty.list", ""),
    ];
    for outcome in refused {
        assert_eq!(refusal(outcome).kind, RefusalKind::Invalid);
    }
    assert!(stage.heard().is_empty());
    control.set_priority(1, 239).unwrap();
    assert_eq!(stage.heard().len(), 1);
}

#[test]
fn every_mistake_in_a_schedule_is_told_at_once_and_nothing_is_loaded() {
    let stage = Stage::new();
    let why = refusal(stage.client().add("upload.list", "1 two 3 four 0"));
    assert_eq!(why.kind, RefusalKind::Invalid);
    assert_eq!(why.problems.iter().map(|p| p.line.unwrap()).collect::<Vec<_>>(), [2, 4, 5]);
    assert_eq!(why.to_string().lines().count(), 4);
    assert_eq!(stage.schedule.lock().unwrap().tasks.len(), THERE);
}

#[test]
fn the_status_of_a_long_schedule_comes_whole_in_several_answers() {
    let stage = Stage::new();
    let many = stage.fill();
    let mut control = stage.client();
    let status = control.status().unwrap();
    let numbers: Vec<_> = status.tasks.iter().map(|row| row.task).collect();
    assert_eq!(numbers, (1..=many).collect::<Vec<_>>());
    assert_eq!((status.at_us, status.unix_us, status.more), (7, -9, false));

    let query = StatusQuery { tasks: vec![5, 8, 9], skip: 1, limit: Some(1) };
    let status = control.status_of(query).unwrap();
    assert!(status.more);
    let [row] = &*status.tasks else { panic!("{status:?}") };
    assert_eq!((row.task, row.occurrence, row.state), (8, 2, State::Waiting));
    assert_eq!(row.waits_for.as_deref(), Some("camera, which task 99 has"));
    let looked_at = *stage.schedule.lock().unwrap().looked_at.lock().unwrap();
    assert_eq!(looked_at, many + 1, "the manager works for those that are told alone");
}

/// The manager's thread answers, and looks for each task among those that are
/// asked of.
#[test]
fn a_question_about_very_many_tasks_is_refused_and_the_client_asks_in_parts() {
    let stage = Stage::new();
    let many = stage.fill();
    let mut control = stage.client();
    let mut numbers: Vec<u32> = (1..=many).rev().collect();
    let query = StatusQuery { tasks: numbers.clone(), ..StatusQuery::default() };
    let why = refusal(control.status_of(query));
    assert_eq!(why.kind, RefusalKind::Invalid);
    assert!(why.reason.contains(&many.to_string()), "{why}");
    numbers.push(many + 1);
    let status = control.status_of_tasks(&numbers).unwrap();
    let mut told: Vec<_> = status.tasks.iter().map(|row| row.task).collect();
    told.sort_unstable();
    assert_eq!(told, (1..=many).collect::<Vec<_>>());
    assert_eq!((status.at_us, status.unix_us), (7, -9));
}

#[test]
fn a_schedule_whose_reader_panics_is_refused_and_the_port_lives() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("faregate.sock");
    let reader = |name: &str, _: &str| -> Result<Vec<faregate_scheduler::Task>, Refused> {
        assert!(name != "bad.list", "as it is to");
        Err(Refused::new(RefusalKind::Invalid, "it is not loaded"))
    };
    let _link = SocketLink::listen(&path, Arc::new(reader), Waker::new().unwrap()).unwrap();
    let mut control = Control::connect(&path).unwrap();
    control.set_timeout(Some(LONG)).unwrap();
    let why = refusal(control.add("bad.list", "1"));
    assert_eq!(why.kind, RefusalKind::NotDone);
    assert!(why.reason.contains("panicked"), "{why}");
    assert_eq!(refusal(control.add("good.list", "1")).kind, RefusalKind::Invalid);
}

#[test]
fn a_file_that_is_no_schedule_at_all_has_an_answer_that_can_be_taken() {
    let stage = Stage::new();
    let garbage = "no ".repeat(200_000);
    let why = refusal(stage.client().add("garbage.list", &garbage));
    let (last, told) = why.problems.split_last().unwrap();
    let untold: usize = last.message.split(' ').next().unwrap().parse().unwrap();
    assert_eq!(told.len() + untold, 200_000, "{}", last.message);
    assert!(told.len() > 1000 && told[0].line == Some(1));
}

#[test]
fn clients_are_served_side_by_side_and_each_hears_its_own_answers() {
    let stage = Stage::new();
    let clients: Vec<_> = (1..=8)
        .map(|number| (number, stage.client()))
        .map(|(number, mut control)| {
            std::thread::spawn(move || {
                for round in 0..50 {
                    control.add("a.list", &format!("{}", number * 100 + round)).unwrap();
                    let missing = refusal(control.remove(&[number * 100 + 99]));
                    let about = format!("task {} ", number * 100 + 99);
                    assert!(missing.reason.starts_with(&about), "{missing}");
                }
            })
        })
        .collect();
    clients.into_iter().for_each(|client| client.join().unwrap());
    assert_eq!(stage.schedule.lock().unwrap().tasks.len(), 400 + THERE);
}

#[test]
fn more_clients_than_there_is_room_for_are_refused_until_one_goes() {
    let stage = Stage::new();
    let mut clients: Vec<_> = (0..MAX_CLIENTS).map(|_| stage.client()).collect();
    assert_eq!(refusal(Control::connect(&stage.path)).kind, RefusalKind::Busy);
    clients.pop();
    until(|| Control::connect(&stage.path).is_ok());
    clients[0].hold(1).unwrap();
}

#[test]
fn who_watches_hears_every_change_and_others_do_not() {
    let stage = Stage::new();
    let mut watch = stage.client().watch().unwrap();
    let mut other = raw(&stage);
    for number in 1..=100 {
        stage.note(Note::Accepted(id(number)));
    }
    for number in 1..=100 {
        let Change::Note { at_us, unix_us, note } = watch.wait().unwrap() else { panic!("lost") };
        assert_eq!((at_us, unix_us), (7, -9));
        let note: Note = serde_json::from_value(note).unwrap();
        assert_eq!(note, Note::Accepted(id(number)));
    }
    other.get_mut().write_all(b"{\"id\":1,\"ask\":{\"hold\":{\"task\":1}}}\n").unwrap();
    assert!(hear(&mut other).contains("\"id\":1,"));
}

#[test]
fn who_watches_and_does_not_read_is_told_what_it_missed_and_keeps_nobody_waiting() {
    let stage = Stage::new();
    let mut watch = stage.client().watch().unwrap();
    let mut other = stage.client();
    let (batch, batches) = (MAX_NOTES / 2, 8);
    let why = "x".repeat(500);
    for _ in 0..batches {
        for _ in 0..batch {
            stage.note(Note::NeverRuns { task: id(1), why: why.clone() });
        }
        // The others are served meanwhile. When they have been, no change waits
        // for the port's thread any more: it is the reader who is too slow.
        other.hold(1).unwrap();
        other.hold(1).unwrap();
    }
    stage.note(Note::Accepted(id(2)));
    let told = u64::try_from(batch * batches + 1).unwrap();
    let (mut heard, mut lost) = (0, 0);
    while heard + lost < told {
        match watch.wait().unwrap() {
            Change::Note { .. } => heard += 1,
            Change::Lost(count) => lost += count,
        }
    }
    assert!(lost > told / 2 && heard > 0, "{heard} heard, {lost} lost");
}

#[test]
fn the_manager_does_not_wait_for_a_port_whose_thread_is_busy() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("faregate.sock");
    let (reads, has_begun) = mpsc::channel();
    let (lets_go, until) = mpsc::channel::<()>();
    let both = Mutex::new((reads, until));
    let reader = move |_: &str, _: &str| {
        let (reads, until) = &*both.lock().unwrap();
        reads.send(()).unwrap();
        let _ = until.recv();
        Ok(Vec::new())
    };
    let waker = Waker::new().unwrap();
    let mut link = SocketLink::listen(&path, Arc::new(reader), waker).unwrap();
    let mut watch = Control::connect(&path).unwrap().watch().unwrap();
    let mut other = Control::connect(&path).unwrap();
    let reading = std::thread::spawn(move || other.add("long.list", "").unwrap_err());
    has_begun.recv().unwrap();

    let beyond = 10;
    for _ in 0..MAX_NOTES + beyond {
        link.note(now(), &Note::Accepted(id(1)));
    }
    lets_go.send(()).unwrap();
    let (mut heard, mut lost) = (0, 0);
    while heard + lost < u64::try_from(MAX_NOTES + beyond).unwrap() {
        match watch.wait().unwrap() {
            Change::Note { .. } => heard += 1,
            Change::Lost(count) => lost += count,
        }
    }
    assert!(heard > 0 && lost >= u64::try_from(beyond).unwrap(), "{heard} heard, {lost} lost");
    assert!(matches!(reading.join().unwrap(), Error::Refused(_)));
}

#[test]
fn a_malformed_line_is_answered_and_the_next_one_is_read() {
    let stage = Stage::new();
    let mut stream = raw(&stage);
    let lines: [&[u8]; 8] = [
        b"hello\n",
        b"\xff\xfe\0\n",
        b"{}\n",
        b"[1,2]\n",
        b"{\"ask\":{\"hold\":{\"task\":-1}}}\n",
        b"{\"id\":5,\"ask\":{\"fly\":{}}}\n",
        b"{\"id\":6,\"ask\":{\"clear\":{\"all\":true,\"gently\":true}}}\n",
        &[&[b'['; 5000][..], b"\n"].concat(),
    ];
    for line in lines {
        stream.get_mut().write_all(line).unwrap();
        let answer = hear(&mut stream);
        assert!(answer.contains("malformed") || answer.contains("unknown_request"), "{answer}");
    }
    stream.get_mut().write_all(b"\r\n \n{\"id\":7,\"ask\":{\"hold\":{\"task\":1}}}\r\n").unwrap();
    assert_eq!(hear(&mut stream), "{\"answer\":{\"id\":7,\"what\":\"done\"}}\n");
    assert_eq!(stage.heard(), [Telecommand::Hold(id(1))]);
    until(|| stage.counts().malformed == 8);
}

#[test]
fn ten_megabytes_of_garbage_are_one_mistake() {
    let stage = Stage::new();
    let mut other = stage.client();
    let mut stream = raw(&stage);
    let garbage = vec![b'x'; 64 * 1024];
    for piece in 0..160 {
        stream.get_mut().write_all(&garbage).unwrap();
        if piece % 16 == 0 {
            other.hold(1).unwrap();
        }
    }
    stream.get_mut().write_all(b"\n{\"id\":7,\"ask\":{\"hold\":{\"task\":2}}}\n").unwrap();
    assert!(hear(&mut stream).contains("too long"));
    assert!(hear(&mut stream).contains("\"id\":7,"));
    assert!(160 * garbage.len() > MAX_LINE);
    let long = "x".repeat(MAX_LINE);
    assert!(matches!(other.add("a.list", &long), Err(Error::TooLong { .. })));
    other.hold(3).unwrap();
}

#[test]
fn a_flood_of_what_is_never_read_ends_in_the_floods_own_buffer() {
    let stage = Stage::new();
    let mut stream = raw(&stage);
    stream.get_mut().set_nonblocking(true).unwrap();
    let mut sent = 0_usize;
    // Until the manager's side takes no more, which it must say at last.
    let blocked = loop {
        match stream.get_mut().write(&b"nonsense\n".repeat(1000)) {
            Ok(bytes) => sent += bytes,
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                let before = stage.counts().malformed;
                stage.client().hold(1).unwrap();
                stage.client().hold(1).unwrap();
                if stage.counts().malformed == before {
                    break true;
                }
            }
            Err(_) => break false,
        }
        assert!(sent < 100 << 20, "it takes everything");
    };
    assert!(blocked);
}

#[test]
fn an_ask_is_answered_even_where_nothing_more_will_be_said() {
    let stage = Stage::new();
    let mut stream = raw(&stage);
    let asks =
        b"{\"id\":1,\"ask\":{\"hold\":{\"task\":1}}}\n{\"id\":2,\"ask\":{\"hold\":{\"task\":2}}}\n";
    stream.get_mut().write_all(asks).unwrap();
    stream.get_ref().shutdown(std::net::Shutdown::Write).unwrap();
    let mut answers = String::new();
    stream.read_to_string(&mut answers).unwrap();
    assert_eq!(answers.lines().count(), 2, "{answers}");
}

#[test]
fn who_asks_and_goes_leaves_nothing_behind() {
    let stage = Stage::new();
    stage.is_deaf.store(true, Ordering::Release);
    for _ in 0..3 * MAX_CLIENTS {
        let mut stream = None;
        until(|| {
            stream = UnixStream::connect(&stage.path).ok().map(BufReader::new);
            stream.as_mut().is_some_and(|stream| hear(stream).contains("hello"))
        });
        stream.unwrap().get_mut().write_all(b"{\"ask\":{\"hold\":{\"task\":1}}}\n").unwrap();
    }
    stage.is_deaf.store(false, Ordering::Release);
    stage.waker.wake();
    until(|| Control::connect(&stage.path).is_ok_and(|mut control| control.hold(2).is_ok()));
    until(|| stage.heard().contains(&Telecommand::Hold(id(2))));
}

/// What a client says in one session: whole asks and nonsense.
fn session() -> impl Strategy<Value = Vec<u8>> {
    let pieces = prop_oneof![
        Just(b"{\"id\":1,\"ask\":{\"hold\":{\"task\":1}}}\n".to_vec()),
        Just(b"{\"id\":2,\"ask\":{\"status\":{}}}\n".to_vec()),
        Just(b"{\"ask\":\"watch\"}\n".to_vec()),
        Just(b"{\"ask\":{\"add\":{\"name\":\"a.list\",\"text\":\"5 x\"}}}\n".to_vec()),
        prop::collection::vec(any::<u8>(), 0..40),
    ];
    prop::collection::vec(pieces, 0..6).prop_map(|pieces| pieces.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]
    #[test]
    fn a_client_that_goes_at_any_byte_disturbs_nobody(
        sessions in prop::collection::vec((session(), any::<prop::sample::Index>()), 1..8),
    ) {
        let stage = Stage::new();
        let mut other = stage.client();
        for (bytes, end) in sessions {
            let mut stream = UnixStream::connect(&stage.path).unwrap();
            let end = end.index(bytes.len() + 1);
            // Piece by piece, and gone without having read a word.
            for piece in bytes[..end].chunks(7) {
                // It may be refused: there is room for so many at a time.
                let _ = stream.write_all(piece);
            }
            drop(stream);
            other.hold(9).unwrap();
        }
        let expected = stage.heard().iter().filter(|heard| **heard == Telecommand::Hold(id(9))).count();
        prop_assert!(expected > 0);
    }
}
