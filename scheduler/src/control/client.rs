//! One client of the socket: what it says, and what it is told.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;

use faregate_client::wire::control::{Answer, MAX_LINE, Said};
use faregate_client::wire::{Id, line};

use crate::control::lines::{Lines, Next};

/// What waits to be sent, before nothing more is read and no change told.
const FULL: usize = 256 * 1024;

/// How much is read at a time.
const PIECE: usize = 64 * 1024;

#[derive(Debug)]
pub(super) struct Client {
    stream: UnixStream,
    lines: Lines,
    unsent: VecDeque<u8>,
    /// It has asked something, by this number, and was not answered.
    waits: Option<Option<Id>>,
    /// It will say nothing more.
    ended: bool,
    pub(super) watches: bool,
    lost: u64,
}

/// Whether a client can go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Goes {
    On,
    Away,
}

impl Client {
    pub(super) fn new(stream: UnixStream) -> Self {
        Self {
            stream,
            lines: Lines::new(MAX_LINE),
            unsent: VecDeque::new(),
            waits: None,
            ended: false,
            watches: false,
            lost: 0,
        }
    }

    /// Whether it is to be read: its last ask was answered, and it takes its
    /// answers.
    pub(super) fn is_heard(&self) -> bool {
        self.waits.is_none() && !self.ended && self.unsent.len() < FULL
    }

    pub(super) fn has_unsent(&self) -> bool {
        !self.unsent.is_empty()
    }

    /// Reads a piece.
    pub(super) fn read(&mut self) -> Goes {
        let mut piece = [0; PIECE];
        match self.stream.read(&mut piece) {
            Ok(0) => self.ended = true,
            Ok(length) => self.lines.push(&piece[..length]),
            Err(error) if is_later(&error) => {}
            Err(_) => return Goes::Away,
        }
        self.leaves()
    }

    /// The next line, once the one before is answered.
    pub(super) fn next_line(&mut self) -> Next {
        if self.waits.is_some() { Next::Nothing } else { self.lines.next_line() }
    }

    /// It has asked something, and is not heard until it is answered.
    pub(super) fn asks(&mut self, id: Option<Id>) {
        self.waits = Some(id);
    }

    /// What the manager answers.
    pub(super) fn answered(&mut self, what: Answer) {
        if let Some(id) = self.waits.take() {
            self.answer(id, what);
        }
    }

    pub(super) fn answer(&mut self, id: Option<Id>, what: Answer) {
        self.say(&Said::Answer { id, what });
    }

    pub(super) fn say(&mut self, said: &Said) {
        if let Ok(bytes) = line(said) {
            self.unsent.extend(bytes);
        }
    }

    /// Tells a change, or counts it where there is no room.
    pub(super) fn note(&mut self, bytes: &[u8]) {
        if !self.watches {
            return;
        }
        if self.unsent.len() + bytes.len() > FULL {
            self.lost += 1;
        } else {
            self.own_up();
            self.unsent.extend(bytes);
        }
    }

    pub(super) fn lose(&mut self, count: u64) {
        if self.watches {
            self.lost += count;
        }
    }

    /// Says how many changes were not told.
    fn own_up(&mut self) {
        let lost = core::mem::take(&mut self.lost);
        if lost > 0 {
            self.say(&Said::Lost(lost));
        }
    }

    /// Sends what the socket takes.
    pub(super) fn send(&mut self) -> Goes {
        while !self.unsent.is_empty() {
            match self.stream.write(self.unsent.as_slices().0) {
                Ok(0) => return Goes::Away,
                Ok(sent) => drop(self.unsent.drain(..sent)),
                Err(error) if is_later(&error) => return Goes::On,
                Err(_) => return Goes::Away,
            }
        }
        self.own_up();
        self.leaves()
    }

    /// A client that has ended, and was told everything, goes.
    fn leaves(&self) -> Goes {
        let told = self.waits.is_none() && self.unsent.is_empty();
        if self.ended && told && !self.watches { Goes::Away } else { Goes::On }
    }
}

fn is_later(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

impl AsFd for Client {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.stream.as_fd()
    }
}
