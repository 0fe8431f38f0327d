//! What the report says is what the kernel did, whatever the host permits.
#![cfg(target_os = "linux")]

use std::fs;
use std::hint::black_box;
use std::thread;

use faregate_runtime::realtime::{Outcome, RealTime, Reason, Refusal, Wish};
use rustix::thread::{CpuSet, sched_getaffinity};

const EINVAL: Reason = Reason::Host { errno: 22 };

/// A field of the calling thread's `/proc/thread-self/stat`, numbered as in its
/// manual page.
fn stat(field: usize) -> u64 {
    let stat = fs::read_to_string("/proc/thread-self/stat").expect("/proc is mounted");
    let after_name = stat.rsplit(") ").next();
    let value = after_name.and_then(|rest| rest.split_whitespace().nth(field - 3)?.parse().ok());
    value.expect("the kernel's line has the field")
}

fn minor_faults() -> u64 {
    stat(10)
}

fn rt_priority() -> u64 {
    stat(40)
}

fn is_fifo() -> bool {
    stat(41) == 1
}

/// Each test has a thread of its own, so none inherits another's rights.
fn apart<R: Send>(f: impl FnOnce() -> R + Send) -> R {
    thread::scope(|scope| scope.spawn(f).join().expect("the claim holds"))
}

#[test]
fn the_thread_has_the_priority_exactly_when_the_report_says_so() {
    apart(|| {
        let report = RealTime::request().fifo(7).apply();
        assert_eq!(is_fifo(), report.is_complete(), "{report}");
        assert_eq!(rt_priority(), if report.is_complete() { 7 } else { 0 }, "{report}");
    });
}

#[test]
fn threads_of_a_real_time_thread_are_ordinary_ones() {
    apart(|| {
        let report = RealTime::request().fifo(7).apply();
        assert!(!apart(is_fifo), "{report}");
    });
}

#[test]
fn a_priority_out_of_range_is_refused() {
    apart(|| {
        for priority in [0, 100, 255] {
            let report = RealTime::request().fifo(priority).apply();
            let refusal = Refusal { wish: Wish::Fifo(priority), reason: EINVAL };
            assert_eq!(report.outcomes(), [Outcome::Refused(refusal)]);
            assert!(!is_fifo());
        }
    });
}

#[test]
fn the_thread_is_on_the_cpu_that_it_was_permitted() {
    apart(|| {
        let before = sched_getaffinity(None).unwrap();
        let cpu = (0..CpuSet::MAX_CPU).rfind(|cpu| before.is_set(*cpu)).unwrap();
        let report = RealTime::request().cpu(cpu).apply();
        assert_eq!(report.outcomes(), [Outcome::Permitted(Wish::Cpu(cpu))]);
        let after = sched_getaffinity(None).unwrap();
        assert_eq!((after.count(), after.is_set(cpu)), (1, true));
    });
}

#[test]
fn a_cpu_that_is_not_there_is_refused_and_the_thread_stays_where_it_was() {
    apart(|| {
        let before = sched_getaffinity(None).unwrap();
        for cpu in [CpuSet::MAX_CPU - 1, CpuSet::MAX_CPU, usize::MAX] {
            let report = RealTime::request().cpu(cpu).apply();
            assert_eq!(
                report.outcomes(),
                [Outcome::Refused(Refusal { wish: Wish::Cpu(cpu), reason: EINVAL })]
            );
            assert!(sched_getaffinity(None).unwrap() == before);
        }
    });
}

#[test]
fn a_refusal_keeps_nothing_else_from_being_permitted() {
    apart(|| {
        let report = RealTime::request().fifo(0).prefaulted_stack(4096).apply();
        assert!(!report.is_complete());
        assert_eq!(report.outcomes()[0], Outcome::Permitted(Wish::PrefaultedStack { bytes: 4096 }));
        assert_eq!(
            report.to_string(),
            "4096 bytes of stack beforehand: permitted\n\
             SCHED_FIFO priority 0: refused, Invalid argument (os error 22); ask for a priority from 1 to 99"
        );
    });
}

#[test]
fn what_was_not_asked_for_is_not_touched() {
    apart(|| {
        let before = sched_getaffinity(None).unwrap();
        let report = RealTime::request().apply();
        assert!(report.outcomes().is_empty() && report.is_complete() && !is_fifo());
        assert!(sched_getaffinity(None).unwrap() == before);
    });
}

/// Uses so much stack, and answers how often that faulted.
#[inline(never)]
fn faults_of_using<const BYTES: usize>() -> u64 {
    let before = minor_faults();
    use_stack::<BYTES>();
    minor_faults() - before
}

#[inline(never)]
fn use_stack<const BYTES: usize>() {
    let used = [1_u8; BYTES];
    black_box(&used);
}

#[test]
fn a_prefaulted_stack_does_not_fault_again() {
    const USED: usize = 512 * 1024;
    let cold = apart(faults_of_using::<USED>);
    let warm = apart(|| {
        let report = RealTime::request().prefaulted_stack(USED + 64 * 1024).apply();
        assert!(report.is_complete(), "{report}");
        faults_of_using::<USED>()
    });
    // A few faults come from reading the count.
    assert!(warm < 8, "{warm} faults after, {cold} without");
}

#[test]
fn more_stack_than_there_is_is_refused_without_touching_it() {
    let small = thread::Builder::new().stack_size(256 * 1024);
    let thread = small.spawn(|| {
        let report = RealTime::request().prefaulted_stack(1 << 30).apply();
        report.refusals().copied().collect::<Vec<_>>()
    });
    let refusals = thread.unwrap().join().unwrap();
    let [Refusal { wish: Wish::PrefaultedStack { .. }, reason: Reason::StackEnds { available } }] =
        refusals[..]
    else {
        panic!("{refusals:?}")
    };
    assert!((1..256 * 1024).contains(&available), "{available}");
}

#[test]
fn all_the_stack_that_is_said_to_be_there_can_be_touched() {
    let small = thread::Builder::new().stack_size(512 * 1024);
    let thread = small.spawn(|| {
        let ask = |bytes| RealTime::request().prefaulted_stack(bytes).apply();
        let report = ask(usize::MAX);
        let Some(Refusal { reason: Reason::StackEnds { available }, .. }) =
            report.refusals().next()
        else {
            panic!("{report}")
        };
        // The two calls do not start from the same depth to the byte.
        let report = ask(available - 1024);
        assert!(report.is_complete(), "{report}");
    });
    thread.unwrap().join().unwrap();
}
