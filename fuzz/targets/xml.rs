//! Plans, parameters and states as people write them.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| faregate_fuzz::plan("fuzzed.xml", bytes));
