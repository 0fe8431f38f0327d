//! Loom models: every order in which threads can meet, and every value that
//! memory may show them, up to a bound on pre-emptions.
//!
//! One model for each guarantee that concurrency can break. It drives the
//! production gates and broker, claims one thing, prints its executions, and
//! has a floor under them: a model that explores nothing looks green. Each is
//! trusted because a *mutant*, one broken line of production code, makes the
//! named claim fail. `ci/loom.sh` runs both.
#![cfg(loom)]

#[path = "loom/bars.rs"]
mod bars;
#[path = "loom/doors.rs"]
mod doors;
#[path = "loom/flight.rs"]
mod flight;
#[path = "loom/hand_over.rs"]
mod hand_over;
#[path = "loom/lamp.rs"]
mod lamp;
#[path = "loom/model.rs"]
mod model;
#[path = "loom/safe_mode.rs"]
mod safe_mode;
#[path = "loom/sets.rs"]
mod sets;
#[path = "loom/shared.rs"]
mod shared;
#[path = "loom/source_death.rs"]
mod source_death;
#[path = "loom/stage.rs"]
mod stage;
#[path = "loom/ways.rs"]
mod ways;
