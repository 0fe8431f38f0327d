//! Messages: one JSON document each, with a limit.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::{RefusalKind, Refused};

pub mod command;
pub mod control;

/// A number that the asker chooses, so that it knows the answer.
pub type Id = u64;

/// What somebody asks: `{"id": 7, "ask": ...}`. Without an id there is no
/// answer, unless it is not understood.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked<A> {
    /// Its number.
    #[serde(default = "Option::default", skip_serializing_if = "Option::is_none")]
    pub id: Option<Id>,
    /// What.
    pub ask: A,
}

/// Enough of a message to answer it, where the rest is not known here.
#[derive(Deserialize)]
struct Envelope {
    #[serde(default)]
    id: Option<Id>,
    ask: serde_json::Value,
}

/// A message that is not understood.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// Its number, if it has one.
    pub id: Option<Id>,
    /// What is wrong with it: [`RefusalKind::UnknownRequest`] if it has the form
    /// of one, and [`RefusalKind::Malformed`] if not.
    pub why: Refused,
}

/// Reads what somebody asks.
///
/// # Errors
/// With what is wrong, and whether it is a message at all. A field that is not
/// known is an error: what it was to change would be left out without a word.
pub fn parse<A: DeserializeOwned>(bytes: &[u8]) -> Result<Asked<A>, Unreadable> {
    serde_json::from_slice(bytes).map_err(|error| unreadable(bytes, &error))
}

#[cold]
fn unreadable(bytes: &[u8], error: &serde_json::Error) -> Unreadable {
    match serde_json::from_slice::<Envelope>(bytes) {
        Ok(Envelope { id, ask }) => Unreadable {
            id,
            why: Refused::new(
                RefusalKind::UnknownRequest,
                format!("{} is not understood: {error}", name_of(&ask)),
            ),
        },
        Err(error) => Unreadable {
            id: None,
            why: Refused::new(RefusalKind::Malformed, format!("no message: {error}")),
        },
    }
}

/// What an ask calls itself, cut to what a line bears.
fn name_of(ask: &serde_json::Value) -> String {
    let name = match ask {
        serde_json::Value::String(name) => Some(name),
        serde_json::Value::Object(fields) => fields.keys().next(),
        _ => None,
    };
    name.map_or_else(|| "what is asked".into(), |name| name.chars().take(40).collect())
}

/// The bytes of a message, its line's end included.
///
/// # Errors
/// [`serde_json::Error`]: none of this crate's messages meets it.
pub fn line(message: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec(message)?;
    bytes.push(b'\n');
    Ok(bytes)
}
