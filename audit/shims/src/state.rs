//! State variables.

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
