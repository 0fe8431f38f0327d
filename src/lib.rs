//! Commands that cannot be issued without a valid ticket, and tickets that are
//! revoked in constant time.
//!
//! A *device* has commands. Its driver is moved behind a *gate*. A thread of
//! control reaches the commands only through a *ticket*, which a *ticket agent*
//! grants by priority, power margin, conflict categories and budgets, and takes
//! away again when somebody more important needs what it stands for. The idea is
//! Erann Gat's ("Hard-real-time Resource Management for Autonomous Spacecraft",
//! IEEE Aerospace 2000).
//!
//! 1. **No Bypass.** Safe code has no way to a driver but a ticket.
//! 2. **Closed Door.** After a revocation no command is admitted; one that was
//!    admitted before is over at quiescence, which can be waited for.
//! 3. **Open Door.** A valid ticket's command is issued: nobody else can make it
//!    fail.
//! 4. **Constant Revoke.** Revoking one ticket or all of them is one increment;
//!    nobody can delay it.
//! 5. **Highest First.** Who has what is one greedy walk down one total order.
//! 6. **Margin Kept.** What may be on is charged until it is freshly seen off.
//! 7. **Bounded Hand-over.** Its longest time is computed from declared times.
//! 8. **Restoration.** Whoever was pre-empted has its ticket back without asking.
//! 9. **Source Death.** A holder that dies loses its tickets, and its devices
//!    are made safe.
//! 10. **Every Refusal Explains Itself,** with fields that are true.
//!
//! # Example
//!
//! ```
//! use faregate::prelude::*;
//!
//! struct Heater(bool);
//!
//! impl Device for Heater {
//!     type Command = bool;
//!     type Response = ();
//!     type Fault = ();
//!
//!     fn profile(&self) -> Profile {
//!         Profile::new().drawing(Milliwatts::from_watts(8))
//!     }
//!     fn declare(on: &bool) -> Declaration {
//!         let effect = if *on { Effect::on(Milliwatts::from_watts(8)) } else { Effect::Off };
//!         Declaration { code: (*on).into(), wcet: Duration::from_millis(1), effect }
//!     }
//!     fn issue(&mut self, on: bool) -> Result<(), ()> {
//!         self.0 = on;
//!         Ok(())
//!     }
//!     fn safe(&mut self) -> Result<(), ()> {
//!         self.issue(false)
//!     }
//! }
//!
//! let mut builder = Broker::builder()?;
//! let power = builder.agent(Policy::power_margin(Milliwatts::from_watts(10)))?;
//! let heater = builder.gate(power, "heater", Heater(false))?;
//! let broker = builder.start()?;
//!
//! let mine = broker.request(Priority::SCIENCE, &heater)?;
//! broker.wait(&mine, Duration::from_secs(1))?;
//! mine.invoke(true)?;
//!
//! let more_important = broker.request(Priority::EMERGENCY, &heater)?;
//! let refusal = mine.invoke(true).unwrap_err();
//! assert_eq!(refusal.to_string(), "the ticket is not valid: taken by ticket 2 at priority 255");
//!
//! drop(more_important);
//! broker.wait(&mine, Duration::from_secs(1))?;
//! mine.invoke(true)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The map
//!
//! | crate | what it is |
//! |---|---|
//! | [`tickets`] | gates, tickets, validity functions, ports; `no_std`, no policy |
//! | [`agents`] | books, policies, the broker of all agents; `no_std`, no threads |
//! | [`runtime`] | service thread, wake-ups, clock, flight recorder, real-time rights |
//! | `scheduler` (a feature) | the schedule manager: tasks that are dispatched on tickets |

pub use faregate_agents as agents;
pub use faregate_runtime as runtime;
#[cfg(feature = "scheduler")]
pub use faregate_scheduler as scheduler;
pub use faregate_tickets as tickets;

/// What a program that embeds tickets names.
pub mod prelude {
    pub use faregate_agents::{
        AgentId, Categories, NotYours, Policy, RequestRefused, Supervisor, Waiting,
    };
    pub use faregate_runtime::{Broker, GateOptions, Handle, NotValid, Ticket};
    pub use faregate_tickets::Device;
    pub use faregate_tickets::amount::{Microjoules, Milligrams, MilligramsPerSecond, Milliwatts};
    pub use faregate_tickets::clock::{Clock, Duration, Instant};
    pub use faregate_tickets::device::{
        Declaration, Effect, Estimate, Power, Profile, WhenOrphaned,
    };
    pub use faregate_tickets::id::{GateId, HolderId, Priority, TicketId};
    pub use faregate_tickets::interlock::{Interlock, Side};
    pub use faregate_tickets::refusal::{InvokeError, Refusal};
    pub use faregate_tickets::standing::Why;
    pub use faregate_tickets::telemetry::{Channel, Mode, Modes, Telemetry};
    pub use faregate_tickets::validity::{Function, Validity};
}

/// The README's example is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
