//! Instruction sets: how bytes become [`Instruction`]s, and the few rules of
//! calling that the audit has to know.

mod thumb;
mod x86;

use std::collections::BTreeMap;

use anyhow::Result;

use crate::code::{Instruction, Register, Target};

/// An instruction set that the audit reads.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Isa {
    /// x86-64, as Linux programs are compiled for it.
    #[serde(rename = "x86_64")]
    X86_64,
    /// Thumb-2, as of Cortex-M.
    Thumb,
}

/// The calling convention, as far as the audit needs it.
#[derive(Debug)]
pub struct Convention {
    /// The stack pointer.
    pub stack_pointer: Register,
    /// What a call puts on the stack by itself, in bytes.
    pub return_address: u64,
    /// The first three arguments.
    pub arguments: [Register; 3],
    /// Which system call.
    pub system_call: Register,
    /// What a call leaves as it was.
    pub kept: Vec<Register>,
}

impl Isa {
    /// The name in `rows.toml` and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::X86_64 => "x86_64",
            Self::Thumb => "thumb",
        }
    }

    /// The name in a heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::X86_64 => "x86-64",
            Self::Thumb => "Thumb-2",
        }
    }

    /// Who calls whom, and how.
    pub fn convention(self) -> Convention {
        match self {
            Self::X86_64 => x86::convention(),
            Self::Thumb => thumb::convention(),
        }
    }

    /// The instructions in `bytes`, which stand at `address`. `slots` says
    /// where a jump through the memory at an address leads, where the linker
    /// has settled it.
    ///
    /// # Errors
    /// Where the bytes are no instructions.
    pub fn decode(
        self,
        bytes: &[u8],
        address: u64,
        slots: &BTreeMap<u64, Target>,
    ) -> Result<Vec<Instruction>> {
        match self {
            Self::X86_64 => x86::decode(bytes, address, slots),
            Self::Thumb => thumb::decode(bytes, address),
        }
    }
}
