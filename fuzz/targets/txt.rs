#![no_main]

use faregate_scheduler::format::Kind;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| faregate_fuzz::schedule(Kind::Txt, bytes));
