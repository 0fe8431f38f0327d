//! The compact form: a head, what postcard makes of the model, a checksum.
//!
//! | bytes | what |
//! |---|---|
//! | 0..8 | a mark that no text has |
//! | 8..10 | the version of everything behind it, little-endian |
//! | 10 | what it is: 1 a plan, 2 parameters, 3 a state, 4 a timed plan |
//! | 11..15 | how long the body is, little-endian |
//! | 15.. | the body |
//! | the last 4 | CRC-32 of all bytes before it, little-endian |
//!
//! **Never Guessed.** Bytes are read only if they are exactly what a writer of
//! this version writes: another version, a wrong sum, a byte more or less, and
//! a body that would be written differently are refused.

use core::fmt;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::file::{Document, VERSION};
use crate::parameters::Parameters;
use crate::plan::Plan;
use crate::state::State;
use crate::timed::TimedPlan;

const MARK: [u8; 8] = *b"\xF5plan\r\n\x1A";
const HEAD: usize = 15;
const SUM: usize = 4;

/// Something that has a compact form.
pub trait Compact: Serialize + DeserializeOwned {
    /// Which kind the head says that it is.
    const KIND: u8;
    /// What people call it.
    const NAME: &'static str;
}

macro_rules! compact {
    ($($of:ty, $kind:literal, $name:literal;)+) => {
        $(impl Compact for $of {
            const KIND: u8 = $kind;
            const NAME: &'static str = $name;
        })+

        /// What a kind of this number is called.
        fn name_of(kind: u8) -> &'static str {
            match kind {
                $($kind => $name,)+
                _ => "something else",
            }
        }
    };
}

compact! {
    Plan, 1, "a plan";
    Parameters, 2, "parameters";
    State, 3, "a state";
    TimedPlan, 4, "a timed plan";
}

/// Why bytes are not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotRead {
    /// They are not of this format.
    Other,
    /// They are of a version that is not known here.
    Version {
        /// Which one.
        found: u16,
    },
    /// They are something else.
    Kind {
        /// What they are.
        found: &'static str,
        /// What was wanted.
        wanted: &'static str,
    },
    /// They are not what was written.
    Damaged,
}

impl fmt::Display for NotRead {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Other => f.write_str("this is no binary file of a plan"),
            Self::Version { found } => {
                write!(f, "the file has version {found}, and {VERSION} alone is known here")
            }
            Self::Kind { found, wanted } => write!(f, "this is {found}, and not {wanted}"),
            Self::Damaged => f.write_str("the file is damaged: it is not what was written"),
        }
    }
}

impl core::error::Error for NotRead {}

/// Whether these bytes claim to be of this format.
#[must_use]
pub fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(&MARK)
}

/// The compact form.
#[must_use]
pub fn write<T: Compact>(value: &T) -> Vec<u8> {
    // Into memory, and of types that all have a length: this cannot fail.
    let body = postcard::to_stdvec(value).unwrap_or_default();
    let length = u32::try_from(body.len()).unwrap_or(u32::MAX);
    let mut bytes = Vec::with_capacity(HEAD + body.len() + SUM);
    bytes.extend_from_slice(&MARK);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.push(T::KIND);
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(&body);
    bytes.extend_from_slice(&crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// Reads the compact form.
///
/// # Errors
///
/// Why it is not read.
pub fn read<T: Compact>(bytes: &[u8]) -> Result<T, NotRead> {
    let (kind, body) = open(bytes)?;
    if kind != T::KIND {
        return Err(NotRead::Kind { found: name_of(kind), wanted: T::NAME });
    }
    let (value, rest) = postcard::take_from_bytes::<T>(body).map_err(|_| NotRead::Damaged)?;
    // Integers can be written longer than they need be.
    match rest.is_empty() && write(&value) == bytes {
        true => Ok(value),
        false => Err(NotRead::Damaged),
    }
}

/// Reads a document, whichever it is.
pub(super) fn document(bytes: &[u8]) -> Result<Document, NotRead> {
    match open(bytes)?.0 {
        Plan::KIND => read(bytes).map(Document::Plan),
        Parameters::KIND => read(bytes).map(Document::Parameters),
        State::KIND => read(bytes).map(Document::State),
        kind => Err(NotRead::Kind { found: name_of(kind), wanted: super::ROOTS }),
    }
}

/// What the bytes are, and their body.
fn open(bytes: &[u8]) -> Result<(u8, &[u8]), NotRead> {
    let rest = bytes.strip_prefix(&MARK).ok_or(NotRead::Other)?;
    let (found, _) = rest.split_first_chunk::<2>().ok_or(NotRead::Damaged)?;
    let found = u16::from_le_bytes(*found);
    if found != VERSION {
        return Err(NotRead::Version { found });
    }
    let (all, sum) = bytes.split_last_chunk::<SUM>().ok_or(NotRead::Damaged)?;
    let (head, body) = all.split_first_chunk::<HEAD>().ok_or(NotRead::Damaged)?;
    let [.., kind, a, b, c, d] = *head;
    let length = usize::try_from(u32::from_le_bytes([a, b, c, d])).ok();
    let whole = crc32fast::hash(all).to_le_bytes() == *sum && length == Some(body.len());
    if whole { Ok((kind, body)) } else { Err(NotRead::Damaged) }
}
