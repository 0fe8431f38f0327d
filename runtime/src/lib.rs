//! What threads need of the operating system.
//!
//! A [`Broker`] is put together once, by a [`Builder`], and then served by a
//! thread of its own, which sleeps until something is due. Gates and agents
//! live as long as the program, so a [`Ticket`] can go to any thread. None of
//! them allocates after construction.
//!
//! Whoever waits for a ticket drives the hand-over at its own priority
//! meanwhile. What the host does not permit is reported in words, not passed
//! over: real-time priority in [`Broker::real_time_report`], locks with
//! priority inheritance as an error of [`Broker::builder`].
//!
//! # Example
//!
//! ```
//! # use faregate_tickets::Device;
//! # use faregate_tickets::amount::Milliwatts;
//! # use faregate_tickets::device::{Declaration, Effect, Profile};
//! # struct Heater(bool);
//! # impl Device for Heater {
//! #     type Command = bool;
//! #     type Response = ();
//! #     type Fault = ();
//! #     fn profile(&self) -> Profile {
//! #         Profile::new().drawing(Milliwatts::from_watts(8))
//! #     }
//! #     fn declare(on: &bool) -> Declaration {
//! #         let effect = if *on { Effect::on(Milliwatts::from_watts(8)) } else { Effect::Off };
//! #         Declaration { code: (*on).into(), wcet: Duration::from_millis(1), effect }
//! #     }
//! #     fn issue(&mut self, on: bool) -> Result<(), ()> {
//! #         self.0 = on;
//! #         Ok(())
//! #     }
//! #     fn safe(&mut self) -> Result<(), ()> {
//! #         self.issue(false)
//! #     }
//! # }
//! use faregate_agents::{Policy, Waiting};
//! use faregate_runtime::{Broker, NotValid};
//! use faregate_tickets::clock::Duration;
//! use faregate_tickets::id::Priority;
//!
//! let mut builder = Broker::builder()?;
//! let power = builder.agent(Policy::power_margin(Milliwatts::from_watts(10)))?;
//! let heater = builder.gate(power, "heater", Heater(false))?;
//! let broker = builder.real_time(80).start()?;
//! println!("{}", broker.real_time_report().unwrap_or_default());
//!
//! let engineering = broker.request(Priority::ENGINEERING, &heater)?;
//! broker.wait(&engineering, Duration::from_secs(1))?;
//! engineering.invoke(true)?;
//!
//! // Who is less important waits, and learns for whom.
//! let science = broker.request(Priority::SCIENCE, &heater)?;
//! let waited = broker.wait(&science, Duration::from_millis(10));
//! let (gate, by) = (heater.gate(), engineering.id());
//! assert_eq!(waited, Err(NotValid::TimedOut(Some(Waiting::Gate { gate, by }))));
//! drop(engineering);
//! broker.wait(&science, Duration::from_secs(1))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Modules
//!
//! | module | what |
//! |---|---|
//! | [`broker`] | the broker with its service thread; the types that a program names |
//! | [`host`] | the ports of a host, chosen together |
//! | [`clock`], [`contain`] | the monotonic clock; where a driver's panic ends |
//! | [`lanes`] | the flight recorder, drained into `tracing` |
//! | [`wake`] | wake-ups that do not block whoever rings |
//! | `realtime` | SCHED_FIFO, locked memory, one processor; on Linux |

pub mod broker;
pub mod clock;
pub mod contain;
pub mod host;
pub mod lanes;
#[cfg(target_os = "linux")]
pub mod realtime;
#[cfg(target_os = "linux")]
mod sys;
mod waiters;
pub mod wake;

pub use broker::{Broker, Builder, GateOptions, Handle, NotValid, StillHeld, Ticket};
pub use waiters::{TicketChange, Waiters};
