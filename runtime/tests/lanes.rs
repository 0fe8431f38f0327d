//! *Nothing Lost*: what was recorded reaches `tracing`, or is counted.

use std::io::Write;
use std::sync::{Arc, Mutex};

use faregate_runtime::lanes::{Drained, Recorder, RingLane};
use faregate_tickets::clock::Instant;
use faregate_tickets::id::{GateId, Priority};
use faregate_tickets::recorder::{Lane, Record, RecordedEvent};
use tracing::Level;

fn record(us: u64, ticket: usize, code: u16) -> Record {
    Record { at: Instant::from_micros(us), ticket, event: RecordedEvent::Issued { code } }
}

fn fill(lane: &mut RingLane, instants: impl IntoIterator<Item = u64>) {
    instants.into_iter().for_each(|us| lane.record(record(us, 1, 0)));
}

/// Everything that `tracing` is given while `f` runs, a line per event.
fn told(f: impl FnOnce()) -> Vec<String> {
    #[derive(Clone, Default)]
    struct Page(Arc<Mutex<Vec<u8>>>);

    impl Write for Page {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().map_or(Ok(0), |mut page| page.write(bytes))
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    let page = Page::default();
    let writer = page.clone();
    let subscriber = tracing_subscriber::fmt()
        .with_max_level(Level::TRACE)
        .without_time()
        .with_ansi(false)
        .with_writer(move || writer.clone())
        .finish();
    tracing::subscriber::with_default(subscriber, f);
    let bytes = page.0.lock().expect("nobody panicked over the page").clone();
    String::from_utf8(bytes).expect("text").lines().map(|line| line.trim().to_owned()).collect()
}

#[test]
fn a_record_is_told_with_its_time_lane_ticket_and_event() {
    let mut recorder = Recorder::new();
    let mut lane = recorder.lane("camera", 4);
    lane.record(record(1_500_000, 7, 42));
    assert_eq!(
        told(|| assert_eq!(recorder.drain(), Drained { records: 1, lost: 0 })),
        [r#"DEBUG faregate: time_us=1500000 lane="camera" ticket=7 event=Issued { code: 42 }"#]
    );
}

#[test]
fn a_record_that_concerns_no_ticket_names_none() {
    let mut recorder = Recorder::new();
    recorder.lane("camera", 4).record(record(1, 0, 2));
    let lines = told(|| assert_eq!(recorder.drain().lost, 0));
    assert_eq!(lines, [r#"DEBUG faregate: time_us=1 lane="camera" event=Issued { code: 2 }"#]);
}

#[test]
fn what_needs_attention_is_told_apart_from_the_traffic() {
    let gate = GateId(3);
    let floor = Priority::FAULT_RESPONSE;
    let events = [
        RecordedEvent::Stuck { gate },
        RecordedEvent::SafeMode { floor },
        RecordedEvent::Granted,
        RecordedEvent::Relinquished,
    ];
    let mut recorder = Recorder::new();
    let mut lane = recorder.lane("broker", 8);
    for event in events {
        lane.record(Record { at: Instant::START, ticket: 0, event });
    }
    let lines = told(|| assert_eq!(recorder.drain().records, 4));
    let told: Vec<_> = lines.iter().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(told, ["ERROR", "WARN", "INFO", "DEBUG"]);
}

#[test]
fn records_of_several_lanes_are_told_in_the_order_of_time() {
    let mut recorder = Recorder::new();
    let (mut camera, mut valve) = (recorder.lane("camera", 4), recorder.lane("valve", 4));
    fill(&mut camera, [1, 4, 6]);
    fill(&mut valve, [2, 3, 5]);
    let lines = told(|| assert_eq!(recorder.drain().lost, 0));
    let order: Vec<_> = lines.iter().map(|line| line.split_whitespace().nth(2).unwrap()).collect();
    assert_eq!(
        order,
        ["time_us=1", "time_us=2", "time_us=3", "time_us=4", "time_us=5", "time_us=6"]
    );
}

#[test]
fn what_finds_its_lane_full_is_counted_and_reported_once() {
    let mut recorder = Recorder::new();
    let (mut camera, mut valve) = (recorder.lane("camera", 2), recorder.lane("valve", 2));
    fill(&mut camera, 1..=5);
    fill(&mut valve, 1..=3);
    let lines = told(|| {
        assert_eq!(recorder.drain(), Drained { records: 4, lost: 4 });
        assert_eq!(recorder.drain(), Drained::default());
    });
    assert_eq!(
        lines[4..],
        [
            r#"WARN faregate: 3 records lost in lane camera lane="camera" lost=3"#,
            r#"WARN faregate: 1 record lost in lane valve lane="valve" lost=1"#,
        ]
    );
}

#[test]
fn a_lane_that_was_drained_has_room_again() {
    let mut recorder = Recorder::new();
    let mut lane = recorder.lane("camera", 2);
    for round in 0..3 {
        fill(&mut lane, [round, round]);
        assert_eq!(recorder.drain(), Drained { records: 2, lost: 0 });
    }
}

#[test]
fn the_last_records_of_a_lane_that_is_gone_are_told() {
    let mut recorder = Recorder::new();
    let mut lane = recorder.lane("camera", 2);
    fill(&mut lane, [1, 2, 3]);
    drop(lane);
    assert_eq!(recorder.drain(), Drained { records: 2, lost: 1 });
}

#[test]
fn every_record_of_a_writer_that_does_not_wait_is_told_or_counted() {
    const WRITTEN: usize = 100_000;
    let mut recorder = Recorder::new();
    let mut lane = recorder.lane("camera", 8);
    let mut sum = Drained::default();
    std::thread::scope(|scope| {
        let writer = scope.spawn(move || fill(&mut lane, 0..WRITTEN as u64));
        loop {
            let last = writer.is_finished();
            let drained = recorder.drain();
            sum.records += drained.records;
            sum.lost += drained.lost;
            if last {
                break;
            }
        }
    });
    assert_eq!(sum.records + sum.lost, WRITTEN, "{sum:?}");
    assert!(sum.records >= 8, "{sum:?}");
}
