//! A linked object: its functions by address, and what its debug information
//! says of an instruction.

mod names;
mod source;

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};
use object::{
    Architecture, Object as _, ObjectKind, ObjectSection as _, ObjectSymbol as _, RelocationTarget,
    SectionKind, SymbolKind,
};

pub use self::names::{Role, matches, path_of, role_of};
pub use self::source::Frame;
use self::source::Sources;
use crate::analysis::Analyses;
use crate::code::{Instruction, Target};
use crate::isa::Isa;

/// A linked object, read.
#[derive(Debug)]
pub struct Image {
    /// What its instructions are.
    pub isa: Isa,
    /// What `rustc` wrote into it about itself.
    pub compiler: String,
    functions: BTreeMap<u64, Function>,
    slots: BTreeMap<u64, Target>,
    code: Vec<Code>,
    sources: Sources,
    /// What has been found out about its functions.
    pub(crate) analyses: Analyses,
}

/// A function, under all names that the linker gave to its address.
#[derive(Clone, Debug)]
pub struct Function {
    /// Where it begins.
    pub start: u64,
    /// Where the next thing begins.
    pub end: u64,
    /// As in the symbol table.
    pub names: Vec<String>,
}

/// A piece of a section with instructions in it: what is between two pieces is
/// data.
#[derive(Debug)]
struct Code {
    start: u64,
    bytes: Vec<u8>,
}

impl Image {
    /// Reads the object at `path`.
    ///
    /// # Errors
    /// Where it is not a linked ELF object of a known instruction set, with
    /// symbols and debug information.
    pub fn read(path: &Path) -> Result<Self> {
        let data =
            std::fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
        Self::parse(&data).with_context(|| format!("{} cannot be audited", path.display()))
    }

    fn parse(data: &[u8]) -> Result<Self> {
        let file = object::File::parse(data).context("it is no ELF object")?;
        let isa = match file.architecture() {
            Architecture::X86_64 => Isa::X86_64,
            Architecture::Arm => Isa::Thumb,
            other => bail!("the audit does not know the instructions of {other:?}"),
        };
        ensure!(
            matches!(file.kind(), ObjectKind::Dynamic | ObjectKind::Executable),
            "it is not linked: its calls lead nowhere yet"
        );
        ensure!(
            file.symbols().next().is_some(),
            "it has no symbol table: build with strip = false"
        );
        Ok(Self {
            isa,
            compiler: compiler(&file)?,
            functions: functions(&file),
            slots: slots(&file),
            code: code(&file, isa)?,
            sources: Sources::read(&file)?,
            analyses: Analyses::default(),
        })
    }

    /// The function that begins at `address`.
    pub fn function(&self, address: u64) -> Option<&Function> {
        self.functions.get(&address)
    }

    /// The function that `address` is in.
    pub fn function_around(&self, address: u64) -> Option<&Function> {
        let (_, function) = self.functions.range(..=address).next_back()?;
        (address < function.end).then_some(function)
    }

    /// The functions of that name: a symbol's, or a path without hash and
    /// generic arguments.
    pub fn named(&self, name: &str) -> Vec<&Function> {
        let exact = |function: &&Function| function.names.iter().any(|symbol| symbol == name);
        let by_symbol: Vec<_> = self.functions.values().filter(exact).collect();
        if !by_symbol.is_empty() {
            return by_symbol;
        }
        let by_path =
            |function: &&Function| function.names.iter().any(|symbol| path_of(symbol) == name);
        self.functions.values().filter(by_path).collect()
    }

    /// The instructions of the function.
    ///
    /// # Errors
    /// Where its bytes are no instructions.
    pub fn decode(&self, function: &Function) -> Result<Vec<Instruction>> {
        let mut instructions = Vec::new();
        for code in &self.code {
            let end = code.start + code.bytes.len() as u64;
            let (from, to) = (function.start.max(code.start), function.end.min(end));
            if from < to {
                let within = |address: u64| usize::try_from(address - code.start);
                let bytes = code.bytes.get(within(from)?..within(to)?).unwrap_or_default();
                instructions.extend(self.isa.decode(bytes, from, &self.slots)?);
            }
        }
        Ok(instructions)
    }

    /// The functions of the source that the instruction stands in, the
    /// outermost first, as the compiler inlined them into each other.
    ///
    /// # Errors
    /// Where the debug information is damaged.
    pub fn frames(&self, address: u64) -> Result<Vec<Frame>> {
        self.sources.frames(address)
    }

    /// What an address leads to: itself, or what is in the memory there, where
    /// the linker or the loader has settled it.
    pub fn settled(&self, address: u64) -> Target {
        self.slots.get(&address).cloned().unwrap_or(Target::At(address))
    }

    /// `symbol+0x12`, for messages.
    pub fn place(&self, address: u64) -> String {
        match self.function_around(address) {
            Some(function) => format!("{}+{:#x}", function.title(), address - function.start),
            None => format!("{address:#x}"),
        }
    }
}

impl Function {
    /// The name for messages.
    pub fn title(&self) -> String {
        self.names.first().map_or_else(|| format!("{:#x}", self.start), |name| path_of(name))
    }
}

/// The line that `rustc` leaves in `.comment`.
fn compiler(file: &object::File<'_>) -> Result<String> {
    let section = file.section_by_name(".comment").context("no .comment section")?;
    let text = String::from_utf8_lossy(section.data()?).into_owned();
    let lines: Vec<_> = text.split('\0').filter(|line| line.starts_with("rustc version")).collect();
    match lines.as_slice() {
        [] => bail!("no compiler named in .comment"),
        [line, ..] => Ok(line.replace("rustc version ", "rustc ")),
    }
}

fn functions(file: &object::File<'_>) -> BTreeMap<u64, Function> {
    let mut functions = BTreeMap::<u64, Function>::new();
    for symbol in file.symbols().filter(|symbol| symbol.is_definition()) {
        if symbol.kind() != SymbolKind::Text {
            continue;
        }
        let Ok(name) = symbol.name() else { continue };
        // On Arm the lowest bit says that it is Thumb code.
        let start = if file.architecture() == Architecture::Arm {
            symbol.address() & !1
        } else {
            symbol.address()
        };
        let function =
            functions.entry(start).or_insert(Function { start, end: start, names: Vec::new() });
        function.end = function.end.max(start + symbol.size());
        if !function.names.iter().any(|known| known == name) {
            function.names.push(name.to_owned());
        }
    }
    functions.values_mut().for_each(|function| function.names.sort());
    functions
}

/// Where the memory that calls go through leads, once the loader is done.
fn slots(file: &object::File<'_>) -> BTreeMap<u64, Target> {
    let settled: Vec<_> = file
        .sections()
        .filter(|section| section.name().is_ok_and(|name| name.starts_with(".got")))
        .map(|section| section.address()..section.address() + section.size())
        .collect();
    let symbols = file.dynamic_symbol_table();
    let mut slots = BTreeMap::new();
    for (address, relocation) in file.dynamic_relocations().into_iter().flatten() {
        if !settled.iter().any(|range| range.contains(&address)) {
            continue;
        }
        let target = match relocation.target() {
            RelocationTarget::Symbol(index) => {
                let symbol = symbols.as_ref().and_then(|table| {
                    object::ObjectSymbolTable::symbol_by_index(table, index).ok()
                });
                // By name, so that the loader may take another object's even
                // where this one has it.
                symbol.map(|symbol| Target::Outside(symbol.name().unwrap_or("?").to_owned()))
            }
            _ => u64::try_from(relocation.addend()).ok().map(Target::At),
        };
        slots.extend(target.map(|target| (address, target)));
    }
    slots
}

fn code(file: &object::File<'_>, isa: Isa) -> Result<Vec<Code>> {
    let mut code = Vec::new();
    for section in file.sections().filter(|section| section.kind() == SectionKind::Text) {
        let data = section.data()?;
        let start = section.address();
        let end = start + data.len() as u64;
        let marks = match isa {
            Isa::X86_64 => vec![(start, true)],
            Isa::Thumb => marks(file, start..end),
        };
        for (at, &(from, is_code)) in marks.iter().enumerate() {
            let to = marks.get(at + 1).map_or(end, |&(next, _)| next);
            if is_code {
                let within = |address: u64| usize::try_from(address - start);
                let bytes = data.get(within(from)?..within(to)?).unwrap_or_default().to_vec();
                code.push(Code { start: from, bytes });
            }
        }
    }
    Ok(code)
}

/// Arm's marks for where code (`$t`) and where data (`$d`) begins.
fn marks(file: &object::File<'_>, within: std::ops::Range<u64>) -> Vec<(u64, bool)> {
    let mut marks: Vec<_> = file
        .symbols()
        .filter(|symbol| within.contains(&symbol.address()))
        .filter_map(|symbol| {
            let name = symbol.name().ok()?;
            let is_code = name == "$t" || name.starts_with("$t.");
            let is_data = ["$d", "$a"]
                .iter()
                .any(|mark| name == *mark || name.starts_with(&format!("{mark}.")));
            (is_code || is_data).then_some((symbol.address(), is_code))
        })
        .collect();
    marks.sort_unstable();
    marks.dedup_by_key(|&mut (address, _)| address);
    marks
}
