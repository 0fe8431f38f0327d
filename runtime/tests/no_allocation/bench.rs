//! A broker with its threads, two lamps, and sensors that the test plays.

use std::fs;
use std::sync::atomic::Ordering::SeqCst;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;

use faregate_agents::{AgentId, Policy, Supervisor};
use faregate_runtime::host::Supported;
use faregate_runtime::{Broker, GateOptions, Handle};
use faregate_tickets::clock::Clock;
use faregate_tickets::device::{Estimate, Power};

use crate::lamp::{Lamp, Truth, WATTS};
use crate::meter::Meter;
use crate::sys;

/// Two lamps on a supply for one, behind the strategy `S`.
pub(crate) struct Bench<S: Supported> {
    pub(crate) broker: Broker,
    pub(crate) lamps: [Handle<Lamp, S>; 2],
    pub(crate) truths: [&'static Truth; 2],
    pub(crate) supervisor: Supervisor,
    pub(crate) of_agent: Supervisor,
    pub(crate) agent: AgentId,
}

impl<S: Supported> Bench<S> {
    pub(crate) fn new() -> Self {
        let mut builder = Broker::builder().unwrap();
        let agent = builder.agent(Policy::power_margin(WATTS)).unwrap();
        let truths: [&'static Truth; 2] = [(); 2].map(|()| &*Box::leak(Box::default()));
        let lamps = truths.map(|truth| {
            builder.gate_behind(agent, "lamp", Lamp(truth), GateOptions::new()).unwrap()
        });
        let supervisor = builder.supervisor();
        let of_agent = builder.supervisor_of(agent).unwrap();
        let broker = builder.start().unwrap();
        Self { broker, lamps, truths, supervisor, of_agent, agent }
    }

    /// The sensors measure, as often as it takes, until it is seen.
    pub(crate) fn measure_until(&self, meter: &mut Meter, mut seen: impl FnMut() -> bool) {
        while !seen() {
            for (lamp, truth) in self.lamps.iter().zip(&self.truths) {
                let state = if truth.on.load(SeqCst) { Power::On } else { Power::Off };
                meter.op(&["broker::observe", "broker::clock"], || {
                    let measured_at = self.broker.clock().now();
                    self.broker.observe(lamp.gate(), Estimate { state, measured_at });
                });
            }
            thread::yield_now();
        }
    }
}

/// One test at a time: the threads of a broker are told apart by name.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The kernel's numbers of this process's threads whose name begins so.
pub(crate) fn threads_named(name: &str) -> Vec<u32> {
    let tasks = fs::read_dir("/proc/self/task").unwrap().map(|task| task.unwrap());
    let named = tasks.filter(|task| {
        fs::read_to_string(task.path().join("comm")).is_ok_and(|comm| comm.starts_with(name))
    });
    named.map(|task| task.file_name().to_str().unwrap().parse().unwrap()).collect()
}

/// How often the service thread and the recorder have called the allocator. (A
/// thread's name is cut off after 15 letters.)
pub(crate) fn calls_of_threads() -> usize {
    let of = |name| {
        let threads = threads_named(name);
        assert_eq!(threads.len(), 1, "{name}");
        threads.into_iter().map(sys::calls_of).sum::<usize>()
    };
    of("faregate-servic") + of("faregate-record")
}
