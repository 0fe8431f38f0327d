//! The controls: what is usual, and known to be wrong. The soak must see it.

use std::hint::spin_loop;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use faregate::prelude::Refusal;
use faregate_devices_sim::Dice;
use parking_lot::Mutex;

use crate::room::{Order, Room};
use crate::subject::{Orders, Outcome, Pass, Subject};

/// How a flag guards a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flagged {
    /// The paper's: the holder looks at its flag, then commands.
    Bare,
    /// The same, and the command is one store, when it has been composed.
    BareStore,
    /// The same with a lock around the command. The revoker passes through it,
    /// but the flag is looked at before.
    OutsideTheLock,
}

/// A device behind flags, one for each of two holders.
pub(crate) struct Flags {
    kind: Flagged,
    rooms: [&'static Room; 1],
    flags: [Arc<AtomicBool>; 2],
    lock: Arc<Mutex<()>>,
    tenant: usize,
}

impl Flags {
    pub(crate) fn new(kind: Flagged) -> Self {
        let room = Room::leaked();
        room.open_for(1);
        let flags = [true, false].map(|valid| Arc::new(AtomicBool::new(valid)));
        Self { kind, rooms: [room], flags, lock: Arc::default(), tenant: 0 }
    }
}

impl Subject for Flags {
    type Pass = FlagPass;

    fn orders(&self) -> Orders {
        match self.kind {
            Flagged::Bare | Flagged::OutsideTheLock => Orders::Steps,
            Flagged::BareStore => Orders::ComposedStores,
        }
    }

    fn rooms(&self) -> &[&'static Room] {
        &self.rooms
    }

    fn hand_out(&mut self) -> Vec<FlagPass> {
        let flags = (1..).zip(&self.flags);
        let pass = |(holder, flag): (u8, &Arc<AtomicBool>)| FlagPass {
            holder,
            kind: self.kind,
            flag: Arc::clone(flag),
            lock: (self.kind == Flagged::OutsideTheLock).then(|| Arc::clone(&self.lock)),
            room: self.rooms[0],
        };
        flags.map(pass).collect()
    }

    fn aim(&mut self, _: &mut Dice) -> Outcome<u32> {
        Ok(1)
    }

    fn revoke(&mut self) -> Outcome<()> {
        self.flags[self.tenant].store(false, Ordering::SeqCst);
        Ok(())
    }

    fn quiesce(&mut self) -> Outcome<()> {
        if self.kind == Flagged::OutsideTheLock {
            drop(self.lock.lock());
        }
        Ok(())
    }

    fn next(&mut self, _: usize, dice: &mut Dice) -> u8 {
        self.tenant = dice.index(self.flags.len());
        u8::try_from(self.tenant + 1).unwrap_or(u8::MAX)
    }

    fn admit(&mut self) -> Outcome<()> {
        self.flags[self.tenant].store(true, Ordering::SeqCst);
        Ok(())
    }
}

/// A holder's flag, and the device itself.
pub(crate) struct FlagPass {
    holder: u8,
    kind: Flagged,
    flag: Arc<AtomicBool>,
    lock: Option<Arc<Mutex<()>>>,
    room: &'static Room,
}

impl Pass for FlagPass {
    fn holder(&self) -> u8 {
        self.holder
    }

    fn room(&self) -> &'static Room {
        self.room
    }

    fn invoke(&self, order: Order) -> Result<(), Option<Refusal>> {
        if !self.flag.load(Ordering::SeqCst) {
            return Err(None);
        }
        let _inside = self.lock.as_ref().map(|lock| lock.lock());
        match self.kind {
            Flagged::Bare | Flagged::OutsideTheLock => self.room.obey(order),
            Flagged::BareStore => self.compose_and_store(order),
        }
        Ok(())
    }
}

impl FlagPass {
    fn compose_and_store(&self, order: Order) {
        if order.ring {
            self.room.ring();
        }
        (0..order.steps).for_each(|_| spin_loop());
        if let Some(word) = order.word {
            self.room.stores.register.store(word, Ordering::SeqCst);
        }
    }
}
