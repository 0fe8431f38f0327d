//! A server over devices that note what they are commanded, and attempts.

use std::collections::VecDeque;
use std::os::fd::OwnedFd;
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

use faregate_client::CommandPort;
use faregate_scheduler::TaskId;
use faregate_scheduler::executive::{CommandRefused, Commands, PortFactory, RefusedKind, Waker};
use faregate_scheduler::manager::{Attempt, Event, Occurrence};
use faregate_scheduler::port::CommandServer;

/// Longer than anything here takes on any machine: who waits so long hangs.
pub(crate) const LONG: Duration = Duration::from_secs(60);

/// What was commanded, in the order in which devices saw it.
#[derive(Debug, Default)]
pub(crate) struct Devices {
    seen: Mutex<Vec<(Attempt, String)>>,
    /// What `slow` waits for, once for each of its commands.
    lets_go: Mutex<VecDeque<mpsc::Receiver<()>>>,
    /// Who has taken the tickets, while somebody has.
    taker: Mutex<Option<String>>,
}

impl Devices {
    pub(crate) fn seen(&self) -> Vec<String> {
        self.seen.lock().unwrap().iter().map(|(_, command)| command.clone()).collect()
    }

    pub(crate) fn seen_by(&self, attempt: Attempt) -> usize {
        self.seen.lock().unwrap().iter().filter(|(by, _)| *by == attempt).count()
    }

    /// The next command of `slow` takes until this is sent something, or
    /// dropped.
    pub(crate) fn slow_until(&self) -> mpsc::Sender<()> {
        let (sender, receiver) = mpsc::channel();
        self.lets_go.lock().unwrap().push_back(receiver);
        sender
    }

    pub(crate) fn taken_by(&self, taker: Option<&str>) {
        *self.taker.lock().unwrap() = taker.map(Into::into);
    }

    fn refuse(kind: RefusedKind, reason: impl Into<String>) -> Result<String, CommandRefused> {
        Err(CommandRefused::new(kind, reason))
    }
}

impl Commands for Devices {
    fn command(
        &self,
        attempt: Attempt,
        gate: &str,
        command: &str,
        arguments: &[String],
    ) -> Result<String, CommandRefused> {
        if let Some(taker) = &*self.taker.lock().unwrap() {
            let refused = CommandRefused::new(RefusedKind::Taken, format!("pre-empted by {taker}"));
            return Err(CommandRefused { taken_by: Some(taker.clone()), ..refused });
        }
        self.seen.lock().unwrap().push((attempt, format!("{gate} {command}")));
        match gate {
            "slow" => {
                let lets_go = self.lets_go.lock().unwrap().pop_front();
                let _ = lets_go.map(|until| until.recv());
                Ok("at last".into())
            }
            "talks" => Ok("x\"".repeat(command.parse().unwrap())),
            "panics" => panic!("a driver's defect"),
            "nowhere" => Self::refuse(RefusedKind::NoSuchGate, "no gate nowhere"),
            _ => Ok(arguments.join("+")),
        }
    }
}

pub(crate) struct Stage {
    pub(crate) devices: Arc<Devices>,
    pub(crate) server: CommandServer,
    pub(crate) waker: Waker,
    next: u32,
}

impl Stage {
    pub(crate) fn new() -> Self {
        let (devices, waker) = (Arc::<Devices>::default(), Waker::new().unwrap());
        let server = CommandServer::start(Arc::clone(&devices) as _, waker.clone()).unwrap();
        Self { devices, server, waker, next: 1 }
    }

    /// A further attempt, and what its process inherits.
    pub(crate) fn open(&mut self) -> (Attempt, OwnedFd) {
        let task = TaskId::new(31).unwrap();
        let occurrence = Occurrence { task, load: 0, number: 0 };
        let attempt = Attempt { occurrence, number: self.next };
        self.next += 1;
        (attempt, self.server.open(attempt).unwrap().unwrap())
    }

    /// A further attempt, with a process that has connected.
    pub(crate) fn connected(&mut self) -> (Attempt, CommandPort) {
        let (attempt, inherited) = self.open();
        let mut port = CommandPort::over(inherited).unwrap();
        port.set_timeout(Some(LONG)).unwrap();
        (attempt, port)
    }

    pub(crate) fn events(&self) -> Vec<Event> {
        let mut events = Vec::new();
        self.server.poll(&mut events);
        events
    }

    /// Waits until the manager's thread would be woken.
    pub(crate) fn woken(&self) {
        until(|| self.waker.take());
    }
}

/// Waits for something that is sure to come.
#[expect(
    clippy::disallowed_methods,
    reason = "what is waited for is another thread's or process's"
)]
pub(crate) fn until(mut over: impl FnMut() -> bool) {
    let start = Instant::now();
    while !over() {
        assert!(start.elapsed() < LONG, "it does not come");
        std::thread::sleep(Duration::from_millis(1));
    }
}
