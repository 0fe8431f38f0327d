//! Commands that are one store: no code of the device runs, so the register is
//! what is judged by.
//!
//! Each store is a word of its own, with its holder's number. Quiescence makes
//! every earlier store visible, so what the register holds then is the latest
//! store of the tenure: the revoker notes it, as the *sealed* word of that
//! holder. A holder whose store was admitted *vouches* for it afterwards: unless
//! the room is its own at that moment, its store must be the sealed one. And
//! in a closed room the register does not change.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use super::{NOBODY, Room};

/// Holders are numbered from 1.
const HOLDERS: usize = 4;

#[derive(Debug, Default)]
#[repr(align(128))]
pub(crate) struct Stores {
    pub(crate) register: AtomicU32,
    /// What the register held when the room was closed: of each holder the
    /// latest, and of all.
    sealed: [AtomicU32; HOLDERS],
    latest_sealed: AtomicU32,
    /// Which holders are trying to store.
    trying: [AtomicBool; HOLDERS],
}

impl Stores {
    /// A holder's store with this number, which no other store looks like.
    pub(crate) fn word(holder: u8, number: u32) -> u32 {
        number << u8::BITS | u32::from(holder)
    }

    /// The revoker notes what the register holds.
    pub(super) fn seal(&self) {
        let word = self.register.load(Ordering::SeqCst);
        if let Some(sealed) = self.sealed.get(holder(word)) {
            sealed.store(word, Ordering::SeqCst);
        }
        self.latest_sealed.store(word, Ordering::SeqCst);
    }

    pub(super) fn are_as_sealed(&self) -> bool {
        self.register.load(Ordering::SeqCst) == self.latest_sealed.load(Ordering::SeqCst)
    }

    /// Whether this owner of the room has stored something since it was closed.
    pub(super) fn are_used_by(&self, owner: u8) -> bool {
        let word = self.register.load(Ordering::SeqCst);
        let fresh = word != self.latest_sealed.load(Ordering::SeqCst);
        fresh && owner != NOBODY && holder(word) == usize::from(owner)
    }

    /// The holder says that it is about to try a store, and that it has tried.
    pub(crate) fn set_trying(&self, holder: u8, trying: bool) {
        if let Some(tries) = self.trying.get(usize::from(holder)) {
            tries.store(trying, Ordering::Release);
        }
    }

    pub(super) fn are_tried(&self, owner: u8) -> bool {
        let tries = self.trying.get(usize::from(owner));
        tries.is_some_and(|tries| tries.load(Ordering::Acquire))
    }

    fn is_sealed(&self, word: u32) -> bool {
        let sealed = self.sealed.get(holder(word));
        sealed.is_some_and(|sealed| sealed.load(Ordering::SeqCst) == word)
    }
}

impl Room {
    /// The holder's latest store was admitted: it was in the holder's tenure.
    pub(crate) fn vouch(&self, holder: u8, word: u32) {
        // In this order: who sees that the room was closed sees what was sealed.
        if self.owner() != holder && !self.stores.is_sealed(word) {
            self.note_late();
        }
    }
}

fn holder(word: u32) -> usize {
    usize::from(word.to_le_bytes()[0])
}
