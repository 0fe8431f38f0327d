//! The result of a timeline: a value at each instant, in straight pieces, to
//! which an impact adds in about the root of the number of pieces.
//!
//! The pieces lie in chunks. A change of every value from some instant on
//! touches the pieces of one or two chunks, and of the others a common
//! addition alone. Each chunk knows bounds of its values, so a search for a
//! limit that is broken passes over most of them.

/// So many pieces in a chunk; twice as many are split.
const CHUNK: usize = 64;

/// Values in a straight line, over some instants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    /// Its first instant.
    pub(crate) from: i64,
    /// The first instant that is not in it.
    pub(crate) to: i64,
    /// The value at its first instant.
    pub(crate) value: i128,
    /// What each ms adds.
    pub(crate) slope: i128,
}

impl Piece {
    /// The value at an instant, of the line that it is part of.
    pub(crate) fn at(&self, at: i64) -> i128 {
        self.value + self.slope * i128::from(at - self.from)
    }

    /// The part between two instants; `None` where there is none.
    pub(crate) fn clip(&self, from: i64, to: i64) -> Option<Self> {
        let (first, end) = (self.from.max(from), self.to.min(to));
        (first < end).then(|| Self { from: first, to: end, value: self.at(first), ..*self })
    }

    /// The smallest and the largest value in it.
    pub(crate) fn bounds(&self) -> (i128, i128) {
        let (first, last) =
            (self.value, if self.slope == 0 { self.value } else { self.at(self.to - 1) });
        (first.min(last), first.max(last))
    }
}

/// What is added: `value` at the instant 0 of its own clock, and `slope` for
/// each ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Ramp {
    pub(crate) value: i128,
    pub(crate) slope: i128,
}

impl Ramp {
    fn at(self, at: i64) -> i128 {
        self.value + self.slope * i128::from(at)
    }
}

/// A value at each instant from a first one on.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    chunks: Vec<Chunk>,
}

/// Neighbouring pieces: never none.
#[derive(Clone, Debug)]
struct Chunk {
    pieces: Vec<Piece>,
    /// To be added to all of them; its clock is the time.
    shift: Ramp,
    /// Bounds of the values, `shift` not added.
    low: i128,
    high: i128,
}

impl Line {
    /// The same value from an instant to another that is never reached.
    pub(crate) fn new(from: i64, to: i64, value: i128) -> Self {
        let piece = Piece { from, to, value, slope: 0 };
        Self { chunks: vec![Chunk::of(vec![piece])] }
    }

    /// The first instant.
    pub(crate) fn begin(&self) -> i64 {
        self.chunks.first().map_or(0, Chunk::from)
    }

    /// The first instant that is not in it.
    pub(crate) fn end(&self) -> i64 {
        self.chunks.last().map_or(0, Chunk::to)
    }

    /// Adds a ramp whose clock begins at `zero` to all values in [from, to).
    pub(crate) fn add(&mut self, zero: i64, from: i64, to: i64, ramp: Ramp) {
        let (from, to) = (from.max(self.begin()), to.min(self.end()));
        if from >= to || ramp == Ramp::default() {
            return;
        }
        self.cut(from);
        self.cut(to);
        let absolute = Ramp { value: ramp.value - ramp.slope * i128::from(zero), ..ramp };
        let first = self.chunk_of(from);
        for chunk in &mut self.chunks[first..] {
            if chunk.from() >= to {
                break;
            }
            chunk.add(from, to, absolute);
        }
        self.mend(to);
        self.mend(from);
    }

    /// The pieces of [from, to), clipped to it, of chunks whose bounds are
    /// wanted.
    pub(crate) fn pieces(
        &self,
        from: i64,
        to: i64,
        wanted: impl Fn(i128, i128) -> bool,
    ) -> impl Iterator<Item = Piece> {
        let (from, to) = (from.max(self.begin()), to.min(self.end()));
        let first = self.chunk_of(from);
        let chunks = self.chunks[first..].iter().take_while(move |chunk| chunk.from() < to);
        let chunks = chunks.filter(move |chunk| {
            let (low, high) = chunk.bounds();
            wanted(low, high)
        });
        chunks.flat_map(move |chunk| {
            let skip = chunk.pieces.partition_point(|piece| piece.to <= from);
            let near = chunk.pieces[skip..].iter().take_while(move |piece| piece.from < to);
            near.filter_map(move |&piece| chunk.shifted(piece).clip(from, to))
        })
    }

    /// All pieces; two that are one straight line are one.
    pub(crate) fn all(&self) -> Vec<Piece> {
        let mut all: Vec<Piece> = Vec::new();
        for piece in self.pieces(i64::MIN, i64::MAX, |_, _| true) {
            match all.last_mut() {
                Some(last) if last.continues(&piece) => last.to = piece.to,
                _ => all.push(piece),
            }
        }
        all
    }

    /// Whether there is one piece alone.
    pub(crate) fn is_flat(&self) -> bool {
        matches!(self.chunks.as_slice(), [chunk] if chunk.pieces.len() == 1)
    }

    fn chunk_of(&self, at: i64) -> usize {
        self.chunks.partition_point(|chunk| chunk.from() <= at).saturating_sub(1)
    }

    /// Makes a piece begin at this instant.
    fn cut(&mut self, at: i64) {
        if at <= self.begin() || at >= self.end() {
            return;
        }
        let index = self.chunk_of(at);
        let chunk = &mut self.chunks[index];
        chunk.cut(at);
        if chunk.pieces.len() > 2 * CHUNK {
            let rest = chunk.split();
            self.chunks.insert(index + 1, rest);
        }
    }

    /// Joins the two pieces that meet at this instant, where they are one
    /// straight line: what is taken away again leaves nothing behind.
    fn mend(&mut self, at: i64) {
        if at <= self.begin() || at >= self.end() {
            return;
        }
        let index = self.chunk_of(at);
        let Ok(place) = self.chunks[index].pieces.binary_search_by_key(&at, |piece| piece.from)
        else {
            return;
        };
        let piece = self.chunks[index].shifted(self.chunks[index].pieces[place]);
        let before = if place == 0 { index - 1 } else { index };
        let chunk = &self.chunks[before];
        let last = if place == 0 { chunk.pieces.len() } else { place } - 1;
        if !chunk.shifted(chunk.pieces[last]).continues(&piece) {
            return;
        }
        self.chunks[before].pieces[last].to = piece.to;
        self.chunks[before].bound();
        self.chunks[index].pieces.remove(place);
        if self.chunks[index].pieces.is_empty() {
            self.chunks.remove(index);
        }
    }
}

impl Piece {
    /// Whether the next piece goes on where this one ends.
    fn continues(&self, next: &Self) -> bool {
        self.slope == next.slope && self.at(self.to) == next.value
    }
}

impl Chunk {
    fn of(pieces: Vec<Piece>) -> Self {
        let mut chunk = Self { pieces, shift: Ramp::default(), low: 0, high: 0 };
        chunk.bound();
        chunk
    }

    fn from(&self) -> i64 {
        self.pieces.first().map_or(0, |piece| piece.from)
    }

    fn to(&self) -> i64 {
        self.pieces.last().map_or(0, |piece| piece.to)
    }

    fn shifted(&self, piece: Piece) -> Piece {
        Piece {
            value: piece.value + self.shift.at(piece.from),
            slope: piece.slope + self.shift.slope,
            ..piece
        }
    }

    /// Bounds of all values. They are met where nothing with a slope was added
    /// to the whole chunk.
    fn bounds(&self) -> (i128, i128) {
        let (first, last) = (self.shift.at(self.from()), self.shift.at(self.to() - 1));
        (self.low + first.min(last), self.high + first.max(last))
    }

    fn bound(&mut self) {
        let bounds = self.pieces.iter().map(Piece::bounds);
        let all = bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        (self.low, self.high) = all.unwrap_or_default();
    }

    /// Adds to what lies in [from, to), where pieces begin.
    fn add(&mut self, from: i64, to: i64, ramp: Ramp) {
        if from <= self.from() && self.to() <= to {
            self.shift =
                Ramp { value: self.shift.value + ramp.value, slope: self.shift.slope + ramp.slope };
            return;
        }
        for piece in &mut self.pieces {
            if from <= piece.from && piece.to <= to {
                piece.value += ramp.at(piece.from);
                piece.slope += ramp.slope;
            }
        }
        self.bound();
    }

    fn cut(&mut self, at: i64) {
        let index = self.pieces.partition_point(|piece| piece.to <= at);
        let piece = self.pieces[index];
        if piece.from < at {
            self.pieces[index].to = at;
            self.pieces.insert(index + 1, Piece { from: at, value: piece.at(at), ..piece });
        }
    }

    /// Gives the second half away.
    fn split(&mut self) -> Self {
        let mut rest = Self::of(self.pieces.split_off(CHUNK));
        rest.shift = self.shift;
        self.bound();
        rest
    }
}

impl PartialEq for Line {
    /// By the values: chunks are nobody's business.
    fn eq(&self, other: &Self) -> bool {
        self.all() == other.all()
    }
}

impl Eq for Line {}

#[cfg(test)]
mod tests;
