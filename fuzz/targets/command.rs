//! What a task's process sends on its command port.
#![no_main]

use faregate_client::wire::{command, line};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(asked) = command::parse(bytes) {
        let written = line(&asked).expect("what was read can be written");
        assert_eq!(command::parse(&written).as_ref(), Ok(&asked));
    }
});
