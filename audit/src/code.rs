//! Instructions, as far as the audit looks at them: the same for each
//! instruction set.

use std::fmt;

/// A register, by the number that its instruction set's decoder gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Register(pub u32);

/// One instruction.
#[derive(Clone, Debug)]
pub struct Instruction {
    /// Where it stands.
    pub address: u64,
    /// Where the next one stands.
    pub next: u64,
    /// Where it leads.
    pub flow: Flow,
    /// Whether it may also do nothing and go on: a conditional jump, or any
    /// Thumb instruction in an `it` block.
    pub conditional: bool,
    /// What becomes of registers.
    pub writes: Vec<(Register, Value)>,
    /// Whether other cores take part: a locked access, an exclusive store, a
    /// barrier.
    pub locked: bool,
    /// What it breaks by itself, if anything.
    pub breaks: Option<Kind>,
    /// As an assembler would write it.
    pub text: String,
}

/// Where an instruction leads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Flow {
    /// To the next one.
    On,
    /// Somewhere else, for good.
    Jump(Target),
    /// Somewhere else and back.
    Call(Target),
    /// Into the kernel and back.
    Kernel,
    /// Back to the caller.
    Return,
    /// Nowhere: the processor stops the program.
    Trap,
}

/// What is jumped to or called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// An address in this object.
    At(u64),
    /// A function that another object has.
    Outside(String),
    /// Whatever this register holds, which may be settled.
    Held(Register),
    /// Whatever memory says at run time.
    Computed,
}

/// What becomes of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// This number.
    Constant(u64),
    /// Another register's value, and this much more.
    Plus(Register, i64),
    /// Another register's value, and only the bits of this mask.
    And(Register, u64),
    /// Nothing that the audit follows.
    Anything,
}

/// What can be wrong with compiled code, by the names that a row's `may` uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// There is no such function.
    Missing,
    /// There is nothing in it.
    Empty,
    /// A loop without a stated bound.
    Loop,
    /// A function that calls itself, by whatever way.
    Recursion,
    /// A call of what memory says at run time.
    IndirectCall,
    /// A jump to what memory says at run time.
    IndirectJump,
    /// A system call that the row does not name.
    SystemCall,
    /// A division: its time depends on its operands, or it is a loop.
    Division,
    /// A way into a panic.
    Panic,
    /// An instruction that stops the program.
    Trap,
    /// Memory taken from or given to an allocator.
    Allocation,
    /// An instruction that repeats itself (`rep`).
    Repeat,
    /// A stack pointer that the audit cannot follow.
    DynamicStack,
    /// A copy, comparison or fill of a length known only at run time.
    Copy,
    /// A call of what is not in the object.
    Outside,
    /// What is not on the list of what is known to be bounded.
    Unknown,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missing => "missing",
            Self::Empty => "empty",
            Self::Loop => "loop",
            Self::Recursion => "recursion",
            Self::IndirectCall => "indirect-call",
            Self::IndirectJump => "indirect-jump",
            Self::SystemCall => "system-call",
            Self::Division => "division",
            Self::Panic => "panic",
            Self::Trap => "trap",
            Self::Allocation => "allocation",
            Self::Repeat => "repeat",
            Self::DynamicStack => "dynamic-stack",
            Self::Copy => "copy",
            Self::Outside => "outside",
            Self::Unknown => "unknown",
        })
    }
}
