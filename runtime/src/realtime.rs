//! Real-time rights for the calling thread: a scheduling priority, a CPU of its
//! own, memory that stays.
//!
//! What a host permits is the host's affair, and a container often permits
//! none of it. So nothing here fails: the [`Report`] says what was permitted
//! and what was refused, why, and what to do about it; the program decides
//! what it can fly with.
//!
//! ```
//! use faregate_runtime::realtime::RealTime;
//!
//! let report = RealTime::request().fifo(80).cpu(0).locked_memory().prefaulted_stack(64 * 1024).apply();
//! if !report.is_complete() {
//!     eprintln!("{report}");
//! }
//! ```

use std::fmt;
use std::io;

use faregate_tickets::lock::CurrentThread;

use crate::sys::Tid;

mod grant;

/// What a thread wants of the host. Only what is asked for is touched.
#[derive(Clone, Debug, Default)]
#[must_use = "nothing is asked of the host before `apply`"]
pub struct RealTime {
    fifo: Option<u8>,
    cpu: Option<usize>,
    locked_memory: bool,
    stack: Option<usize>,
}

impl RealTime {
    /// A request for nothing yet.
    pub fn request() -> Self {
        Self::default()
    }

    /// `SCHED_FIFO` with this priority, 1 to 99, larger first. (The scheduler's
    /// priority of a thread, which is not the priority of a ticket.)
    ///
    /// Threads that this one starts later are ordinary ones, unless they ask.
    pub fn fifo(mut self, priority: u8) -> Self {
        self.fifo = Some(priority);
        self
    }

    /// This CPU and no other. Threads that this one starts later inherit it.
    pub fn cpu(mut self, cpu: usize) -> Self {
        self.cpu = Some(cpu);
        self
    }

    /// All memory of the process stays in memory, what is mapped later
    /// included.
    ///
    /// Where the limit of locked memory is finite, later mappings count against
    /// it and fail when it is reached, new threads' stacks among them.
    pub fn locked_memory(mut self) -> Self {
        self.locked_memory = true;
        self
    }

    /// So many bytes of the thread's stack below the caller are touched now, so
    /// that their first use does not fault later.
    pub fn prefaulted_stack(mut self, bytes: usize) -> Self {
        self.stack = Some(bytes);
        self
    }

    /// Asks the host, for the calling thread, and reports each answer. A
    /// refusal keeps nothing else from being asked.
    ///
    /// The priority comes last, so that the slow part runs without it.
    pub fn apply(self) -> Report {
        // The lock of a gate asks for this once per thread: now, not then.
        Tid::tid();
        let wishes = [
            self.locked_memory.then_some(Wish::LockedMemory),
            self.stack.map(|bytes| Wish::PrefaultedStack { bytes }),
            self.cpu.map(Wish::Cpu),
            self.fifo.map(Wish::Fifo),
        ];
        Report { outcomes: wishes.into_iter().flatten().map(Outcome::of).collect() }
    }
}

/// One thing asked of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wish {
    /// All memory of the process stays in memory.
    LockedMemory,
    /// Part of the stack is touched beforehand.
    PrefaultedStack {
        /// How much of it.
        bytes: usize,
    },
    /// The thread runs on this CPU only.
    Cpu(usize),
    /// The thread has this `SCHED_FIFO` priority.
    Fifo(u8),
}

/// What came of a wish.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// It is so.
    Permitted(Wish),
    /// It is as it was before.
    Refused(Refusal),
}

/// A wish that was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Refusal {
    /// What was wished.
    pub wish: Wish,
    /// Why it was refused.
    pub reason: Reason,
}

/// Why a wish was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reason {
    /// The host said so.
    Host {
        /// In these terms.
        errno: i32,
    },
    /// The thread's stack does not reach so far.
    StackEnds {
        /// What could have been touched.
        available: usize,
    },
}

impl Outcome {
    fn of(wish: Wish) -> Self {
        match grant::grant(wish) {
            Ok(()) => Self::Permitted(wish),
            Err(reason) => Self::Refused(Refusal { wish, reason }),
        }
    }
}

impl Refusal {
    /// What the operator of the host, or the author of the program, can do.
    #[must_use]
    pub fn advice(&self) -> &'static str {
        match (self.wish, self.reason) {
            (_, Reason::StackEnds { .. }) => {
                "start the thread with a larger stack, or ask for less"
            }
            (Wish::Fifo(_), Reason::Host { errno: libc::EINVAL }) => {
                "ask for a priority from 1 to 99"
            }
            (Wish::Fifo(_), _) => {
                "give the process CAP_SYS_NICE, or a limit of real-time priority (`ulimit -r`) that reaches so far; \
                 where the kernel schedules groups in real time, also give its cgroup some cpu.rt_runtime_us"
            }
            (Wish::Cpu(_), _) => {
                "ask for a CPU that is online and in the cpuset of the process (`taskset -p`)"
            }
            (Wish::LockedMemory, _) => {
                "give the process CAP_IPC_LOCK, or a limit of locked memory (`ulimit -l`) above all that it maps"
            }
            (Wish::PrefaultedStack { .. }, _) => {
                "mount /proc, from which the extent of the stack is read"
            }
        }
    }
}

/// What the host permitted and what it refused, in the order of asking.
#[derive(Clone, Debug, PartialEq, Eq)]
#[must_use = "what was refused is said here and nowhere else"]
pub struct Report {
    outcomes: Vec<Outcome>,
}

impl Report {
    /// Whether everything asked for was permitted.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.refusals().next().is_none()
    }

    /// What came of each wish.
    #[must_use]
    pub fn outcomes(&self) -> &[Outcome] {
        &self.outcomes
    }

    /// The wishes that were refused.
    pub fn refusals(&self) -> impl Iterator<Item = &Refusal> {
        self.outcomes.iter().filter_map(|outcome| match outcome {
            Outcome::Permitted(_) => None,
            Outcome::Refused(refusal) => Some(refusal),
        })
    }
}

impl fmt::Display for Report {
    /// One line per wish.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (line, outcome) in self.outcomes.iter().enumerate() {
            if line > 0 {
                writeln!(f)?;
            }
            write!(f, "{outcome}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Permitted(wish) => write!(f, "{wish}: permitted"),
            Self::Refused(refusal) => write!(f, "{refusal}"),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: refused, {}; {}", self.wish, self.reason, self.advice())
    }
}

impl fmt::Display for Wish {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LockedMemory => write!(f, "locked memory"),
            Self::PrefaultedStack { bytes } => write!(f, "{bytes} bytes of stack beforehand"),
            Self::Cpu(cpu) => write!(f, "CPU {cpu}"),
            Self::Fifo(priority) => write!(f, "SCHED_FIFO priority {priority}"),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Host { errno } => write!(f, "{}", io::Error::from_raw_os_error(*errno)),
            Self::StackEnds { available } => write!(f, "only {available} bytes are left"),
        }
    }
}
