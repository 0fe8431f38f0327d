//! What the host permits, and where threads go.

use std::fs;

use faregate::runtime::realtime::RealTime;
use rustix::process::{Resource, getrlimit};
use rustix::thread::{CapabilitySet, CpuSet, capabilities, sched_getaffinity};

use super::Outcome;

/// The holder's `SCHED_FIFO` priority.
pub(crate) const HOLDER: u8 = 20;
/// The hog's.
pub(crate) const HOG: u8 = 40;
/// The revoker's.
pub(crate) const REVOKER: u8 = 60;
/// That of the broker's service thread, above all holders.
pub(crate) const SERVICE: u8 = 80;

/// Which CPUs the threads of a row are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Placement {
    /// The holder's and the hog's.
    pub(crate) holder_cpu: usize,
    /// The revoker's.
    pub(crate) revoker_cpu: usize,
}

impl Placement {
    pub(crate) fn is_one_cpu(self) -> bool {
        self.holder_cpu == self.revoker_cpu
    }

    pub(crate) fn name(self) -> &'static str {
        if self.is_one_cpu() { "one CPU" } else { "two CPUs" }
    }
}

/// What could be set up, and what could not.
#[derive(Debug)]
pub(crate) struct Rights {
    /// The placements that rows can have, of the two that there are.
    pub(crate) placements: Vec<Placement>,
    /// What is missing, in words.
    pub(crate) missing: Vec<String>,
}

impl Rights {
    /// Locks the process's memory, and asks whether threads may have the
    /// priorities and CPUs that rows need.
    pub(crate) fn take(cpus: &[usize]) -> Self {
        let mut rights = Self { placements: Vec::new(), missing: Vec::new() };
        if let Err(missing) = lock_memory() {
            rights.missing.push(format!("{missing} (rows are measured all the same)"));
        }
        let cpus = if cpus.is_empty() { permitted_cpus() } else { cpus.to_vec() };
        let Some(&first) = cpus.first() else {
            rights.missing.push("a CPU: none is in the affinity of this process".into());
            return rights;
        };
        if rights.may_run_on(first) {
            rights.placements.push(Placement { holder_cpu: first, revoker_cpu: first });
        }
        match cpus.iter().find(|cpu| **cpu != first) {
            None => rights.missing.push("a second CPU: rows on two CPUs are skipped".into()),
            Some(&second) if !rights.placements.is_empty() && rights.may_run_on(second) => {
                rights.placements.push(Placement { holder_cpu: first, revoker_cpu: second });
            }
            Some(_) => {}
        }
        rights
    }

    /// Tries it in a thread that ends, so that nothing stays.
    fn may_run_on(&mut self, cpu: usize) -> bool {
        let tried = std::thread::spawn(move || take(cpu, SERVICE)).join();
        let refused = match tried {
            Ok(Ok(())) => return true,
            Ok(Err(refused)) => refused.to_string(),
            Err(_) => "the thread that tried it panicked".into(),
        };
        self.missing.push(format!("{refused}; rows on CPU {cpu} are skipped"));
        false
    }
}

/// Locks all memory of the process, if what comes later can be locked as well:
/// with a limit, a thread that starts then could find no memory for its stack.
fn lock_memory() -> Outcome<()> {
    let is_limited = getrlimit(Resource::Memlock).current.is_some();
    let may_exceed =
        capabilities(None).is_ok_and(|sets| sets.effective.contains(CapabilitySet::IPC_LOCK));
    if is_limited && !may_exceed {
        return Err(
            "locked memory: not asked for, because there is a limit to it; give the process \
                    CAP_IPC_LOCK, or no limit of locked memory (`ulimit -l unlimited`)"
                .into(),
        );
    }
    let report = RealTime::request().locked_memory().apply();
    if report.is_complete() { Ok(()) } else { Err(report.to_string().into()) }
}

/// Gives the calling thread this CPU and this `SCHED_FIFO` priority.
pub(crate) fn take(cpu: usize, priority: u8) -> Outcome<()> {
    let report = RealTime::request().prefaulted_stack(64 * 1024).cpu(cpu).fifo(priority).apply();
    let refused: Vec<_> = report.refusals().map(ToString::to_string).collect();
    if refused.is_empty() { Ok(()) } else { Err(refused.join("; ").into()) }
}

fn permitted_cpus() -> Vec<usize> {
    let Ok(set) = sched_getaffinity(None) else { return Vec::new() };
    (0..CpuSet::MAX_CPU).filter(|cpu| set.is_set(*cpu)).collect()
}

/// What the kernel keeps from real-time threads, in words.
pub(crate) fn throttling() -> String {
    let read = |name| {
        let text = fs::read_to_string(format!("/proc/sys/kernel/{name}")).ok()?;
        text.trim().parse::<i64>().ok()
    };
    match (read("sched_rt_runtime_us"), read("sched_rt_period_us")) {
        (Some(-1), _) => "the kernel keeps no time from real-time threads".into(),
        (Some(runtime), Some(period)) => format!(
            "the kernel keeps {} of each {period} us from real-time threads that leave none to others \
             (sched_rt_runtime_us = {runtime}); rounds are followed by pauses, so that it need not, and \
             one that is hit all the same is late by as much",
            period - runtime
        ),
        _ => "whether the kernel keeps time from real-time threads is not known: \
              /proc/sys/kernel/sched_rt_runtime_us cannot be read"
            .into(),
    }
}
