//! The command port, from a task's side.

use std::io::IoSliceMut;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::time::Duration;

use rustix::io::Errno;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, ReturnFlags, SendFlags, SocketType,
    recvmsg, send, sockopt,
};

use crate::wire::command::{Answer, Ask, MAX_MESSAGE, Notice, PORT, Said};
use crate::wire::{Asked, Id, line};
use crate::{Error, PROTOCOL};

/// The command port of the task that this process belongs to.
///
/// It is a connection of its own: other processes of the task, and other values
/// of this type, do not disturb it. A thread that commands beside another one
/// makes its own with [`another`](Self::another).
#[derive(Debug)]
pub struct CommandPort {
    inherited: OwnedFd,
    connection: OwnedFd,
    last: Id,
    timeout: Option<Duration>,
}

/// What a device answered to a command.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reply {
    /// Empty where it says nothing.
    pub text: String,
}

impl CommandPort {
    /// The port that this process inherited: `FAREGATE_PORT` is its number.
    ///
    /// # Errors
    /// [`Error::NoPort`] where there is none: the process was not started by a
    /// schedule manager, or its number now means another file.
    /// [`Error::Closed`] if the attempt is over. [`Error::Refused`] if the task
    /// has too many connections.
    pub fn from_env() -> Result<Self, Error> {
        let number = std::env::var(PORT).map_err(|_| {
            Error::NoPort(format!(
                "{PORT} is not set: commands are for processes that a schedule manager started"
            ))
        })?;
        let number: i32 = number.trim().parse().map_err(|_| {
            Error::NoPort(format!("{PORT} is {number:?}, and should be a file descriptor's number"))
        })?;
        let inherited = crate::sys::duplicate(number).map_err(|_| not_a_port(number))?;
        if sockopt::socket_type(&inherited) != Ok(SocketType::SEQPACKET) {
            return Err(not_a_port(number));
        }
        Self::over(inherited)
    }

    /// A port over a socket that was come by in another way.
    ///
    /// # Errors
    /// As [`from_env`](Self::from_env).
    pub fn over(inherited: OwnedFd) -> Result<Self, Error> {
        tell(inherited.as_fd(), Some(0), Ask::Open)?;
        let connection = opened(inherited.as_fd())?;
        Ok(Self { inherited, connection, last: 0, timeout: None })
    }

    /// A connection beside this one, for another thread.
    ///
    /// # Errors
    /// As [`from_env`](Self::from_env).
    pub fn another(&self) -> Result<Self, Error> {
        Self::over(self.inherited.try_clone()?)
    }

    /// How long to wait for an answer; none: as long as it takes, which is at
    /// first so. The manager limits how long a command takes.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn set_timeout(&mut self, timeout: Option<Duration>) -> Result<(), Error> {
        sockopt::set_socket_timeout(&self.connection, sockopt::Timeout::Recv, timeout)?;
        self.timeout = timeout;
        Ok(())
    }

    /// Issues a command under the task's ticket.
    ///
    /// # Timing
    /// Returns when the device has taken the command, or with the refusal.
    ///
    /// # Errors
    /// [`Error::Refused`], with who took the ticket or which rule says no.
    ///
    /// # After revocation
    /// Refused, and says by whom. The port stays: the same call succeeds when
    /// the ticket is valid again.
    pub fn command(
        &mut self,
        gate: &str,
        command: &str,
        arguments: &[&str],
    ) -> Result<Reply, Error> {
        let answer = self.ask(Ask::Command {
            gate: gate.into(),
            command: command.into(),
            arguments: arguments.iter().map(|&argument| argument.into()).collect(),
        })?;
        match answer {
            Answer::Done { reply } => Ok(Reply { text: reply }),
            Answer::Refused(why) => Err(why.into()),
            Answer::Opened { .. } => Err(Error::NotUnderstood("a connection was opened".into())),
        }
    }

    /// Says that the task is alive, where a heartbeat is agreed. Waits for no
    /// answer.
    ///
    /// # Errors
    /// [`Error::Closed`] if the attempt is over.
    pub fn heartbeat(&mut self) -> Result<(), Error> {
        tell(self.connection.as_fd(), None, Ask::Heartbeat)
    }

    /// What the manager tells the task from now on. Ask for it early: what was
    /// told before is not repeated.
    ///
    /// # Errors
    /// As [`from_env`](Self::from_env).
    pub fn notices(&self) -> Result<Notices, Error> {
        let mut port = self.another()?;
        match port.ask(Ask::Notices)? {
            Answer::Refused(why) => Err(why.into()),
            _ => Ok(Notices { connection: port.connection }),
        }
    }

    fn ask(&mut self, ask: Ask) -> Result<Answer, Error> {
        self.last += 1;
        tell(self.connection.as_fd(), Some(self.last), ask)?;
        loop {
            match self.hear()? {
                Said::Answer { id, what } if id.is_none_or(|id| id == self.last) => {
                    return Ok(what);
                }
                // An answer that came after its timeout.
                Said::Answer { .. } | Said::Notice(_) => {}
            }
        }
    }

    fn hear(&self) -> Result<Said, Error> {
        match receive(self.connection.as_fd()) {
            Err(Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => {
                Err(Error::NoAnswer { within: self.timeout.unwrap_or_default() })
            }
            other => Ok(other?.0),
        }
    }
}

/// What the manager tells a task, one after the other.
#[derive(Debug)]
pub struct Notices {
    connection: OwnedFd,
}

impl Notices {
    /// Waits for the next one.
    ///
    /// # Errors
    /// [`Error::Closed`] when the attempt is over.
    pub fn wait(&mut self) -> Result<Notice, Error> {
        loop {
            if let Said::Notice(notice) = receive(self.connection.as_fd())?.0 {
                return Ok(notice);
            }
        }
    }
}

impl AsFd for Notices {
    /// To be polled: readable when a notice is there.
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.connection.as_fd()
    }
}

fn not_a_port(number: i32) -> Error {
    Error::NoPort(format!(
        "{PORT} is {number}, and that is no command port: the shell or a program may have used \
         the number for another file, or not passed it on"
    ))
}

fn tell(socket: BorrowedFd<'_>, id: Option<Id>, ask: Ask) -> Result<(), Error> {
    let message = line(&Asked { id, ask }).map_err(std::io::Error::from)?;
    if message.len() > MAX_MESSAGE {
        return Err(Error::TooLong { length: message.len(), limit: MAX_MESSAGE });
    }
    loop {
        match send(socket, &message, SendFlags::NOSIGNAL) {
            Ok(_) => return Ok(()),
            Err(Errno::INTR) => {}
            Err(Errno::PIPE | Errno::CONNRESET) => return Err(Error::Closed),
            Err(error) => return Err(error.into()),
        }
    }
}

/// The next connection that comes over the inherited socket. Others wait there,
/// too, and it is all the same which of them gets which.
fn opened(inherited: BorrowedFd<'_>) -> Result<OwnedFd, Error> {
    loop {
        match receive(inherited)? {
            (
                Said::Answer { what: Answer::Opened { protocol: PROTOCOL }, .. },
                Some(connection),
            ) => {
                return Ok(connection);
            }
            (Said::Answer { what: Answer::Opened { protocol }, .. }, _) => {
                return Err(Error::Version { theirs: protocol });
            }
            (Said::Answer { what: Answer::Refused(why), .. }, _) => return Err(why.into()),
            // Meant for somebody who did not wait for it.
            _ => {}
        }
    }
}

/// The next message, and the file descriptor that came with it.
fn receive(socket: BorrowedFd<'_>) -> Result<(Said, Option<OwnedFd>), Error> {
    let mut bytes = [0; MAX_MESSAGE];
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut passed = RecvAncillaryBuffer::new(&mut space);
    let received = loop {
        let into = &mut [IoSliceMut::new(&mut bytes)];
        match recvmsg(socket, into, &mut passed, RecvFlags::CMSG_CLOEXEC) {
            Err(Errno::INTR) => {}
            Err(Errno::CONNRESET) => return Err(Error::Closed),
            other => break other?,
        }
    };
    if received.bytes == 0 {
        return Err(Error::Closed);
    }
    if received.flags.contains(ReturnFlags::TRUNC) {
        return Err(Error::NotUnderstood(format!("longer than {MAX_MESSAGE} bytes")));
    }
    let descriptor = passed.drain().find_map(|message| match message {
        RecvAncillaryMessage::ScmRights(mut descriptors) => descriptors.next(),
        _ => None,
    });
    let said = serde_json::from_slice(&bytes[..received.bytes])
        .map_err(|error| Error::NotUnderstood(error.to_string()))?;
    Ok((said, descriptor))
}
