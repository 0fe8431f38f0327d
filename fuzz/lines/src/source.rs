//! Where in a program the lines of its source begin.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use gimli::{AttributeValue, DwarfSections, EndianSlice, LineRow, LittleEndian, Unit};
use object::{Object as _, ObjectSection as _, SectionKind};

type Slice<'a> = EndianSlice<'a, LittleEndian>;

/// The lines that begin at each address.
pub(crate) type Places = BTreeMap<u64, BTreeSet<(PathBuf, u64)>>;

/// The places of all lines of these files.
pub(crate) fn places(program: &Path, looked_at: &dyn Fn(&Path) -> bool) -> Result<Places> {
    let bytes =
        std::fs::read(program).with_context(|| format!("no program {}", program.display()))?;
    let object = object::File::parse(bytes.as_slice())?;
    let load = |id: gimli::SectionId| -> Result<Cow<'_, [u8]>> {
        let section = object.section_by_name(id.name());
        Ok(section.map(|section| section.uncompressed_data()).transpose()?.unwrap_or_default())
    };
    let sections = DwarfSections::load(load)?;
    let dwarf = sections.borrow(|section| EndianSlice::new(section, LittleEndian));
    let mut places = Places::new();
    let mut units = dwarf.units();
    while let Some(header) = units.next()? {
        let unit = dwarf.unit(header)?;
        of_unit(&dwarf, &unit, looked_at, &mut places)?;
    }
    // The linker leaves the lines of what it removed at addresses from 0.
    let code = object.sections().filter(|section| section.kind() == SectionKind::Text);
    let code: Vec<_> = code.map(|one| one.address()..one.address() + one.size()).collect();
    places.retain(|address, _| code.iter().any(|one| one.contains(address)));
    Ok(places)
}

fn of_unit<'a>(
    dwarf: &gimli::Dwarf<Slice<'a>>,
    unit: &Unit<Slice<'a>>,
    looked_at: &dyn Fn(&Path) -> bool,
    places: &mut Places,
) -> Result<()> {
    let Some(program) = unit.line_program.clone() else { return Ok(()) };
    let mut rows = program.rows();
    let mut known: BTreeMap<u64, Option<PathBuf>> = BTreeMap::new();
    while let Some((header, row)) = rows.next_row()? {
        let Some(line) = line_of(row) else { continue };
        let file = match known.get(&row.file_index()) {
            Some(file) => file.clone(),
            None => {
                let file = path(dwarf, unit, header, row)?.filter(|file| looked_at(file));
                known.insert(row.file_index(), file.clone());
                file
            }
        };
        if let Some(file) = file {
            places.entry(row.address()).or_default().insert((file, line));
        }
    }
    Ok(())
}

/// A line that begins here.
fn line_of(row: &LineRow) -> Option<u64> {
    let begins = row.is_stmt() && !row.end_sequence();
    row.line().filter(|_| begins).map(|line| line.get())
}

fn path<'a>(
    dwarf: &gimli::Dwarf<Slice<'a>>,
    unit: &Unit<Slice<'a>>,
    header: &gimli::LineProgramHeader<Slice<'a>>,
    row: &LineRow,
) -> Result<Option<PathBuf>> {
    let Some(file) = row.file(header) else { return Ok(None) };
    let text = |value: AttributeValue<Slice<'a>>| -> Result<String> {
        Ok(dwarf.attr_string(unit, value)?.to_string_lossy().into_owned())
    };
    let mut path = PathBuf::new();
    if let Some(directory) = &unit.comp_dir {
        path.push(directory.to_string_lossy().as_ref());
    }
    if let Some(directory) = file.directory(header) {
        path.push(text(directory)?);
    }
    path.push(text(file.path_name())?);
    Ok(Some(path.components().collect()))
}
