//! The journal keeps what it promises: what was committed survives the death of
//! the process, what was synced the loss of power, and nothing passes for
//! something else.

#[path = "journal/compaction.rs"]
mod compaction;
#[path = "journal/damage.rs"]
mod damage;
#[path = "journal/files.rs"]
mod files;
#[path = "journal/format.rs"]
mod format;
#[path = "journal/power.rs"]
mod power;
#[path = "journal/records.rs"]
mod records;
#[path = "journal/replay.rs"]
mod replay;
#[path = "journal/survival.rs"]
mod survival;
