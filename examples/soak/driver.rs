//! The drivers behind the gates: they do what they are told in their room.

use std::fmt::Debug;
use std::sync::atomic::AtomicU32;

use faregate::prelude::*;

use crate::room::{Order, Room};
use crate::subject::Orders;

/// Longer than any host keeps a thread from running: no gate becomes faulted
/// because the host is under load.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// A driver that can be soaked.
pub(crate) trait Driver: Device<Command = Order, Response = (), Fault = ()> + Debug {
    /// What its holders command.
    const ORDERS: Orders;

    fn new(room: &'static Room) -> Self;
}

/// A driver whose commands run in its room.
#[derive(Debug)]
pub(crate) struct Worker(&'static Room);

/// A driver most of whose commands are one store.
#[derive(Debug)]
pub(crate) struct Register(&'static Room);

fn profile() -> Profile {
    let mut profile = Profile::new();
    profile.longest_command = PATIENCE;
    profile.longest_safing = PATIENCE;
    profile
}

const DECLARED: Declaration = Declaration { code: 1, wcet: PATIENCE, effect: Effect::Unchanged };

impl Driver for Worker {
    const ORDERS: Orders = Orders::Steps;

    fn new(room: &'static Room) -> Self {
        Self(room)
    }
}

impl Device for Worker {
    type Command = Order;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        profile()
    }

    fn declare(_: &Order) -> Declaration {
        DECLARED
    }

    fn issue(&mut self, order: Order) -> Result<(), ()> {
        self.0.obey(order);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        Ok(())
    }
}

impl Driver for Register {
    const ORDERS: Orders = Orders::Stores;

    fn new(room: &'static Room) -> Self {
        Self(room)
    }
}

impl Device for Register {
    type Command = Order;
    type Response = ();
    type Fault = ();

    fn profile(&self) -> Profile {
        profile()
    }

    fn declare(_: &Order) -> Declaration {
        DECLARED
    }

    fn issue(&mut self, order: Order) -> Result<(), ()> {
        self.0.obey(order);
        Ok(())
    }

    fn safe(&mut self) -> Result<(), ()> {
        Ok(())
    }

    fn register(&self) -> Option<&'static AtomicU32> {
        Some(&self.0.stores.register)
    }

    fn word(order: &Order) -> Option<(u32, ())> {
        order.word.map(|word| (word, ()))
    }
}
