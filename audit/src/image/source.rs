//! Where an instruction comes from, by the debug information.

use std::fmt;
use std::sync::Arc;

use addr2line::{Context, LookupResult};
use anyhow::Result;
use gimli::{Dwarf, EndianArcSlice, RunTimeEndian};
use object::{Object as _, ObjectSection as _};

use super::path_of;

type Reader = EndianArcSlice<RunTimeEndian>;

/// The debug information of an object.
pub(super) struct Sources(Context<Reader>);

impl fmt::Debug for Sources {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sources").finish_non_exhaustive()
    }
}

/// One function of the source around an instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Its path, as [`path_of`] gives it.
    pub function: String,
    /// The line in it, with the file's name but not its folder's folder:
    /// messages do not depend on where the project was built.
    pub line: String,
}

impl Sources {
    pub(super) fn read(file: &object::File<'_>) -> Result<Self> {
        let endian =
            if file.is_little_endian() { RunTimeEndian::Little } else { RunTimeEndian::Big };
        let dwarf = Dwarf::load(|id| {
            let data = file
                .section_by_name(id.name())
                .and_then(|section| section.uncompressed_data().ok())
                .unwrap_or_default();
            Ok::<_, gimli::Error>(Reader::new(Arc::from(&*data), endian))
        })?;
        Ok(Self(Context::from_dwarf(dwarf)?))
    }

    pub(super) fn frames(&self, address: u64) -> Result<Vec<Frame>> {
        let mut iterator = match self.0.find_frames(address) {
            LookupResult::Output(found) => found?,
            LookupResult::Load { .. } => return Ok(Vec::new()),
        };
        let mut frames = Vec::new();
        while let Some(frame) = iterator.next()? {
            let Some(name) = frame.function else { continue };
            let line = frame.location.map_or_else(String::new, |at| {
                let file = short(at.file.unwrap_or("?"));
                format!("{file}:{}", at.line.unwrap_or(0))
            });
            frames.push(Frame { function: path_of(&name.raw_name()?), line });
        }
        frames.reverse();
        Ok(frames)
    }
}

/// A file's name with the folders from the crate on, as far as `src` tells.
fn short(file: &str) -> String {
    let parts: Vec<_> = file.split('/').collect();
    let src = parts.iter().rposition(|part| *part == "src").unwrap_or(1);
    parts.get(src.saturating_sub(1)..).unwrap_or(&parts).join("/")
}
