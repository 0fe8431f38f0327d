//! Our end of one socket: never blocks, and is closed once, for one reason.

use core::fmt;
use std::io::IoSlice;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use faregate_client::wire::command::{Answer, MAX_MESSAGE, Said};
use faregate_client::wire::{Id, line};
use rustix::io::Errno;
use rustix::net::{
    AddressFamily, RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags, Shutdown,
    SocketFlags, SocketType, recv, send, sendmsg, shutdown, socketpair,
};

use crate::manager::Attempt;
use crate::port::counts::Counting;

/// Why a connection was closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WhyClosed {
    /// The other side closed it.
    Peer,
    /// What came is no message.
    Garbage,
    /// What came is longer than a message may be.
    TooLong,
    /// Its answers were not read, and its buffer is full.
    Unread,
    /// The attempt is over.
    AttemptOver,
}

impl fmt::Display for WhyClosed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Peer => "the other side closed it",
            Self::Garbage => "what came is no message",
            Self::TooLong => "what came is longer than a message may be",
            Self::Unread => "its answers were not read",
            Self::AttemptOver => "the attempt is over",
        })
    }
}

/// A connection, for the thread that reads it and the one that answers.
#[derive(Debug)]
pub(super) struct Connection {
    socket: OwnedFd,
    attempt: Attempt,
    closed: AtomicBool,
    counts: Arc<Counting>,
}

/// What a read found.
pub(super) enum Received {
    /// A message of this length.
    Message(usize),
    /// Nothing, at the moment.
    Nothing,
    /// It is over.
    Closed(WhyClosed),
}

/// Two ends of a new connection: ours, and the other side's.
pub(super) fn pair(
    attempt: Attempt,
    counts: &Arc<Counting>,
) -> rustix::io::Result<(Connection, OwnedFd)> {
    let (ours, theirs) =
        socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None)?;
    // Ours alone: a task's program need not know of sockets that do not block.
    rustix::io::ioctl_fionbio(&ours, true)?;
    let counts = Arc::clone(counts);
    Ok((Connection { socket: ours, attempt, closed: AtomicBool::new(false), counts }, theirs))
}

impl Connection {
    pub(super) fn receive(&self, bytes: &mut [u8; MAX_MESSAGE]) -> Received {
        // With TRUNC the length is the message's own, read or not.
        match recv(&self.socket, &mut bytes[..], RecvFlags::TRUNC) {
            Ok((_, 0)) | Err(Errno::CONNRESET | Errno::PIPE) => Received::Closed(WhyClosed::Peer),
            Ok((_, length)) if length > MAX_MESSAGE => Received::Closed(WhyClosed::TooLong),
            Ok((_, length)) => Received::Message(length),
            Err(Errno::AGAIN | Errno::INTR) => Received::Nothing,
            Err(_) => Received::Closed(WhyClosed::Peer),
        }
    }

    pub(super) fn answer(&self, id: Option<Id>, what: Answer) {
        self.say(&Said::Answer { id, what });
    }

    /// Says something, or closes the connection if there is no room: who does
    /// not read has no claim on our memory.
    pub(super) fn say(&self, said: &Said) {
        let Some(bytes) = fitting(said) else { return self.close(WhyClosed::Unread) };
        match send(&self.socket, &bytes, SendFlags::NOSIGNAL | SendFlags::DONTWAIT) {
            Ok(_) => {}
            Err(Errno::PIPE | Errno::CONNRESET) => self.close(WhyClosed::Peer),
            Err(_) => self.close(WhyClosed::Unread),
        }
    }

    /// Answers with the other end of a new connection.
    pub(super) fn pass(&self, id: Option<Id>, end: BorrowedFd<'_>) {
        let what = Answer::Opened { protocol: faregate_client::PROTOCOL };
        let Some(bytes) = fitting(&Said::Answer { id, what }) else { return };
        let ends = [end];
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut passed = SendAncillaryBuffer::new(&mut space);
        let fits = passed.push(SendAncillaryMessage::ScmRights(&ends));
        debug_assert!(fits, "the space is for one descriptor");
        let flags = SendFlags::NOSIGNAL | SendFlags::DONTWAIT;
        if sendmsg(&self.socket, &[IoSlice::new(&bytes)], &mut passed, flags).is_err() {
            self.close(WhyClosed::Unread);
        }
    }

    /// Closes it for both directions, even where a child that has not called
    /// `exec` yet has a copy of our end. Only the first reason counts.
    pub(super) fn close(&self, why: WhyClosed) {
        if self.closed.swap(true, Relaxed) {
            return;
        }
        self.counts.closed(why);
        if matches!(why, WhyClosed::Garbage | WhyClosed::TooLong | WhyClosed::Unread) {
            tracing::warn!(target: "faregate", attempt = %self.attempt, "a command port's connection is closed: {why}");
        }
        // It fails where the other side is gone already: as good.
        let _ = shutdown(&self.socket, Shutdown::Both);
    }
}

impl AsFd for Connection {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

/// The bytes of what is said. What a device answers can be of any length: an
/// answer that is too long is cut, and ends in an ellipsis.
fn fitting(said: &Said) -> Option<Vec<u8>> {
    let bytes = line(said).ok()?;
    if bytes.len() <= MAX_MESSAGE {
        return Some(bytes);
    }
    let mut said = said.clone();
    shorten(&mut said);
    line(&said).ok().filter(|bytes| bytes.len() <= MAX_MESSAGE)
}

/// Escapes make a character six bytes long at most.
const WHOLE: usize = MAX_MESSAGE / 6 - 64;

fn shorten(said: &mut Said) {
    if let Said::Answer { what, .. } = said {
        match what {
            Answer::Done { reply } => cut(reply),
            Answer::Refused(why) => {
                cut(&mut why.reason);
                why.taker = None;
                why.problems.clear();
            }
            Answer::Opened { .. } => {}
        }
    }
}

fn cut(text: &mut String) {
    if text.len() > WHOLE {
        text.truncate(text.floor_char_boundary(WHOLE));
        text.push('…');
    }
}
