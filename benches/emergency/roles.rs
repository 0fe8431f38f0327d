//! Who runs at which real-time priority: service above all, then the rescuer,
//! then the sensors. On a host that permits none of it, all run as they are.

use std::io;
use std::thread::{Builder, JoinHandle};

use faregate_runtime::realtime::{RealTime, Report};

#[derive(Clone, Copy, Debug)]
pub(crate) enum Role {
    Service,
    Rescuer,
    Sensors,
}

impl Role {
    pub(crate) const fn priority(self) -> u8 {
        match self {
            Self::Service => 60,
            Self::Rescuer => 50,
            Self::Sensors => 40,
        }
    }

    /// Takes the role, for the calling thread.
    pub(crate) fn take(self) -> Report {
        RealTime::request().fifo(self.priority()).apply()
    }

    /// Starts a thread in this role, for as long as the bench runs.
    pub(crate) fn start(
        self,
        name: &str,
        run: impl FnOnce() + Send + 'static,
    ) -> io::Result<JoinHandle<()>> {
        Builder::new().name(name.into()).spawn(move || {
            // What is refused to it was refused to the rescuer, which says so.
            let _ = self.take();
            run();
        })
    }
}
