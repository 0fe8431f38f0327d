//! What an instruction calls, and whether the row allows it.

use std::collections::BTreeSet;

use anyhow::Result;
use syscalls::Sysno;

use super::{Cost, Walk};
use crate::body::{Found, Node, names};
use crate::code::{Kind, Register, Target};
use crate::image::{Role, path_of, role_of};
use crate::values::{Holds, Registers, depth};

impl Walk<'_> {
    /// The cost of what is called, and what is wrong with it.
    pub(super) fn called(
        &mut self,
        address: u64,
        node: &Node,
        target: &Target,
        registers: &Registers,
        length: Option<u64>,
    ) -> Result<Cost> {
        if let Some(settled) = settled(target, registers) {
            let mut worst = Cost::default();
            for start in settled {
                let target = self.image.settled(start);
                worst = worst.or_more(self.called(address, node, &target, registers, length)?);
            }
            return Ok(worst);
        }
        let names = names(self.image, target);
        if self.is_cold(&names) {
            return Ok(Cost::default());
        }
        let role = names.iter().find_map(|name| role_of(name));
        match (target, role) {
            (Target::Held(_) | Target::Computed, _) => self.computed(address, node, registers),
            (Target::Outside(name), None) => self.outside(address, name, registers),
            (Target::At(start), None) => self.inner(address, *start, length),
            (_, Some(Role::Denied(kind))) => self.denied(address, target, kind, &names),
            (_, Some(Role::Memory(argument))) => {
                self.copy(address, target, argument, registers, length, &names)
            }
        }
    }

    fn is_cold(&mut self, names: &[String]) -> bool {
        let row = self.row;
        let mut cold = row
            .cold
            .iter()
            .filter(|cold| names.iter().any(|name| name == *cold || path_of(name) == **cold));
        let found = cold.next();
        self.outcome.cold.extend(found.cloned());
        found.is_some()
    }

    fn computed(&mut self, address: u64, node: &Node, registers: &Registers) -> Result<Cost> {
        // Jump tables are switched off, so that a computed jump is a call in
        // the last place: nothing of the function is on the stack any more.
        let is_call = !node.is_tail || depth(registers, &self.convention) == Some(0);
        match &self.row.indirect {
            Some(why) if is_call => self.outcome.port = Some(why.clone()),
            _ if node.is_tail => {
                let detail = "it goes where memory says at run time";
                self.report(&Found::new(address, Kind::IndirectJump, detail))?;
            }
            _ => {
                let detail = "it calls what memory says at run time";
                self.report(&Found::new(address, Kind::IndirectCall, detail))?;
            }
        }
        Ok(Cost::default())
    }

    fn outside(&mut self, address: u64, name: &str, registers: &Registers) -> Result<Cost> {
        let [number, ..] = self.convention.arguments;
        if name == "syscall" {
            self.kernel(address, number, registers)?;
        } else if self.row.external.iter().any(|external| external.symbol == name) {
            self.outcome.external.insert(name.to_owned());
        } else {
            let detail = format!("{name} is in another object");
            self.report(&Found::new(address, Kind::Outside, detail))?;
        }
        Ok(Cost::default())
    }

    /// A system call, by its number.
    pub(super) fn kernel(
        &mut self,
        address: u64,
        number: Register,
        registers: &Registers,
    ) -> Result<()> {
        let numbers = match registers.get(&number) {
            Some(Holds::OneOf(numbers)) => numbers.clone(),
            _ => {
                let detail = "which system call is known only at run time";
                return self.report(&Found::new(address, Kind::SystemCall, detail));
            }
        };
        for number in numbers {
            let name = usize::try_from(number).ok().and_then(Sysno::new);
            let name = name.map_or_else(|| number.to_string(), |name| name.name().to_owned());
            if self.row.system_calls.contains(&name) {
                self.outcome.system_calls.insert(name);
            } else {
                self.report(&Found::new(address, Kind::SystemCall, name))?;
            }
        }
        Ok(())
    }

    fn inner(&mut self, address: u64, start: u64, length: Option<u64>) -> Result<Cost> {
        let Some(function) = self.image.function(start) else {
            let detail = format!("{start:#x} is where no function begins");
            self.report(&Found::new(address, Kind::Unknown, detail))?;
            return Ok(Cost::default());
        };
        if self.inside.contains(&start) {
            let detail = format!("{} is being executed already", function.title());
            self.report(&Found::new(address, Kind::Recursion, detail))?;
            return Ok(Cost::default());
        }
        self.function(&function.clone(), length)
    }

    /// A function that no row calls without saying why. Where it is said, a
    /// division is walked through; the others end the path.
    fn denied(
        &mut self,
        address: u64,
        target: &Target,
        kind: Kind,
        names: &[String],
    ) -> Result<Cost> {
        let name = names.first().map_or_else(String::new, |name| path_of(name));
        let found = Found::new(address, kind, format!("it calls {name}"));
        if !self.is_excused(kind) {
            self.report(&found)?;
        } else if let (Kind::Division, Target::At(start)) = (kind, target) {
            return self.inner(address, *start, None);
        }
        Ok(Cost::default())
    }

    /// A copy, which is bounded where its length is a number in the code.
    fn copy(
        &mut self,
        address: u64,
        target: &Target,
        argument: usize,
        registers: &Registers,
        around: Option<u64>,
        names: &[String],
    ) -> Result<Cost> {
        let name = names.first().cloned().unwrap_or_default();
        let Target::At(start) = target else {
            let detail = format!("{name} is in another object");
            self.report(&Found::new(address, Kind::Copy, detail))?;
            return Ok(Cost::default());
        };
        let register = self.convention.arguments.get(argument);
        let length = match register.and_then(|register| registers.get(register)) {
            Some(Holds::OneOf(lengths)) => lengths.last().copied(),
            _ => around,
        };
        if length.is_none() {
            let detail = format!("how much {name} handles is known only at run time");
            if !self.is_excused(Kind::Copy) {
                self.report(&Found::new(address, Kind::Copy, detail))?;
                return Ok(Cost::default());
            }
        }
        self.outcome.copies = self.outcome.copies.max(length);
        self.inner(address, *start, length)
    }
}

/// The functions that a register can hold, where all of them are known.
fn settled(target: &Target, registers: &Registers) -> Option<BTreeSet<u64>> {
    let Target::Held(register) = target else { return None };
    match registers.get(register)? {
        Holds::OneOf(addresses) => Some(addresses.clone()),
        Holds::Stack(_) => None,
    }
}
