//! The exit codes of the programs that talk to a manager.
//!
//! A script tells by them what it may do: try again, go on without, or give up.

use crate::{Error, RefusalKind};

/// What a program tells its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Exit {
    /// It was done.
    Done = 0,
    /// Something else went wrong: the text on standard error says what.
    Failed = 1,
    /// The program was called with the wrong words.
    Usage = 2,
    /// Refused for now: the tickets were taken, or are not valid. They come
    /// back in their turn.
    NotNow = 3,
    /// Refused by a rule: a limit, a window, an interlock.
    Limit = 4,
    /// Refused for good: no such gate, command or task, wrong arguments, not
    /// declared, not permitted, mistakes in a schedule.
    Never = 5,
    /// The device failed, or its gate is out of service.
    Faulted = 6,
    /// There is no port: not called by a task, or nobody listens.
    NoPort = 7,
    /// The attempt is over, or the manager has stopped.
    Over = 8,
    /// Too much is asked at a time.
    Busy = 9,
    /// Manager and client are of versions that do not understand each other.
    Version = 10,
}

impl Exit {
    /// Every code, with what it says: for a program's `--help`.
    pub const ALL: [(Self, &'static str); 11] = [
        (Self::Done, "done"),
        (Self::Failed, "something else went wrong"),
        (Self::Usage, "wrong usage"),
        (Self::NotNow, "refused for now: the tickets were taken or wait"),
        (Self::Limit, "refused by a limit, a window or an interlock"),
        (Self::Never, "refused for good: unknown, not declared, not permitted, or with mistakes"),
        (Self::Faulted, "the device failed, or its gate is out of service"),
        (Self::NoPort, "no port: not called by a task, or nobody listens"),
        (Self::Over, "the attempt is over, or the manager has stopped"),
        (Self::Busy, "too much is asked at a time"),
        (Self::Version, "manager and client do not understand each other"),
    ];

    /// The code.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl From<RefusalKind> for Exit {
    fn from(kind: RefusalKind) -> Self {
        use RefusalKind::*;
        match kind {
            Preempted | Waiting | Barred | SafeMode | Expired => Self::NotNow,
            Limit => Self::Limit,
            NotDeclared | UnknownGate | UnknownCommand | BadArguments | UnknownTask | Invalid
            | NotPermitted => Self::Never,
            Faulted => Self::Faulted,
            Over | Stopping => Self::Over,
            Busy => Self::Busy,
            Malformed | UnknownRequest => Self::Version,
            NotDone | Other => Self::Failed,
        }
    }
}

impl From<&Error> for Exit {
    fn from(error: &Error) -> Self {
        match error {
            Error::Refused(refused) => refused.kind.into(),
            Error::NoPort(_) => Self::NoPort,
            Error::Closed => Self::Over,
            Error::Version { .. } | Error::NotUnderstood(_) => Self::Version,
            Error::TooLong { .. } => Self::Never,
            Error::NoAnswer { .. } | Error::Io(_) => Self::Failed,
        }
    }
}

impl From<Exit> for std::process::ExitCode {
    fn from(exit: Exit) -> Self {
        exit.code().into()
    }
}
