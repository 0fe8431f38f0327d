//! Gates, tickets and validity functions: the mechanism, without any policy.
//!
//! A driver is moved into its [`Gate`] and is reached through a [`Ticket`] of
//! that gate alone. A gate admits one ticket at a time, its *tenant*.
//!
//! A ticket is valid while its gate has it as tenant and three epochs are the
//! ones it was made valid under: its own, its agent's, its broker's. To revoke
//! one ticket or all of them is one increment. It waits for nobody, and takes
//! as long for one ticket as for all.
//!
//! A refused command has not reached its device, and the [refusal](refusal)
//! says why. A command that was admitted before a revocation may still be in
//! progress after it; whoever passes through the gate has waited for it.
//!
//! Nothing here allocates, starts a thread, or reads a clock that it was not
//! given. The only unsafe code is the priority-inheriting lock, behind the
//! feature `linux`.
//!
//! # Example
//!
//! A gate and its key, as an agent uses them. Programs have
//! `faregate-agents` do this, and decide who is admitted.
//!
#![cfg_attr(feature = "lock-api", doc = "```")]
#![cfg_attr(not(feature = "lock-api"), doc = "```ignore")]
//! use faregate_tickets::amount::Milliwatts;
//! use faregate_tickets::clock::{Clock, Duration, Instant};
//! use faregate_tickets::device::{Declaration, Effect, Profile};
//! use faregate_tickets::gate::Admission;
//! use faregate_tickets::id::{GateId, TicketId};
//! use faregate_tickets::lock::Locked;
//! use faregate_tickets::recorder::{NoLane, Unrecorded};
//! use faregate_tickets::scope::Scope;
//! use faregate_tickets::standing::{Stamp, Standing, Why};
//! use faregate_tickets::ticket::{Holder, Issuer, Seat};
//! use faregate_tickets::validity::Validity;
//! use faregate_tickets::{Device, Gate};
//!
//! /// A heater of 8 W.
//! struct Heater {
//!     on: bool,
//! }
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
//!         self.on = on;
//!         Ok(())
//!     }
//!     fn safe(&mut self) -> Result<(), ()> {
//!         self.issue(false)
//!     }
//! }
//!
//! /// A clock that stands still.
//! struct Stopped;
//!
//! impl Clock for Stopped {
//!     fn now(&self) -> Instant {
//!         Instant::START
//!     }
//! }
//!
//! /// Takes tickets back, and keeps no books.
//! struct Nobody;
//!
//! impl Issuer for Nobody {
//!     fn relinquish(&self, _: &Seat<'_>, _: Unrecorded, _: Holder) {}
//! }
//!
//! type Ports = (Locked<parking_lot::RawMutex, parking_lot::RawThreadId>, Stopped, NoLane);
//!
//! let mut gate = Gate::<_, Ports>::new(Heater { on: false }, Stopped, NoLane);
//! let (key, handle) = gate.key().split();
//!
//! // Where the ticket's validity is decided.
//! let (agent, broker, standing) = (Scope::new(), Scope::new(), Standing::new());
//! let id = TicketId { seat: 0, serial: 1 };
//! standing.seat(id.serial, 1);
//! let seat = Seat { id, gate: GateId(0), standing: &standing, agent: &agent, broker: &broker };
//! let ticket = key.ticket(handle, seat, &Nobody).expect("the handle is this gate's");
//! let refusal = ticket.invoke(true).unwrap_err();
//! assert_eq!(refusal.to_string(), "the ticket is not valid: not granted yet");
//!
//! // The epochs are read before the decision, and stamped when it is carried out.
//! let stamp = Stamp { own: standing.epoch_seen(), broker: broker.read().epoch };
//! let admission = Admission {
//!     serial: id.serial,
//!     tenure: 0,
//!     agent: agent.read().epoch,
//!     validity: Validity::always(),
//!     stamp: Some((&standing, stamp)),
//! };
//! let patience = Duration::from_millis(4);
//! assert_eq!(key.admit(admission, patience), Ok(1));
//! assert_eq!(ticket.invoke(true), Ok(()));
//!
//! // From here no command is admitted. Once the gate is vacated, none is in
//! // progress either, and the device can be made safe.
//! standing.revoke(Why::SupplyFell);
//! assert!(ticket.invoke(true).is_err());
//! let vacated = key.vacate(1, patience).expect("no command hangs");
//! assert!(vacated.may_be_on);
//! key.safe(vacated.tenure, 1, patience).expect("no command hangs");
//! ```
//!
//! # Modules
//!
//! | module | what |
//! |---|---|
//! | [`gate`] | gates, their keys, and the steps of a hand-over |
//! | [`ticket`] | tickets, and to whom they go back |
//! | [`standing`], [`scope`] | the epochs of a grant; of an agent or a broker |
//! | [`validity`] | the closed library of bounded functions that every command asks |
//! | [`telemetry`], [`interlock`] | what validity functions look at beside their ticket |
//! | [`refusal`], [`fault`] | why a command was not issued; why a gate is closed |
//! | [`platform`] | the ports of a gate, chosen together |
//! | [`device`], [`lock`], [`clock`], [`recorder`], [`notify`] | the ports |
//! | [`amount`], [`id`] | exact amounts; priorities and identities |
#![no_std]
// No panic path: what cannot be is a typed error or a masked index.
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::unreachable, clippy::indexing_slicing)]

pub mod amount;
pub mod clock;
pub mod device;
pub mod fault;
pub mod gate;
pub mod id;
pub mod interlock;
pub mod lock;
pub mod notify;
pub mod platform;
pub mod recorder;
pub mod refusal;
pub mod scope;
pub mod standing;
mod sync;
pub mod telemetry;
pub mod ticket;
pub mod validity;

pub use device::Device;
pub use gate::Gate;
pub use platform::{Containment, Platform};
pub use ticket::Ticket;
