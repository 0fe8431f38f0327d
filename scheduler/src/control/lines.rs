//! Lines out of bytes that come in any pieces.

/// Puts lines together. Holds at most one line, and what came with its end.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    bytes: Vec<u8>,
    /// How many of them are known to hold no line's end.
    searched: usize,
    /// The rest of a line that was too long is on its way.
    skipping: bool,
    longest: usize,
}

/// What there is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// A line, without its end.
    Line(Vec<u8>),
    /// A line that is too long. Told once; its rest is skipped.
    TooLong,
    /// No whole line.
    Nothing,
}

/// What an empty buffer keeps.
const KEPT: usize = 64 * 1024;

impl Lines {
    /// Without anything. No line may be longer than this, its end included.
    pub(super) fn new(longest: usize) -> Self {
        Self { bytes: Vec::new(), searched: 0, skipping: false, longest }
    }

    /// Takes further bytes.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// The next line. To be asked until there is nothing.
    ///
    /// # Timing
    /// Each byte is looked at once, however small the pieces.
    pub(super) fn next_line(&mut self) -> Next {
        loop {
            let end = self.bytes[self.searched..].iter().position(|&byte| byte == b'\n');
            let Some(end) = end.map(|end| self.searched + end) else { return self.unfinished() };
            let mut line: Vec<u8> = self.bytes.drain(..=end).collect();
            self.searched = 0;
            self.bytes.shrink_to(KEPT);
            if core::mem::take(&mut self.skipping) {
                continue;
            }
            if line.len() > self.longest {
                return Next::TooLong;
            }
            line.pop();
            return Next::Line(line);
        }
    }

    fn unfinished(&mut self) -> Next {
        self.searched = self.bytes.len();
        let too_long = self.bytes.len() >= self.longest;
        if self.skipping || too_long {
            self.bytes.clear();
            self.bytes.shrink_to(KEPT);
            self.searched = 0;
        }
        if too_long && !core::mem::replace(&mut self.skipping, true) {
            return Next::TooLong;
        }
        Next::Nothing
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const LONGEST: usize = 16;

    /// All that comes out of pieces.
    fn pieces<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> Vec<Next> {
        let mut lines = Lines::new(LONGEST);
        let mut all = Vec::new();
        for piece in pieces {
            lines.push(piece);
            loop {
                match lines.next_line() {
                    Next::Nothing => break,
                    next => all.push(next),
                }
            }
            assert!(lines.bytes.len() < LONGEST);
        }
        all
    }

    fn simply(bytes: &[u8]) -> Vec<Next> {
        let mut all: Vec<_> = bytes
            .split_inclusive(|&byte| byte == b'\n')
            .map(|line| match line.strip_suffix(b"\n") {
                _ if line.len() > LONGEST => Next::TooLong,
                Some(line) => Next::Line(line.into()),
                // So long already, and its end not there.
                None if line.len() == LONGEST => Next::TooLong,
                None => Next::Nothing,
            })
            .collect();
        all.retain(|next| *next != Next::Nothing);
        all
    }

    proptest! {
        #[test]
        fn lines_do_not_depend_on_the_pieces_in_which_they_come(
            bytes in prop::collection::vec(prop::sample::select(vec![b'a', b'b', b'\n']), 0..200),
            cuts in prop::collection::vec(0..200_usize, 0..20),
        ) {
            let mut cuts: Vec<_> = cuts.into_iter().map(|cut| cut.min(bytes.len())).collect();
            cuts.extend([0, bytes.len()]);
            cuts.sort_unstable();
            let cut = cuts.windows(2).map(|ends| &bytes[ends[0]..ends[1]]);
            prop_assert_eq!(pieces(cut), simply(&bytes));
        }

        #[test]
        fn a_long_line_is_told_once_and_the_next_one_is_read(
            length in LONGEST..100, piece in 1..40_usize,
        ) {
            let mut bytes = vec![b'x'; length];
            bytes.extend(b"\nnext\n");
            let expected = [Next::TooLong, Next::Line(b"next".into())];
            prop_assert_eq!(pieces(bytes.chunks(piece)), expected);
        }
    }
}
