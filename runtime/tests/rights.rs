//! A process without rights: what it asks for is refused with the reason and
//! the advice. Alone in its file, because limits are of the whole process.
#![cfg(target_os = "linux")]

use faregate_runtime::realtime::{RealTime, Reason, Refusal, Wish};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use rustix::thread::{CapabilitySet, CapabilitySets, capabilities, set_capabilities};

const EPERM: Reason = Reason::Host { errno: 1 };

/// Leaves the process limits of nothing, and the calling thread no capability.
fn give_up_rights() -> rustix::io::Result<()> {
    for limit in [Resource::Rtprio, Resource::Memlock] {
        let maximum = getrlimit(limit).maximum;
        setrlimit(limit, Rlimit { current: Some(0), maximum })?;
    }
    let effective = CapabilitySet::empty();
    set_capabilities(None, CapabilitySets { effective, ..capabilities(None)? })
}

#[test]
fn without_rights_the_report_says_what_was_refused_why_and_what_to_do() {
    give_up_rights().unwrap();
    let report = RealTime::request().fifo(80).locked_memory().prefaulted_stack(8192).apply();
    let refusals: Vec<_> = report.refusals().copied().collect();
    assert_eq!(
        refusals,
        [
            Refusal { wish: Wish::LockedMemory, reason: EPERM },
            Refusal { wish: Wish::Fifo(80), reason: EPERM }
        ]
    );
    let text = report.to_string();
    let lines: Vec<_> = text.lines().collect();
    assert!(lines[0].starts_with("locked memory: refused, Operation not permitted (os error 1); "));
    assert!(lines[0].contains("CAP_IPC_LOCK") && lines[0].contains("ulimit -l"));
    assert_eq!(lines[1], "8192 bytes of stack beforehand: permitted");
    assert!(
        lines[2]
            .starts_with("SCHED_FIFO priority 80: refused, Operation not permitted (os error 1); ")
    );
    assert!(lines[2].contains("CAP_SYS_NICE") && lines[2].contains("ulimit -r"));
}
