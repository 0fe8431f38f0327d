//! State variables, and the recorder that a host has.

use faregate_tickets::clock::Instant;
use faregate_tickets::telemetry::{Channel, Mode, Telemetry};

use crate::entry;
use crate::random::Random;
use crate::sys::Slot;

static TABLE: Slot<Telemetry> = Slot::empty();
static CHANNEL: Slot<Channel> = Slot::empty();
static MODE: Slot<Mode> = Slot::empty();
static VALUE: Slot<i32> = Slot::empty();
static AT: Slot<Instant> = Slot::empty();

fn set_up(seed: u64) {
    let random = &mut Random::new(seed);
    let channel = Channel::new(random.byte() & 15).expect("a channel");
    let mode = Mode::new(random.byte() & 31).expect("a mode");
    let table = TABLE.fill(Telemetry::new());
    if random.flip() {
        table.publish(channel, 1, Instant::from_micros(random.next() >> 9));
    }
    CHANNEL.fill(channel);
    MODE.fill(mode);
    VALUE.fill(i32::from(random.byte()));
    AT.fill(Instant::from_micros(random.next() >> 8));
}

entry!(set_mode, |seed| set_up(seed), TABLE.get().set_mode(*MODE.get()));
entry!(mode, |seed| set_up(seed), TABLE.get().mode());
entry!(publish, |seed| set_up(seed), TABLE.get().publish(*CHANNEL.get(), *VALUE.get(), *AT.get()));
entry!(read, |seed| set_up(seed), TABLE.get().read(*CHANNEL.get(), *AT.get()));

/// The lane of a host's gate, with a reading end that does not keep up.
#[cfg(target_os = "linux")]
mod lane {
    use faregate_runtime::lanes::{Recorder, RingLane};
    use faregate_tickets::recorder::{Lane, Record, RecordedEvent};

    use super::*;

    static RECORDER: Slot<Recorder> = Slot::empty();
    static LANE: Slot<RingLane> = Slot::empty();
    static RECORD: Slot<Record> = Slot::empty();

    fn set_up(seed: u64) {
        let random = &mut Random::new(seed);
        let at = Instant::from_micros(random.next() >> 8);
        let event = RecordedEvent::Issued { code: u16::from(random.byte()) };
        let record = *RECORD.fill(Record { at, ticket: 1, event });
        let lane = LANE.fill(RECORDER.fill(Recorder::new()).lane("a gate", 4));
        for _ in 0..random.below(6) {
            lane.record(record);
        }
    }

    entry!(lane_record, |seed| set_up(seed), LANE.get_mut().record(*RECORD.get()));
}
