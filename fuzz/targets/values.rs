//! Single values: durations, times, sizes, and the words of arguments.
#![no_main]

use faregate_scheduler::format::say;

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(duration) = say::duration(text) {
        let again = format!(
            "{}.{:06}s",
            duration.as_micros() / 1_000_000,
            duration.as_micros() % 1_000_000
        );
        assert_eq!(say::duration(&again), Ok(duration), "{again}");
        assert!(say::when(&format!("+{text}")).is_ok());
    }
    let _ = say::when(text);
    let _ = say::size(text);
    if let Ok(words) = say::words(text) {
        assert!(words.iter().all(|word| !word.contains('\0')));
    }
});
