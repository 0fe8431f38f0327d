//! A disk in memory, whose power can be cut.
//!
//! Power that is lost takes with it what was not synced: each write by itself
//! may be there, or not, or in part, in any combination, and so may each name.
//! That is more than most file systems do to their users, and no less than
//! what they promise.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;

use parking_lot::Mutex;

use crate::journal::storage::{Boot, Storage, StoredFile};

/// A disk. Clones are the same disk.
#[derive(Clone, Debug, Default)]
pub struct Disk(Arc<Mutex<State>>);

/// Decides: a number below the given one, which is never 0.
pub type Choose<'a> = &'a mut dyn FnMut(usize) -> usize;

#[derive(Debug, Default)]
struct State {
    contents: Vec<Content>,
    names: Names,
    durable_names: Names,
    renamings: Vec<Naming>,
    boots: u128,
    /// Who opened a file before the last kill or cut has it no more.
    session: u64,
    /// How many operations are left before the power goes.
    until_cut: Option<u64>,
    room: Option<usize>,
    operations: u64,
}

type Names = BTreeMap<String, usize>;

#[derive(Clone, Debug)]
struct Naming {
    name: String,
    content: Option<usize>,
}

#[derive(Debug, Default)]
struct Content {
    durable: Vec<u8>,
    unsynced: Vec<Change>,
}

#[derive(Clone, Debug)]
enum Change {
    Write { at: usize, bytes: Vec<u8> },
    Cut(usize),
}

impl Disk {
    /// Loses power now, and has it again. What was not synced is chosen.
    pub fn cut_power(&self, choose: Choose<'_>) {
        let mut state = self.0.lock();
        for content in &mut state.contents {
            let changes = core::mem::take(&mut content.unsynced);
            for change in changes {
                content.survive(change, choose);
            }
        }
        for naming in core::mem::take(&mut state.renamings) {
            if choose(2) == 0 {
                apply(&mut state.durable_names, naming);
            }
        }
        state.names = state.durable_names.clone();
        state.boots += 1;
        state.session += 1;
        state.until_cut = None;
    }

    /// The process dies and the disk does not notice.
    pub fn kill_process(&self) {
        let mut state = self.0.lock();
        state.session += 1;
        state.until_cut = None;
    }

    /// After so many more operations every one fails, until
    /// [`cut_power`](Self::cut_power) or [`kill_process`](Self::kill_process).
    pub fn fail_after(&self, operations: u64) {
        self.0.lock().until_cut = Some(operations);
    }

    /// Has room for so many bytes in all files together; none: for any number.
    pub fn set_room(&self, room: Option<usize>) {
        self.0.lock().room = room;
    }

    /// How many operations there were.
    #[must_use]
    pub fn operations(&self) -> u64 {
        self.0.lock().operations
    }

    /// Changes what stands in a file, as a disk does that rots.
    ///
    /// # Errors
    ///
    /// When there is no such file.
    pub fn rot(&self, name: &str, change: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        let mut state = self.0.lock();
        let index = state.find(name)?;
        let mut bytes = state.contents[index].present();
        change(&mut bytes);
        state.contents[index] = Content { durable: bytes, unsynced: Vec::new() };
        Ok(())
    }
}

impl State {
    fn find(&self, name: &str) -> io::Result<usize> {
        self.names.get(name).copied().ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    /// Counts an operation that changes something.
    fn operate(&mut self) -> io::Result<()> {
        if let Some(left) = &mut self.until_cut {
            *left = left.checked_sub(1).ok_or_else(|| io::Error::other("the power is off"))?;
        }
        self.operations += 1;
        Ok(())
    }

    fn name(&mut self, name: &str, content: Option<usize>) {
        let naming = Naming { name: name.to_owned(), content };
        apply(&mut self.names, naming.clone());
        self.renamings.push(naming);
    }

    fn used(&self) -> usize {
        self.names.values().map(|index| self.contents[*index].present().len()).sum()
    }
}

fn apply(names: &mut Names, naming: Naming) {
    match naming.content {
        Some(content) => drop(names.insert(naming.name, content)),
        None => drop(names.remove(&naming.name)),
    }
}

impl Content {
    fn present(&self) -> Vec<u8> {
        let mut bytes = self.durable.clone();
        self.unsynced.iter().for_each(|change| change.apply(&mut bytes));
        bytes
    }

    /// A change that was not synced, when power is lost: it is there, or not,
    /// or a part of it.
    fn survive(&mut self, change: Change, choose: Choose<'_>) {
        match (choose(3), change) {
            (0, change) => change.apply(&mut self.durable),
            (1, Change::Write { at, mut bytes }) => {
                bytes.truncate(choose(bytes.len() + 1));
                Change::Write { at, bytes }.apply(&mut self.durable);
            }
            _ => {}
        }
    }
}

impl Change {
    /// Bytes before a write that never came are zero.
    fn apply(&self, file: &mut Vec<u8>) {
        match self {
            Self::Cut(length) => file.truncate(*length),
            Self::Write { at, bytes } => {
                let end = at + bytes.len();
                if file.len() < end {
                    file.resize(end, 0);
                }
                file[*at..end].copy_from_slice(bytes);
            }
        }
    }
}

impl Storage for Disk {
    fn names(&self) -> io::Result<Vec<String>> {
        Ok(self.0.lock().names.keys().cloned().collect())
    }

    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let state = self.0.lock();
        Ok(state.contents[state.find(name)?].present())
    }

    fn create(&self, name: &str) -> io::Result<Box<dyn StoredFile>> {
        let mut state = self.0.lock();
        state.operate()?;
        state.contents.push(Content::default());
        let content = state.contents.len() - 1;
        state.name(name, Some(content));
        Ok(self.handle(&state, content, 0))
    }

    fn append(&self, name: &str, keep: u64) -> io::Result<Box<dyn StoredFile>> {
        let (mut file, length) = {
            let state = self.0.lock();
            let content = state.find(name)?;
            let length = state.contents[content].present().len();
            (self.handle(&state, content, length), u64::try_from(length).unwrap_or(u64::MAX))
        };
        if keep != length {
            file.cut(keep)?;
        }
        Ok(file)
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        let mut state = self.0.lock();
        state.find(name)?;
        state.operate()?;
        state.name(name, None);
        Ok(())
    }

    fn sync_names(&self) -> io::Result<()> {
        let mut state = self.0.lock();
        state.operate()?;
        state.renamings.clear();
        state.durable_names = state.names.clone();
        Ok(())
    }

    fn boot(&self) -> Boot {
        Boot::new(self.0.lock().boots.to_be_bytes())
    }
}

impl Disk {
    fn handle(&self, state: &State, content: usize, end: usize) -> Box<dyn StoredFile> {
        Box::new(Handle { disk: self.clone(), session: state.session, content, end })
    }
}

/// An open file.
#[derive(Debug)]
struct Handle {
    disk: Disk,
    session: u64,
    content: usize,
    end: usize,
}

impl Handle {
    fn with<T>(&self, act: impl FnOnce(&mut State) -> io::Result<T>) -> io::Result<T> {
        let mut state = self.disk.0.lock();
        if state.session != self.session {
            return Err(io::Error::other("whoever opened this file is dead"));
        }
        act(&mut state)
    }

    /// What was written when power went may be there, like anything not synced.
    fn change(&self, change: Change) -> io::Result<()> {
        self.with(|state| {
            let operated = state.operate();
            state.contents[self.content].unsynced.push(change);
            operated
        })
    }
}

impl StoredFile for Handle {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let room =
            self.with(|state| Ok(state.room.map(|room| room.saturating_sub(state.used()))))?;
        let fits = room.unwrap_or(bytes.len()).min(bytes.len());
        self.change(Change::Write { at: self.end, bytes: bytes[..fits].to_vec() })?;
        self.end += fits;
        if fits < bytes.len() { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
    }

    fn cut(&mut self, keep: u64) -> io::Result<()> {
        let keep = usize::try_from(keep).map_err(io::Error::other)?;
        self.change(Change::Cut(keep))?;
        self.end = keep;
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        self.with(|state| {
            state.operate()?;
            let content = &mut state.contents[self.content];
            content.durable = content.present();
            content.unsynced.clear();
            Ok(())
        })
    }
}
