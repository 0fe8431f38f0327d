//! The one thread that reads the sockets of all attempts. It never blocks but
//! in its wait for them.

use std::collections::HashMap;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use crossbeam::channel::{Receiver, Sender, TrySendError, bounded};
use faregate_client::wire::command::{Answer, Ask, MAX_MESSAGE, Notice, Said, parse};
use faregate_client::wire::{Asked, Id};
use faregate_client::{RefusalKind, Refused};
use rustix::event::epoll::{self, EventData, EventFlags};
use rustix::io::Errno;

use crate::executive::{PortNotice, Waker};
use crate::manager::Attempt;
use crate::port::connection::{Connection, Received, WhyClosed, pair};
use crate::port::worker::{Errand, Line, Tools, over, work};
use crate::port::{MAX_CONNECTIONS, MAX_QUEUED};

/// What the manager's thread wants of this one.
#[derive(Debug)]
pub(super) enum Order {
    Open(Arc<Line>, Connection),
    Tell(Attempt, PortNotice),
    Close(Attempt),
    End,
}

pub(super) struct Reader {
    epoll: OwnedFd,
    bell: Waker,
    orders: Receiver<Order>,
    tools: Arc<Tools>,
    attempts: HashMap<Attempt, Port>,
    connections: HashMap<u64, Known>,
    last: u64,
}

/// One attempt.
struct Port {
    line: Arc<Line>,
    /// To its worker, which it has from its first command on.
    errands: Option<Sender<Errand>>,
    connections: usize,
}

/// One connection.
struct Known {
    connection: Arc<Connection>,
    attempt: Attempt,
    wants_notices: bool,
}

/// The bell's mark among the connections'.
const BELL: u64 = 0;

impl Reader {
    pub(super) fn new(orders: Receiver<Order>, bell: Waker, tools: Tools) -> io::Result<Self> {
        let epoll = epoll::create(epoll::CreateFlags::CLOEXEC)?;
        epoll::add(&epoll, &bell, EventData::new_u64(BELL), EventFlags::IN)?;
        Ok(Self {
            epoll,
            bell,
            orders,
            tools: Arc::new(tools),
            attempts: HashMap::new(),
            connections: HashMap::new(),
            last: BELL,
        })
    }

    pub(super) fn run(mut self) {
        let mut ready = Vec::with_capacity(64);
        let mut bytes = [0; MAX_MESSAGE];
        loop {
            ready.clear();
            match epoll::wait(&self.epoll, rustix::buffer::spare_capacity(&mut ready), None) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(error) => {
                    tracing::error!(target: "faregate", %error, "the command ports are out of service");
                    return;
                }
            }
            // One message of each: nobody's flood keeps another one waiting.
            for event in &ready {
                let token = event.data.u64();
                if token == BELL {
                    if !self.obey() {
                        return;
                    }
                } else {
                    self.read(token, &mut bytes);
                }
            }
        }
    }

    /// Carries out what the manager's thread wants. `false`: it is the end.
    fn obey(&mut self) -> bool {
        let _ = self.bell.take();
        while let Ok(order) = self.orders.try_recv() {
            match order {
                Order::Open(line, connection) => {
                    let attempt = line.attempt;
                    self.attempts.insert(attempt, Port { line, errands: None, connections: 0 });
                    self.add(attempt, connection);
                }
                Order::Tell(attempt, notice) => self.tell(attempt, notice),
                Order::Close(attempt) => self.close(attempt),
                Order::End => {
                    self.connections
                        .values()
                        .for_each(|k| k.connection.close(WhyClosed::AttemptOver));
                    return false;
                }
            }
        }
        true
    }

    fn add(&mut self, attempt: Attempt, connection: Connection) -> bool {
        let token = self.last + 1;
        let flags = EventFlags::IN;
        if epoll::add(&self.epoll, &connection, EventData::new_u64(token), flags).is_err() {
            return false;
        }
        self.last = token;
        let connection = Arc::new(connection);
        self.connections.insert(token, Known { connection, attempt, wants_notices: false });
        if let Some(port) = self.attempts.get_mut(&attempt) {
            port.connections += 1;
        }
        true
    }

    /// Ends a connection. Its socket goes when a worker that still answers on
    /// it has answered.
    fn forget(&mut self, token: u64, why: WhyClosed) {
        if let Some(known) = self.connections.remove(&token) {
            let _ = epoll::delete(&self.epoll, known.connection.as_fd());
            known.connection.close(why);
            if let Some(port) = self.attempts.get_mut(&known.attempt) {
                port.connections -= 1;
            }
        }
    }

    fn close(&mut self, attempt: Attempt) {
        self.attempts.remove(&attempt);
        let its = |(&token, known): (&u64, &Known)| (known.attempt == attempt).then_some(token);
        let tokens: Vec<u64> = self.connections.iter().filter_map(its).collect();
        for token in tokens {
            self.forget(token, WhyClosed::AttemptOver);
        }
    }

    fn tell(&mut self, attempt: Attempt, notice: PortNotice) {
        let Some(port) = self.attempts.get(&attempt) else { return };
        let notice = match notice {
            PortNotice::Checkpoint { grace } => Notice::Checkpoint { grace_us: grace.as_micros() },
            PortNotice::Resumed => {
                Notice::Resumed { safed: port.line.commanded.lock().iter().cloned().collect() }
            }
        };
        let said = Said::Notice(notice);
        let its = self.connections.values().filter(|k| k.attempt == attempt && k.wants_notices);
        its.for_each(|known| known.connection.say(&said));
    }

    fn read(&mut self, token: u64, bytes: &mut [u8; MAX_MESSAGE]) {
        let Some(known) = self.connections.get(&token) else { return };
        match known.connection.receive(bytes) {
            Received::Nothing => {}
            Received::Closed(why) => self.forget(token, why),
            Received::Message(length) => match parse(&bytes[..length]) {
                Ok(asked) => self.serve(token, asked),
                Err(unreadable) => {
                    let garbage = unreadable.why.kind == RefusalKind::Malformed;
                    known.connection.answer(unreadable.id, Answer::Refused(unreadable.why));
                    if garbage {
                        self.forget(token, WhyClosed::Garbage);
                    }
                }
            },
        }
    }

    fn serve(&mut self, token: u64, Asked { id, ask }: Asked<Ask>) {
        let Some(known) = self.connections.get_mut(&token) else { return };
        match ask {
            Ask::Heartbeat => {
                let attempt = known.attempt;
                if id.is_some() {
                    known.connection.answer(id, Answer::Done { reply: String::new() });
                }
                self.beat(attempt);
            }
            Ask::Notices => {
                known.wants_notices = true;
                known.connection.answer(id, Answer::Done { reply: String::new() });
            }
            Ask::Open => self.open(token, id),
            Ask::Command { gate, command, arguments } => {
                let from = Arc::clone(&known.connection);
                let attempt = known.attempt;
                self.issue(attempt, Errand { from, id, gate, command, arguments });
            }
        }
    }

    fn beat(&self, attempt: Attempt) {
        self.tools.counts.heartbeats.fetch_add(1, Ordering::Relaxed);
        if let Some(port) = self.attempts.get(&attempt) {
            port.line.beat.beat(|| self.tools.manager.wake());
        }
    }

    fn open(&mut self, token: u64, id: Option<Id>) {
        let Some(known) = self.connections.get(&token) else { return };
        let (asker, attempt) = (Arc::clone(&known.connection), known.attempt);
        if self.attempts.get(&attempt).is_none_or(|port| port.connections >= MAX_CONNECTIONS) {
            return asker.answer(id, busy(format!("the task has {MAX_CONNECTIONS} connections")));
        }
        let ends = pair(attempt, &self.tools.counts).ok();
        match ends.and_then(|(ours, theirs)| self.add(attempt, ours).then_some(theirs)) {
            Some(theirs) => asker.pass(id, theirs.as_fd()),
            None => asker.answer(id, busy("the manager has no file descriptor left".into())),
        }
    }

    fn issue(&mut self, attempt: Attempt, errand: Errand) {
        let Some(port) = self.attempts.get_mut(&attempt) else {
            return errand.from.answer(errand.id, Answer::Refused(over(attempt)));
        };
        if port.errands.is_none() {
            port.errands = hire(&port.line, &self.tools);
        }
        let refused = match &port.errands {
            None => (errand, "the manager has no thread left for the task's commands".into()),
            Some(errands) => match errands.try_send(errand) {
                Ok(()) => return,
                Err(TrySendError::Full(errand) | TrySendError::Disconnected(errand)) => {
                    (errand, format!("{MAX_QUEUED} commands of the task wait already"))
                }
            },
        };
        self.tools.counts.refused.fetch_add(1, Ordering::Relaxed);
        let (errand, why) = refused;
        errand.from.answer(errand.id, busy(why));
    }
}

/// A thread for the commands of an attempt. It ends with the attempt, once the
/// command that it is at has ended.
fn hire(line: &Arc<Line>, tools: &Arc<Tools>) -> Option<Sender<Errand>> {
    let (errands, received) = bounded(MAX_QUEUED);
    let (line, tools) = (Arc::clone(line), Arc::clone(tools));
    let thread = std::thread::Builder::new().name("faregate-command".into());
    let hired = thread.spawn(move || work(&line, &received, &tools));
    hired.is_ok().then_some(errands)
}

fn busy(why: String) -> Answer {
    Answer::Refused(Refused::new(RefusalKind::Busy, why))
}
