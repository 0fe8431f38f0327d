//! The room in which a device works, and the mark on its door: what the soak
//! judges by.
//!
//! The device looks at the mark when a command begins and when it ends, without
//! any lock. The revoker changes the mark only while the room is said to be
//! empty: once when it has reached quiescence, and once before it lets the next
//! holder in. So a command that sees another holder's mark, nobody's, or two
//! different ones, began or was in progress after quiescence. Such a command is
//! *late*.
//!
//! | word | who writes | meaning |
//! |---|---|---|
//! | `mark` | the revoker | whose room it is, and how often that changed |
//! | `used` | the device | the mark under which the latest command began |
//! | `entered`, `left` | the device | commands begun, and ended |
//! | `late` | the device, the holders, the revoker | late commands |
//!
//! For commands that are one store see [`Stores`].

mod stores;

use std::hint::spin_loop;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::Thread;

pub(crate) use stores::Stores;

/// Whose room it is between quiescence and the next admission.
pub(crate) const NOBODY: u8 = 0;

/// The low bits of a mark are whose room it is; the others count.
const OWNER_BITS: u32 = 8;

/// A room, and what its device saw.
#[derive(Debug, Default)]
pub(crate) struct Room {
    mark: Mark,
    device: Device,
    pub(crate) stores: Stores,
    /// Who is woken when a command rings.
    bell: OnceLock<Thread>,
}

/// A word that shares its cache line with no other.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Mark(AtomicU64);

#[derive(Debug, Default)]
#[repr(align(128))]
struct Device {
    used: AtomicU64,
    entered: AtomicU64,
    left: AtomicU64,
    late: AtomicU64,
}

/// A command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Order {
    /// Which holder gives it, from 1.
    pub(crate) holder: u8,
    /// How long it takes.
    pub(crate) steps: u16,
    /// Whether it wakes the revoker in the midst of it.
    pub(crate) ring: bool,
    /// What it stores in the register, if that is all it does.
    pub(crate) word: Option<u32>,
}

impl Room {
    /// A room that lives as long as the program, as gates do.
    pub(crate) fn leaked() -> &'static Self {
        Box::leak(Box::default())
    }

    /// Carries out a command: for the device. Several may be in here at once,
    /// which is what a gate is to prevent.
    pub(crate) fn obey(&self, order: Order) {
        self.device.entered.fetch_add(1, Ordering::AcqRel);
        // SeqCst, as every access to the mark: what is missed here for want of
        // ordering would be missed in the gate's favour.
        let began = self.mark.0.load(Ordering::SeqCst);
        self.device.used.store(began, Ordering::Release);
        if order.ring {
            self.ring();
        }
        (0..order.steps).for_each(|_| spin_loop());
        if let Some(word) = order.word {
            self.stores.register.store(word, Ordering::SeqCst);
        }
        let ended = self.mark.0.load(Ordering::SeqCst);
        if owner(began) != order.holder || ended != began {
            self.note_late();
        }
        self.device.left.fetch_add(1, Ordering::Release);
    }

    /// Wakes the revoker.
    pub(crate) fn ring(&self) {
        if let Some(revoker) = self.bell.get() {
            revoker.unpark();
        }
    }

    /// Who is woken by commands that ring.
    pub(crate) fn set_bell(&self, revoker: Thread) {
        // A room has one revoker all its life.
        let _ = self.bell.set(revoker);
    }

    /// Nobody may be in here any more: for the revoker, once quiescent.
    pub(crate) fn close(&self) {
        self.stores.seal();
        self.change_mark(NOBODY);
    }

    /// From here on it is this holder's room.
    pub(crate) fn open_for(&self, holder: u8) {
        if !self.stores.are_as_sealed() {
            self.note_late();
        }
        self.change_mark(holder);
    }

    fn change_mark(&self, holder: u8) {
        // One thread writes the mark, so what it loads is what it stored.
        let count = (self.mark.0.load(Ordering::SeqCst) >> OWNER_BITS) + 1;
        self.mark.0.store(count << OWNER_BITS | u64::from(holder), Ordering::SeqCst);
    }

    /// Whose room it is.
    pub(crate) fn owner(&self) -> u8 {
        owner(self.mark.0.load(Ordering::SeqCst))
    }

    /// Whether its present owner has had a command admitted.
    pub(crate) fn is_used(&self) -> bool {
        self.device.used.load(Ordering::Acquire) == self.mark.0.load(Ordering::Relaxed)
            || self.stores.are_used_by(self.owner())
    }

    /// Whether a command is in progress. `true` was so at some instant during
    /// the call.
    pub(crate) fn is_occupied(&self) -> bool {
        // In this order: what had entered and has still not left is inside.
        let entered = self.device.entered.load(Ordering::Acquire);
        self.device.left.load(Ordering::Acquire) < entered || self.stores.are_tried(self.owner())
    }

    /// A command began or was in progress after quiescence.
    pub(crate) fn note_late(&self) {
        self.device.late.fetch_add(1, Ordering::Relaxed);
    }

    /// How many did.
    pub(crate) fn late(&self) -> u64 {
        self.device.late.load(Ordering::Relaxed)
    }

    /// How many commands the device was given, and did not only have stored.
    pub(crate) fn commands(&self) -> u64 {
        self.device.entered.load(Ordering::Relaxed)
    }
}

fn owner(mark: u64) -> u8 {
    mark.to_le_bytes()[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDER: Order = Order { holder: 1, steps: 0, ring: false, word: None };

    #[test]
    fn the_owners_command_is_not_late_and_uses_the_room() {
        let room = Room::default();
        room.open_for(1);
        assert!(!room.is_used());
        room.obey(ORDER);
        assert_eq!((room.is_used(), room.is_occupied(), room.late()), (true, false, 0));
    }

    #[test]
    fn a_command_that_begins_in_a_closed_room_or_anothers_is_late() {
        let room = Room::default();
        room.obey(ORDER);
        room.open_for(2);
        room.obey(ORDER);
        room.close();
        room.obey(ORDER);
        assert_eq!(room.late(), 3);
    }

    /// Changes hands while a command is in progress. `None`, where the host let
    /// the command end before.
    fn change_hands_in_a_command() -> Option<&'static Room> {
        let room = Room::leaked();
        room.open_for(1);
        let long = std::thread::spawn(|| room.obey(Order { steps: u16::MAX, ..ORDER }));
        while !(long.is_finished() || room.is_occupied() && room.is_used()) {
            spin_loop();
        }
        // Closed and opened for the same holder again: only the count tells.
        room.close();
        room.open_for(1);
        let in_time = room.is_occupied();
        long.join().unwrap();
        in_time.then_some(room)
    }

    #[test]
    fn a_command_in_progress_while_the_room_changes_hands_is_late() {
        let room = (0..1_000).find_map(|_| change_hands_in_a_command());
        let room = room.expect("the host lets two threads run at once, now and then");
        assert_eq!((room.is_occupied(), room.late()), (false, 1));
    }

    fn store(room: &Room, holder: u8, number: u32) {
        let word = Stores::word(holder, number);
        room.stores.register.store(word, Ordering::SeqCst);
        room.vouch(holder, word);
    }

    #[test]
    fn stores_within_a_tenure_are_not_late_and_use_the_room() {
        let room = Room::default();
        room.open_for(1);
        assert!(!room.is_used());
        store(&room, 1, 1);
        assert!(room.is_used());
        room.close();
        // The holder was kept from running between its store and its vouching.
        room.vouch(1, Stores::word(1, 1));
        room.open_for(2);
        room.vouch(1, Stores::word(1, 1));
        assert_eq!((room.is_used(), room.late()), (false, 0));
    }

    #[test]
    fn a_store_into_a_closed_room_is_late_even_if_its_holder_never_vouches() {
        let room = Room::default();
        room.open_for(1);
        store(&room, 1, 1);
        room.close();
        room.stores.register.store(Stores::word(1, 2), Ordering::SeqCst);
        room.open_for(1);
        assert_eq!(room.late(), 1);
    }

    #[test]
    fn a_store_into_anothers_room_is_late_even_if_it_is_overwritten() {
        let room = Room::default();
        room.open_for(1);
        store(&room, 1, 1);
        room.close();
        room.open_for(2);
        let late = Stores::word(1, 2);
        room.stores.register.store(late, Ordering::SeqCst);
        store(&room, 2, 1);
        room.vouch(1, late);
        assert_eq!(room.late(), 1);
    }
}
