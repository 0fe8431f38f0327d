//! x86-64, by `iced-x86`.

use std::collections::BTreeMap;

use anyhow::{Result, bail};
use iced_x86::{
    Code, CpuidFeature, Decoder, DecoderOptions, FlowControl, Formatter as _,
    InstructionInfoFactory, IntelFormatter, Mnemonic, OpAccess, OpKind, Register as Iced,
};

use super::Convention;
use crate::code::{Flow, Instruction, Kind, Register, Target, Value};

/// The parts of the instruction set whose instructions take a bounded time,
/// those apart that [`breaks`] names.
const KNOWN: &[CpuidFeature] = &[
    CpuidFeature::INTEL8086,
    CpuidFeature::INTEL186,
    CpuidFeature::INTEL286,
    CpuidFeature::INTEL386,
    CpuidFeature::INTEL486,
    CpuidFeature::X64,
    CpuidFeature::CMOV,
    CpuidFeature::CX8,
    CpuidFeature::CMPXCHG16B,
    CpuidFeature::SSE,
    CpuidFeature::SSE2,
    CpuidFeature::MULTIBYTENOP,
    CpuidFeature::PAUSE,
    CpuidFeature::CET_IBT,
    CpuidFeature::POPCNT,
    CpuidFeature::LZCNT,
    CpuidFeature::BMI1,
    CpuidFeature::BMI2,
];

fn register(of: Iced) -> Register {
    Register(of.full_register() as u32)
}

/// System V.
pub(super) fn convention() -> Convention {
    Convention {
        stack_pointer: register(Iced::RSP),
        return_address: 8,
        arguments: [Iced::RDI, Iced::RSI, Iced::RDX].map(register),
        system_call: register(Iced::RAX),
        kept: [Iced::RSP, Iced::RBX, Iced::RBP, Iced::R12, Iced::R13, Iced::R14, Iced::R15]
            .map(register)
            .to_vec(),
    }
}

pub(super) fn decode(
    bytes: &[u8],
    address: u64,
    slots: &BTreeMap<u64, Target>,
) -> Result<Vec<Instruction>> {
    let mut formatter = IntelFormatter::new();
    let mut factory = InstructionInfoFactory::new();
    let mut instructions = Vec::new();
    for read in Decoder::with_ip(64, bytes, address, DecoderOptions::NONE) {
        if read.is_invalid() {
            bail!("no instruction at {:#x}", read.ip());
        }
        let mut text = String::new();
        formatter.format(&read, &mut text);
        instructions.push(Instruction {
            address: read.ip(),
            next: read.next_ip(),
            flow: flow(&read, slots),
            conditional: read.flow_control() == FlowControl::ConditionalBranch,
            writes: writes(&read, slots, &mut factory),
            locked: is_locked(&read),
            breaks: breaks(&read),
            text,
        });
    }
    Ok(instructions)
}

fn flow(read: &iced_x86::Instruction, slots: &BTreeMap<u64, Target>) -> Flow {
    let target = || match read.op0_kind() {
        OpKind::NearBranch64 => Target::At(read.near_branch64()),
        OpKind::Memory if read.is_ip_rel_memory_operand() => {
            slots.get(&read.memory_displacement64()).cloned().unwrap_or(Target::Computed)
        }
        OpKind::Register => Target::Held(register(read.op0_register())),
        _ => Target::Computed,
    };
    match (read.mnemonic(), read.flow_control()) {
        (Mnemonic::Syscall | Mnemonic::Sysenter, _) => Flow::Kernel,
        (_, FlowControl::Next) => Flow::On,
        (_, FlowControl::Call | FlowControl::IndirectCall) => Flow::Call(target()),
        (_, FlowControl::Return) => Flow::Return,
        (
            _,
            FlowControl::UnconditionalBranch
            | FlowControl::ConditionalBranch
            | FlowControl::IndirectBranch,
        ) => Flow::Jump(target()),
        (_, FlowControl::Exception | FlowControl::Interrupt | FlowControl::XbeginXabortXend) => {
            Flow::Trap
        }
    }
}

fn is_locked(read: &iced_x86::Instruction) -> bool {
    let to_memory = read.op0_kind() == OpKind::Memory || read.op1_kind() == OpKind::Memory;
    match read.mnemonic() {
        Mnemonic::Mfence => true,
        // Locked without a prefix, where it is with memory.
        Mnemonic::Xchg => to_memory,
        _ => read.has_lock_prefix(),
    }
}

fn breaks(read: &iced_x86::Instruction) -> Option<Kind> {
    let repeats = read.has_rep_prefix() || read.has_repe_prefix() || read.has_repne_prefix();
    match read.mnemonic() {
        _ if repeats && read.is_string_instruction() => Some(Kind::Repeat),
        Mnemonic::Div
        | Mnemonic::Idiv
        | Mnemonic::Divss
        | Mnemonic::Divsd
        | Mnemonic::Divps
        | Mnemonic::Divpd
        | Mnemonic::Sqrtss
        | Mnemonic::Sqrtsd
        | Mnemonic::Sqrtps
        | Mnemonic::Sqrtpd => Some(Kind::Division),
        Mnemonic::Ud2 => Some(Kind::Trap),
        // What follows them waits for devices or stops the program.
        Mnemonic::In | Mnemonic::Out | Mnemonic::Int | Mnemonic::Int3 | Mnemonic::Into => {
            Some(Kind::Unknown)
        }
        _ => (!is_known(read)).then_some(Kind::Unknown),
    }
}

fn is_known(read: &iced_x86::Instruction) -> bool {
    // A system call is judged by its number.
    let kernel = matches!(read.mnemonic(), Mnemonic::Syscall);
    let bounded = read.cpuid_features().iter().all(|feature| KNOWN.contains(feature));
    kernel || (bounded && !read.is_privileged() && !read.is_save_restore_instruction())
}

fn writes(
    read: &iced_x86::Instruction,
    slots: &BTreeMap<u64, Target>,
    factory: &mut InstructionInfoFactory,
) -> Vec<(Register, Value)> {
    let stack = register(Iced::RSP);
    let mut writes: Vec<_> = factory
        .info(read)
        .used_registers()
        .iter()
        .filter(|used| {
            matches!(
                used.access(),
                OpAccess::Write
                    | OpAccess::CondWrite
                    | OpAccess::ReadWrite
                    | OpAccess::ReadCondWrite
            )
        })
        .map(|used| (register(used.register()), Value::Anything))
        .collect();
    let known = match read.flow_control() {
        FlowControl::Next => known_write(read).or_else(|| address_write(read, slots)),
        _ => None,
    };
    let pushed = i64::from(read.stack_pointer_increment());
    let stack_moves = pushed != 0 && known.is_none_or(|(to, _)| to != stack);
    let moved = stack_moves.then_some((stack, Value::Plus(stack, pushed)));
    for (to, value) in known.into_iter().chain(moved) {
        // `pop rsp` is not followed: it is in the list twice, once as anything.
        writes.retain(|&(register, _)| register != to);
        writes.push((to, value));
    }
    if read.mnemonic() == Mnemonic::Pop && read.op0_register().full_register() == Iced::RSP {
        writes.push((stack, Value::Anything));
    }
    writes
}

/// What the instruction leaves in its first operand, where the audit follows it.
fn known_write(read: &iced_x86::Instruction) -> Option<(Register, Value)> {
    let whole = |of: Iced| of.is_gpr32() || of.is_gpr64();
    let to = (read.op0_kind() == OpKind::Register && whole(read.op0_register()))
        .then(|| read.op0_register())?;
    let immediate = || read.try_immediate(1).ok();
    let from = (read.op_count() > 1 && read.op1_kind() == OpKind::Register)
        .then(|| read.op1_register())
        .filter(|&from| whole(from));
    let value = match (read.mnemonic(), from) {
        (Mnemonic::Xor, Some(from)) if from == to => Value::Constant(0),
        (Mnemonic::Mov, Some(from)) => Value::Plus(register(from), 0),
        (Mnemonic::Mov, None) => Value::Constant(immediate()?),
        (Mnemonic::Add, None) => Value::Plus(register(to), immediate()?.cast_signed()),
        (Mnemonic::Sub, None) => {
            Value::Plus(register(to), immediate()?.cast_signed().wrapping_neg())
        }
        (Mnemonic::And, None) => Value::And(register(to), immediate()?),
        (Mnemonic::Lea, None) if is_plain_address(read) => {
            Value::Plus(register(read.memory_base()), read.memory_displacement64().cast_signed())
        }
        _ => return None,
    };
    let narrow = to.is_gpr32() && matches!(read.code(), Code::Lea_r32_m);
    (!narrow).then_some((register(to), value))
}

/// The address of a function, as the linker or the loader has settled it.
fn address_write(
    read: &iced_x86::Instruction,
    slots: &BTreeMap<u64, Target>,
) -> Option<(Register, Value)> {
    let is_ours = read.op0_kind() == OpKind::Register
        && read.op0_register().is_gpr64()
        && read.is_ip_rel_memory_operand();
    let address = is_ours.then(|| read.memory_displacement64())?;
    let value = match (read.mnemonic(), slots.get(&address)) {
        (Mnemonic::Lea, _) => Value::Constant(address),
        // What is in it is known by its address.
        (Mnemonic::Mov, Some(_)) => Value::Constant(address),
        _ => return None,
    };
    Some((register(read.op0_register()), value))
}

/// A register and a number.
fn is_plain_address(read: &iced_x86::Instruction) -> bool {
    read.memory_index() == Iced::None
        && read.memory_base() != Iced::None
        && !read.is_ip_rel_memory_operand()
}
