//! How bytes lie in a file: a head, then frames that each say whether they are
//! what was written.
//!
//! | bytes of a frame | what |
//! |---|---|
//! | 0..4 | a mark by which frames are found behind damaged ones |
//! | 4..8 | how long the payload is |
//! | 8..16 | how much of this file was durable when the frame was written |
//! | 16..20 | CRC-32 over the file's identity, the frame's place, the bytes above and the payload |
//! | 20.. | the payload |
//!
//! **Durable Evidence.** A frame that cannot be read, with a readable one
//! behind it that says that this place was durable, is damage. Without such a
//! witness it is a write that was torn, and nobody was promised anything of it.
//! The last sync has no witness until something is written after it: bytes that
//! rot just there pass for torn ones.

/// How long a frame's head is.
pub(super) const HEAD: usize = 20;
/// How long a payload can be.
pub(super) const PAYLOAD_MAX: usize = 256 << 20;

const MARK: [u8; 4] = *b"\xF5tkt";

/// A frame that is what was written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<'a> {
    pub(super) payload: &'a [u8],
    /// How much of the file was durable when it was written.
    pub(super) durable: u64,
    /// Where the next frame begins.
    pub(super) end: usize,
}

/// Completes a frame whose payload stands behind [`HEAD`] bytes of room.
pub(super) fn seal(frame: &mut [u8], identity: u64, offset: u64, durable: u64) {
    let (head, payload) = frame.split_at_mut(HEAD);
    let length = u32::try_from(payload.len()).unwrap_or(u32::MAX);
    head[..4].copy_from_slice(&MARK);
    head[4..8].copy_from_slice(&length.to_le_bytes());
    head[8..16].copy_from_slice(&durable.to_le_bytes());
    let sum = checksum(identity, offset, &head[..16], payload);
    head[16..20].copy_from_slice(&sum.to_le_bytes());
}

/// The frame at this place, if it is whole and what was written.
pub(super) fn read(file: &[u8], identity: u64, offset: usize) -> Option<Frame<'_>> {
    let rest = file.get(offset..)?;
    let (head, rest) = rest.split_at_checked(HEAD)?;
    if head[..4] != MARK {
        return None;
    }
    let payload = rest.get(..usize::try_from(u32_at(head, 4)?).ok()?)?;
    let sum = checksum(identity, u64::try_from(offset).ok()?, &head[..16], payload);
    (u32_at(head, 16)? == sum).then_some(Frame {
        payload,
        durable: u64_at(head, 8)?,
        end: offset + HEAD + payload.len(),
    })
}

/// Whether a frame behind this place says that the place was durable.
pub(super) fn was_durable(file: &[u8], identity: u64, place: usize) -> bool {
    let mut from = place + 1;
    while let Some(at) = find_mark(file, from) {
        from = at + 1;
        if let Some(frame) = read(file, identity, at) {
            if usize::try_from(frame.durable).is_ok_and(|durable| durable > place) {
                return true;
            }
            from = frame.end;
        }
    }
    false
}

fn find_mark(file: &[u8], from: usize) -> Option<usize> {
    let rest = file.get(from..)?;
    rest.windows(MARK.len()).position(|bytes| bytes == MARK).map(|at| from + at)
}

/// The place is part of the sum so that an old frame is never taken for one
/// that belongs where it happens to lie.
fn checksum(identity: u64, offset: u64, head: &[u8], payload: &[u8]) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    sum.update(&identity.to_le_bytes());
    sum.update(&offset.to_le_bytes());
    sum.update(head);
    sum.update(payload);
    sum.finalize()
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?))
}
