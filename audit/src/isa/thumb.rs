//! Thumb-2, by `capstone`.

use anyhow::{Context as _, Result, anyhow, bail};
use capstone::arch::arm::{
    ArchExtraMode, ArchMode, ArmCC, ArmInsnDetail, ArmOperand, ArmOperandType, ArmReg,
};
use capstone::prelude::*;
use capstone::{Insn, RegId};

use super::Convention;
use crate::code::{Flow, Instruction, Kind, Register, Target, Value};

const STACK: Register = Register(ArmReg::ARM_REG_SP);
const PROGRAM: Register = Register(ArmReg::ARM_REG_PC);
const LINK: Register = Register(ArmReg::ARM_REG_LR);

/// Instructions of bounded time, without their conditions, widths and flags.
const KNOWN: &[&str] = &[
    "adc", "add", "addw", "adr", "and", "asr", "b", "bfc", "bfi", "bic", "bl", "blx", "bx", "cbnz",
    "cbz", "clrex", "clz", "cmn", "cmp", "cps", "cpsid", "cpsie", "dmb", "dsb", "eor", "isb", "it",
    "ldm", "ldmdb", "ldr", "ldrb", "ldrd", "ldrex", "ldrexb", "ldrexh", "ldrh", "ldrsb", "ldrsh",
    "lsl", "lsr", "mla", "mls", "mov", "movs", "movt", "movw", "mrs", "msr", "mul", "mvn", "nop",
    "orn", "orr", "pkhbt", "pkhtb", "pop", "push", "rbit", "rev", "rev16", "revsh", "ror", "rrx",
    "rsb", "sbc", "sbfx", "sel", "smlabb", "smlal", "smull", "ssat", "stm", "stmdb", "str", "strb",
    "strd", "strex", "strexb", "strexh", "strh", "sub", "subs", "subw", "sxtab", "sxtah", "sxtb",
    "sxth", "teq", "tst", "uadd8", "ubfx", "umaal", "umlal", "umull", "uqadd8", "uqsub8", "usat",
    "usub8", "uxtab", "uxtah", "uxtb", "uxth", "vldmia", "vldr", "vmov", "vpop", "vpush", "vstmia",
    "vstr", "yield",
];

/// The procedure call standard.
pub(super) fn convention() -> Convention {
    use ArmReg as R;
    Convention {
        stack_pointer: STACK,
        return_address: 0,
        arguments: [R::ARM_REG_R0, R::ARM_REG_R1, R::ARM_REG_R2].map(Register),
        system_call: Register(R::ARM_REG_R7),
        kept: [
            R::ARM_REG_SP,
            R::ARM_REG_R4,
            R::ARM_REG_R5,
            R::ARM_REG_R6,
            R::ARM_REG_R7,
            R::ARM_REG_R8,
            R::ARM_REG_R9,
            R::ARM_REG_R10,
            R::ARM_REG_R11,
        ]
        .map(Register)
        .to_vec(),
    }
}

pub(super) fn decode(bytes: &[u8], address: u64) -> Result<Vec<Instruction>> {
    let capstone = Capstone::new()
        .arm()
        .mode(ArchMode::Thumb)
        .extra_mode([ArchExtraMode::MClass].into_iter())
        .detail(true)
        .build()
        .map_err(|error| anyhow!("capstone: {error}"))?;
    // All at once: the decoder has to remember the `it` before a block.
    let read = capstone.disasm_all(bytes, address).map_err(|error| anyhow!("capstone: {error}"))?;
    let instructions: Vec<_> =
        read.iter().map(|insn| instruction(&capstone, insn)).collect::<Result<_>>()?;
    let end = instructions.last().map_or(address, |last| last.next);
    if end != address + bytes.len() as u64 {
        bail!("no instruction at {end:#x}");
    }
    Ok(instructions)
}

fn instruction(capstone: &Capstone, insn: &Insn<'_>) -> Result<Instruction> {
    let detail = capstone.insn_detail(insn).map_err(|error| anyhow!("capstone: {error}"))?;
    let arch = detail.arch_detail();
    let arm = arch.arm().context("no Arm instruction")?;
    let mnemonic = insn.mnemonic().unwrap_or_default();
    let name = capstone.insn_name(insn.id()).unwrap_or_default();
    // One instruction to the decoder: doing nothing, and waiting for events.
    let harmless = ["nop", "yield"].into_iter().find(|hint| mnemonic.starts_with(hint));
    let name = if name == "hint" { harmless.unwrap_or("hint").to_owned() } else { name };
    let operands: Vec<_> = arm.operands().collect();
    let read = Read { name: &name, arm, operands: &operands, implicit: detail.regs_write() };
    let flow = read.flow();
    Ok(Instruction {
        address: insn.address(),
        next: insn.address() + insn.bytes().len() as u64,
        conditional: read.is_conditional(),
        writes: read.writes(),
        locked: matches!(&*name, "strex" | "strexb" | "strexh" | "strexd" | "dmb" | "dsb" | "isb"),
        breaks: read.breaks(&flow),
        flow,
        text: format!("{mnemonic} {}", insn.op_str().unwrap_or_default()),
    })
}

/// One decoded instruction.
struct Read<'a> {
    name: &'a str,
    arm: &'a ArmInsnDetail<'a>,
    operands: &'a [ArmOperand],
    implicit: &'a [RegId],
}

impl Read<'_> {
    fn register(&self, at: usize) -> Option<Register> {
        match self.operands.get(at)?.op_type {
            ArmOperandType::Reg(register) => Some(Register(register.0.into())),
            _ => None,
        }
    }

    fn immediate(&self, at: usize) -> Option<i64> {
        match self.operands.get(at)?.op_type {
            ArmOperandType::Imm(value) => Some(value.into()),
            _ => None,
        }
    }

    fn registers(&self) -> impl Iterator<Item = Register> + '_ {
        (0..self.operands.len()).filter_map(|at| self.register(at))
    }

    /// Where a branch leads. Capstone adds the address to it already.
    fn branch(&self, at: usize) -> Target {
        match self.immediate(at) {
            Some(to) => Target::At(u64::from(u32::try_from(to & 0xffff_ffff).unwrap_or(0)) & !1),
            None => Target::Computed,
        }
    }

    fn is_conditional(&self) -> bool {
        let always = matches!(self.arm.cc(), ArmCC::ARM_CC_AL | ArmCC::ARM_CC_INVALID);
        !always || matches!(self.name, "cbz" | "cbnz")
    }

    fn flow(&self) -> Flow {
        match self.name {
            "b" => Flow::Jump(self.branch(0)),
            "cbz" | "cbnz" => Flow::Jump(self.branch(1)),
            "bl" => Flow::Call(self.branch(0)),
            // Cortex-M has no other instruction set to switch to, so the
            // operand of this one is a register.
            "blx" => Flow::Call(Target::Computed),
            "bx" if self.register(0) == Some(LINK) => Flow::Return,
            "pop" | "ldm" if self.registers().any(|register| register == PROGRAM) => Flow::Return,
            "ldr" if self.register(0) == Some(PROGRAM) && self.base() == Some(STACK) => {
                Flow::Return
            }
            "svc" => Flow::Kernel,
            "udf" => Flow::Trap,
            _ if self.written().any(|register| register == PROGRAM) => Flow::Jump(Target::Computed),
            "bx" | "tbb" | "tbh" => Flow::Jump(Target::Computed),
            _ => Flow::On,
        }
    }

    fn breaks(&self, flow: &Flow) -> Option<Kind> {
        match self.name {
            "udiv" | "sdiv" | "vdiv" | "vsqrt" => Some(Kind::Division),
            "udf" => Some(Kind::Trap),
            _ if *flow != Flow::On => None,
            name => (!KNOWN.contains(&name) && !is_parallel(name)).then_some(Kind::Unknown),
        }
    }

    /// The register that a memory operand starts from.
    fn base(&self) -> Option<Register> {
        self.memory().map(|(base, _)| base)
    }

    fn memory(&self) -> Option<(Register, i64)> {
        self.operands.iter().find_map(|operand| match operand.op_type {
            ArmOperandType::Mem(memory) => {
                Some((Register(memory.base().0.into()), memory.disp().into()))
            }
            _ => None,
        })
    }

    /// All registers that are written, as far as the decoder says.
    fn written(&self) -> impl Iterator<Item = Register> + '_ {
        let explicit = self
            .operands
            .iter()
            .filter(|operand| operand.access.is_none_or(|access| access.is_writable()))
            .filter_map(|operand| match operand.op_type {
                ArmOperandType::Reg(register) => Some(Register(register.0.into())),
                _ => None,
            });
        let implicit = self.implicit.iter().map(|register| Register(register.0.into()));
        let base = self.base().filter(|_| self.arm.writeback());
        explicit.chain(implicit).chain(base)
    }

    fn writes(&self) -> Vec<(Register, Value)> {
        let mut writes: Vec<_> =
            self.written().map(|register| (register, Value::Anything)).collect();
        if let Some((to, value)) = self.known_write() {
            writes.retain(|&(register, _)| register != to);
            writes.push((to, if self.is_conditional() { Value::Anything } else { value }));
        }
        writes
    }

    /// What the instruction leaves in a register, where the audit follows it.
    fn known_write(&self) -> Option<(Register, Value)> {
        let to = self.register(0);
        let stack = |bytes: i64| Some((STACK, Value::Plus(STACK, bytes)));
        match self.name {
            "push" | "vpush" => stack(-self.bytes_of_registers(0)),
            "pop" | "vpop" => stack(self.bytes_of_registers(0)),
            "stmdb" | "vstmdb" if self.saves_to_stack() => stack(-self.bytes_of_registers(1)),
            "ldm" | "vldmia" if self.saves_to_stack() => stack(self.bytes_of_registers(1)),
            "mov" | "movs" | "movw" => {
                let value = match (self.immediate(1), self.register(1)) {
                    (Some(number), _) => Value::Constant(u64::from(low_word(number))),
                    (None, Some(from)) if self.operands.len() == 2 && self.is_unshifted(1) => {
                        Value::Plus(from, 0)
                    }
                    _ => return None,
                };
                Some((to?, value))
            }
            "add" | "addw" | "adds" => Some((to?, self.sum(1)?)),
            "sub" | "subw" | "subs" => Some((to?, self.sum(-1)?)),
            "bfc" if self.immediate(1) == Some(0) => {
                let bits = u32::try_from(self.immediate(2)?).ok()?;
                Some((to?, Value::And(to?, u64::MAX.checked_shl(bits)?)))
            }
            "bic" => {
                let mask = u64::from(low_word(self.immediate(2)?));
                Some((to?, Value::And(self.register(1)?, !mask)))
            }
            _ => self.writeback(),
        }
    }

    fn is_unshifted(&self, at: usize) -> bool {
        self.operands
            .get(at)
            .is_some_and(|operand| matches!(operand.shift, capstone::arch::arm::ArmShift::Invalid))
    }

    /// `add a, b, #n` and `add a, #n`.
    fn sum(&self, sign: i64) -> Option<Value> {
        match (self.register(1), self.immediate(2), self.immediate(1)) {
            (Some(from), Some(number), _) => Some(Value::Plus(from, sign * number)),
            (None, _, Some(number)) => Some(Value::Plus(self.register(0)?, sign * number)),
            _ => None,
        }
    }

    /// A base register that moves by the offset, before or after the access.
    fn writeback(&self) -> Option<(Register, Value)> {
        if !self.arm.writeback() {
            return None;
        }
        let (base, before) = self.memory()?;
        let after = self.operands.last().and_then(|operand| match operand.op_type {
            ArmOperandType::Imm(bytes) => {
                Some(if operand.subtracted { -i64::from(bytes) } else { i64::from(bytes) })
            }
            _ => None,
        });
        Some((base, Value::Plus(base, after.unwrap_or(before))))
    }

    fn saves_to_stack(&self) -> bool {
        self.arm.writeback() && self.register(0) == Some(STACK)
    }

    fn bytes_of_registers(&self, from: usize) -> i64 {
        self.registers().skip(from).map(|register| if is_double(register) { 8 } else { 4 }).sum()
    }
}

/// Sums and differences of the halves or bytes of a register, one cycle each.
fn is_parallel(name: &str) -> bool {
    ["add8", "add16", "sub8", "sub16", "asx", "sax"].iter().any(|what| {
        let how = name.strip_suffix(what);
        how.is_some_and(|how| ["s", "q", "sh", "u", "uq", "uh"].contains(&how))
    })
}

fn is_double(register: Register) -> bool {
    (ArmReg::ARM_REG_D0..=ArmReg::ARM_REG_D31).contains(&register.0)
}

fn low_word(number: i64) -> u32 {
    u32::try_from(number & 0xffff_ffff).unwrap_or(0)
}
