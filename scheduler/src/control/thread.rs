//! The thread that serves the socket: accepts, reads, parses, writes.

use std::collections::HashMap;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use crossbeam::channel::{Receiver, Sender, TrySendError};
use faregate_client::wire::control::{Answer, Ask, Said, parse};
use faregate_client::wire::{Asked as SaidAsk, line};
use faregate_client::{RefusalKind, Refused};
use rustix::event::epoll::{self, EventData, EventFlags};
use rustix::io::Errno;
use rustix::time::Timespec;

use crate::control::client::{Client, Goes};
use crate::control::lines::Next;
use crate::control::listen::Listening;
use crate::control::socket::{Shared, Told};
use crate::control::{AskId, Asked, MAX_CLIENTS, ReadSchedule, convert};
use crate::executive::Waker;
use crate::manager::Note;
use crate::time::Now;

/// What the thread works with.
pub(super) struct Tools {
    pub(super) asks: Sender<Asked>,
    pub(super) hears: Receiver<Told>,
    pub(super) changes: Receiver<(Now, Note)>,
    pub(super) schedules: Arc<dyn ReadSchedule>,
    pub(super) manager: Waker,
    pub(super) shared: Arc<Shared>,
}

pub(super) struct Server {
    pub(super) epoll: OwnedFd,
    pub(super) listening: Listening,
    /// The host has no descriptor left: nobody is let in for a while.
    pub(super) is_short: bool,
    bell: Waker,
    pub(super) tools: Tools,
    pub(super) clients: HashMap<u64, Client>,
    asked: HashMap<AskId, u64>,
    last_client: u64,
    last_ask: u64,
}

const BELL: u64 = 0;
pub(super) const LISTENER: u64 = 1;

/// How long nobody is let in when the host is short of descriptors.
const SHORT: Timespec = Timespec { tv_sec: 1, tv_nsec: 0 };

impl Server {
    pub(super) fn new(listening: Listening, bell: Waker, tools: Tools) -> io::Result<Self> {
        let epoll = epoll::create(epoll::CreateFlags::CLOEXEC)?;
        epoll::add(&epoll, &bell, EventData::new_u64(BELL), EventFlags::IN)?;
        epoll::add(&epoll, &listening.listener, EventData::new_u64(LISTENER), EventFlags::IN)?;
        Ok(Self {
            epoll,
            listening,
            is_short: false,
            bell,
            tools,
            clients: HashMap::new(),
            asked: HashMap::new(),
            last_client: LISTENER,
            last_ask: 0,
        })
    }

    pub(super) fn run(mut self) {
        let mut ready = Vec::with_capacity(MAX_CLIENTS + 2);
        loop {
            ready.clear();
            let wait = self.is_short.then_some(&SHORT);
            match epoll::wait(&self.epoll, rustix::buffer::spare_capacity(&mut ready), wait) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(error) => {
                    tracing::error!(target: "faregate", %error, "the control port is out of service");
                    return;
                }
            }
            if core::mem::take(&mut self.is_short) {
                self.listen(EventFlags::IN);
            }
            for event in &ready {
                match event.data.u64() {
                    BELL if !self.hear() => return,
                    BELL => {}
                    LISTENER => self.let_in(),
                    token => self.serve(token, event.flags),
                }
            }
        }
    }

    pub(super) fn admit(&mut self, client: Client) {
        let token = self.last_client + 1;
        let data = EventData::new_u64(token);
        if epoll::add(&self.epoll, &client, data, EventFlags::IN).is_ok() {
            self.last_client = token;
            self.clients.insert(token, client);
            self.attend(token);
        }
    }

    fn serve(&mut self, token: u64, flags: EventFlags) {
        let Some(client) = self.clients.get_mut(&token) else { return };
        // Nobody is there to be answered any more.
        let gone = flags.intersects(EventFlags::HUP | EventFlags::ERR) && !client.is_heard();
        if gone || (client.is_heard() && client.read() == Goes::Away) {
            return self.dismiss(token);
        }
        self.attend(token);
    }

    /// Takes what the client has said, as far as it may, and tells it what
    /// there is to tell.
    fn attend(&mut self, token: u64) {
        while let Some(client) = self.clients.get_mut(&token) {
            match client.next_line() {
                Next::Nothing => break,
                Next::TooLong => {
                    let why = Refused::new(RefusalKind::Malformed, "the line is too long");
                    client.answer(None, Answer::Refused(why));
                    self.tools.shared.malformed.fetch_add(1, Relaxed);
                }
                Next::Line(line) => self.take(token, &line),
            }
        }
        let Some(client) = self.clients.get_mut(&token) else { return };
        if client.send() == Goes::Away {
            return self.dismiss(token);
        }
        let mut flags = EventFlags::empty();
        flags.set(EventFlags::IN, client.is_heard());
        flags.set(EventFlags::OUT, client.has_unsent());
        if epoll::modify(&self.epoll, &*client, EventData::new_u64(token), flags).is_err() {
            self.dismiss(token);
        }
    }

    fn take(&mut self, token: u64, line: &[u8]) {
        let Some(client) = self.clients.get_mut(&token) else { return };
        if line.trim_ascii().is_empty() {
            return;
        }
        let SaidAsk { id, ask } = match parse(line) {
            Ok(asked) => asked,
            Err(unreadable) => {
                self.tools.shared.malformed.fetch_add(1, Relaxed);
                return client.answer(unreadable.id, Answer::Refused(unreadable.why));
            }
        };
        let watch = ask == Ask::Watch;
        match convert::asked(ask, &*self.tools.schedules) {
            Err(why) => client.answer(id, Answer::Refused(why)),
            Ok(None) => {
                if watch && !client.watches {
                    client.watches = true;
                    self.tools.shared.watchers.fetch_add(1, Relaxed);
                }
                client.answer(id, Answer::Done);
            }
            Ok(Some(what)) => {
                self.last_ask += 1;
                let ask = AskId(self.last_ask);
                if let Err(error) = self.tools.asks.try_send(Asked { id: ask, what }) {
                    return client.answer(id, Answer::Refused(unheard(&error)));
                }
                client.asks(id);
                self.asked.insert(ask, token);
                self.tools.manager.wake();
            }
        }
    }

    fn dismiss(&mut self, token: u64) {
        if let Some(client) = self.clients.remove(&token) {
            let _ = epoll::delete(&self.epoll, client.as_fd());
            if client.watches {
                self.tools.shared.watchers.fetch_sub(1, Relaxed);
            }
        }
    }

    /// What the manager's thread says. `false`: it is the end.
    fn hear(&mut self) -> bool {
        let _ = self.bell.take();
        self.pass_changes();
        while let Ok(told) = self.tools.hears.try_recv() {
            match told {
                Told::Answer(ask, what) => {
                    let Some(token) = self.asked.remove(&ask) else { continue };
                    if let Some(client) = self.clients.get_mut(&token) {
                        client.answered(what);
                        self.attend(token);
                    }
                }
                Told::End => return false,
            }
        }
        true
    }

    fn pass_changes(&mut self) {
        let lost = self.tools.shared.lost.swap(0, Relaxed);
        self.clients.values_mut().for_each(|client| client.lose(lost));
        let mut told = lost > 0;
        // As many as there are now: a manager that goes on noting keeps nobody
        // from being served.
        for (now, note) in self.tools.changes.try_iter().take(self.tools.changes.len()) {
            let Some(bytes) = told_line(now, &note) else { continue };
            self.clients.values_mut().for_each(|client| client.note(&bytes));
            told = true;
        }
        if told {
            let watchers = self.clients.iter().filter(|(_, client)| client.watches);
            let tokens: Vec<u64> = watchers.map(|(&token, _)| token).collect();
            tokens.into_iter().for_each(|token| self.attend(token));
        }
    }
}

/// Each client waits for its answer, but one may have asked and gone.
fn unheard(error: &TrySendError<Asked>) -> Refused {
    if error.is_full() {
        Refused::new(RefusalKind::Busy, "the manager has not heard yet what was asked before")
    } else {
        Refused::new(RefusalKind::Stopping, "the manager stops")
    }
}

fn told_line(now: Now, note: &Note) -> Option<Vec<u8>> {
    let note = serde_json::to_value(note).ok()?;
    let (at_us, unix_us) = (now.elapsed.as_micros(), now.wall.as_micros());
    line(&Said::Note { at_us, unix_us, note }).ok()
}
