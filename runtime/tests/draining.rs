//! The thread that drains: alone in its file, because what it tells goes to the
//! one subscriber of the whole process.

use std::sync::mpsc::{Sender, channel};
use std::time::Duration as HostDuration;

use faregate_runtime::lanes::Recorder;
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::recorder::{Lane, Record, RecordedEvent};
use tracing::span::{Attributes, Id, Record as SpanRecord};
use tracing::{Event, Metadata, Subscriber};

/// Passes on the target of each event.
struct Listener(Sender<String>);

impl Subscriber for Listener {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }
    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }
    fn record(&self, _: &Id, _: &SpanRecord<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn event(&self, event: &Event<'_>) {
        self.0.send(event.metadata().target().to_owned()).expect("the test still listens");
    }
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

/// Longer than any drain takes: a record that is not told shows as a timeout.
const PATIENCE: HostDuration = HostDuration::from_secs(20);

#[test]
fn records_are_told_each_period_and_once_more_at_the_end() {
    let (told, events) = channel();
    tracing::subscriber::set_global_default(Listener(told)).unwrap();
    let issued = Record { at: Instant::START, ticket: 1, event: RecordedEvent::Issued { code: 1 } };

    let mut recorder = Recorder::new();
    let mut lane = recorder.lane("camera", 4);
    let draining = recorder.start(Duration::from_millis(1)).unwrap();
    for _ in 0..3 {
        lane.record(issued);
        assert_eq!(events.recv_timeout(PATIENCE).unwrap(), "faregate");
    }

    // A period of a day: one record is told at the start, the other by the end.
    let recorder = draining.stop().unwrap();
    lane.record(issued);
    let draining = recorder.start(Duration::from_secs(86_400)).unwrap();
    assert_eq!(events.recv_timeout(PATIENCE).unwrap(), "faregate");
    lane.record(issued);
    drop(draining);
    assert_eq!(events.try_recv().unwrap(), "faregate");
    assert!(events.try_recv().is_err());
}
