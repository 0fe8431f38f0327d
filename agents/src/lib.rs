//! Ticket agents: who may command what, decided by policy.
//!
//! A [`Broker`] is all agents of a spacecraft, around one set of [`Books`].
//! Each agent has gates and a [`Policy`]. A request names gates and a priority.
//! It never blocks: its tickets may be waiting when they come, and become valid
//! in their turn, without being asked for again.
//!
//! What a ticket's device can draw is charged from the moment the ticket is
//! granted until a fresh measurement says that the device is off. A command
//! that turns it off credits nothing.
//!
//! Nothing happens by itself. [`Broker::service`] does what is due and answers
//! when to come again. Any thread may call it, several at a time; no step has
//! an owner. Nothing here allocates or starts a thread.
//!
//! # Example
//!
//! One gate, driven by hand on a clock whose hands the example moves.
//! `faregate-runtime` has the threads that a program would use instead.
//!
//! ```
//! use std::sync::atomic::{AtomicU64, Ordering};
//!
//! use faregate_agents::{Broker, Policy};
//! use faregate_tickets::amount::Milliwatts;
//! use faregate_tickets::clock::{Clock, Duration, Instant};
//! use faregate_tickets::device::{Declaration, Effect, Estimate, Power, Profile};
//! use faregate_tickets::id::Priority;
//! use faregate_tickets::lock::Locked;
//! use faregate_tickets::notify::NoNotify;
//! use faregate_tickets::recorder::NoLane;
//! use faregate_tickets::{Device, Gate};
//!
//! const DRAW: Milliwatts = Milliwatts::from_watts(8);
//! const SUPPLY: Milliwatts = Milliwatts::from_watts(10);
//!
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
//!         Profile::new().drawing(DRAW)
//!     }
//!     fn declare(on: &bool) -> Declaration {
//!         let effect = if *on { Effect::on(DRAW) } else { Effect::Off };
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
//! #[derive(Default)]
//! struct Hands(AtomicU64);
//!
//! impl Clock for Hands {
//!     fn now(&self) -> Instant {
//!         Instant::from_micros(self.0.load(Ordering::Relaxed))
//!     }
//! }
//!
//! type Strategy = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;
//! type Ports<'c> = (Strategy, &'c Hands, NoLane);
//!
//! let clock = Hands::default();
//! let mut gate = Gate::<_, Ports<'_>>::new(Heater { on: false }, &clock, NoLane);
//!
//! // Room for one gate, four tickets, and no sets of them.
//! let mut broker = Broker::<Ports<'_>, _, 1, 4, 0>::new(&clock, NoLane, NoNotify);
//! let power = broker.agent(Policy::power_margin(SUPPLY))?;
//! let heater = broker.register(power, gate.key())?;
//!
//! let science = broker.request(Priority::SCIENCE, &heater)?;
//! assert!(science.invoke(true).is_err(), "its hand-over has not begun");
//! broker.service();
//! assert_eq!(science.invoke(true), Ok(()));
//!
//! // Somebody more important takes the gate, and gives it back.
//! let emergency = broker.request(Priority::EMERGENCY, &heater)?;
//! let refusal = science.invoke(true).unwrap_err();
//! assert_eq!(refusal.to_string(), "the ticket is not valid: taken by ticket 2 at priority 255");
//! broker.service();
//! assert_eq!(emergency.invoke(false), Ok(()));
//! drop(emergency);
//! broker.service();
//! assert_eq!(science.invoke(true), Ok(()), "restored without asking");
//!
//! // Commanded off and given back, it is still charged. Seen off, it is not.
//! science.invoke(false).expect("a valid ticket");
//! drop(science);
//! broker.service();
//! assert_eq!(broker.margin(power), Some((SUPPLY, DRAW)));
//! clock.0.fetch_add(1_000, Ordering::Relaxed);
//! broker.observe(heater.gate(), Estimate { state: Power::Off, measured_at: clock.now() });
//! assert_eq!(broker.margin(power), Some((SUPPLY, Milliwatts::ZERO)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The parts
//!
//! | part | what |
//! |---|---|
//! | [`Broker`] | puts agents and gates together; requests, service, estimates |
//! | [`Handle`], [`Want`], [`Wants`] | what can be requested, one gate or several all or nothing |
//! | [`Policy`], [`Categories`] | what an agent's valid tickets must keep to, together |
//! | [`Supervisor`], [`Revoked`], [`Quiescent`] | revoking what is not one's own, and waiting until it is over |
//! | [`Redeclared`], [`NotRedeclared`] | another draw and other categories for a device without commands |
//! | [`RequestRefused`], [`Waiting`] | what can never be, and what a ticket waits for |
//! | [`Books`], [`Event`], [`Work`], [`Done`] | the step function beneath, which tests and model checkers drive |
//! | [`limits`] | the capacities that are the same for every mission |
#![no_std]
// No panic path: what cannot be is a typed error or a masked index.
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::unreachable, clippy::indexing_slicing)]
#![forbid(unsafe_code)]

mod books;
mod broker;
pub mod limits;
#[cfg(feature = "measure")]
#[doc(hidden)]
pub mod measure;
mod policy;
mod refusal;
mod roster;

pub use books::{
    Actions, Ask, Books, DeviceReport, DeviceState, Done, Event, List, Noted, Redeclared, Work,
};
pub use broker::{
    AgentId, Broker, Handle, NotQuiescent, NotYours, Quiescent, RegisterError, Revoked, Supervisor,
    Want, Wants,
};
pub use policy::{Categories, Policy};
pub use refusal::{Capacity, NotRedeclared, RequestRefused, Waiting};
