//! Memory that stays. Alone in its file, because it is of the whole process.
#![cfg(target_os = "linux")]

use std::hint::black_box;

use faregate_runtime::realtime::RealTime;

/// What the kernel has locked for this process, in kilobytes.
fn locked_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("/proc is mounted");
    let line = status.lines().find_map(|line| line.strip_prefix("VmLck:"));
    let kb = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse().ok());
    kb.expect("the kernel says how much is locked")
}

#[test]
fn memory_is_locked_exactly_when_the_report_says_so() {
    assert_eq!(locked_kb(), 0);
    let report = RealTime::request().locked_memory().apply();
    assert_eq!(locked_kb() > 0, report.is_complete(), "{report}");
    if report.is_complete() {
        let before = locked_kb();
        let mapped_later = black_box(vec![1_u8; 4 << 20]);
        assert!(
            locked_kb() >= before + 4096,
            "{} kB for {} bytes",
            locked_kb() - before,
            mapped_later.len()
        );
    }
}
