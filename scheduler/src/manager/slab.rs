//! Places with numbers. One that is free is used again.
//!
//! In chunks, so that growing moves nothing: of 100 000 tasks in one vector,
//! the one that makes it grow would pay for the move of them all.

/// How many places a chunk has.
const CHUNK: usize = 64;

#[derive(Clone, Debug)]
pub(crate) struct Slab<T> {
    chunks: Vec<Vec<Option<T>>>,
    free: Vec<u32>,
}

impl<T> Default for Slab<T> {
    fn default() -> Self {
        Self { chunks: Vec::new(), free: Vec::new() }
    }
}

impl<T> Slab<T> {
    /// The number of the place where it is kept from now on.
    pub(crate) fn insert(&mut self, value: T) -> u32 {
        if let Some(number) = self.free.pop() {
            if let Some(place) = self.place(number) {
                *place = Some(value);
            }
            return number;
        }
        if self.chunks.last().is_none_or(|chunk| chunk.len() >= CHUNK) {
            self.chunks.push(Vec::with_capacity(CHUNK));
        }
        if let Some(chunk) = self.chunks.last_mut() {
            chunk.push(Some(value));
        }
        self.places().saturating_sub(1)
    }

    pub(crate) fn remove(&mut self, number: u32) -> Option<T> {
        let value = self.place(number)?.take()?;
        self.free.push(number);
        Some(value)
    }

    pub(crate) fn get(&self, number: u32) -> Option<&T> {
        let number = usize::try_from(number).ok()?;
        self.chunks.get(number / CHUNK)?.get(number % CHUNK)?.as_ref()
    }

    pub(crate) fn get_mut(&mut self, number: u32) -> Option<&mut T> {
        self.place(number)?.as_mut()
    }

    /// The numbers of all places, free ones among them, are less.
    pub(crate) fn places(&self) -> u32 {
        let last = self.chunks.last().map_or(0, Vec::len);
        let before = self.chunks.len().saturating_sub(1).saturating_mul(CHUNK);
        u32::try_from(before.saturating_add(last)).unwrap_or(u32::MAX)
    }

    fn place(&mut self, number: u32) -> Option<&mut Option<T>> {
        let number = usize::try_from(number).ok()?;
        self.chunks.get_mut(number / CHUNK)?.get_mut(number % CHUNK)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_is_free_is_used_again_and_nothing_else_moves() {
        let mut slab = Slab::default();
        let numbers: Vec<_> = (0..200).map(|value| slab.insert(value)).collect();
        assert_eq!(numbers, (0..200).collect::<Vec<_>>());
        assert_eq!(slab.remove(70), Some(70));
        assert_eq!(slab.get(70), None);
        assert_eq!(slab.remove(70), None);
        assert_eq!(slab.insert(1_000), 70);
        assert_eq!(slab.places(), 200);
        assert_eq!((slab.get(70), slab.get(199), slab.get(200)), (Some(&1_000), Some(&199), None));
    }
}
