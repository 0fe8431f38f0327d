//! What an operator sends on the control port.
#![no_main]

use faregate_client::wire::{control, line};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(asked) = control::parse(bytes) {
        let written = line(&asked).expect("what was read can be written");
        assert_eq!(control::parse(&written).as_ref(), Ok(&asked));
    }
});
