//! The child's side: loads the object and calls the function, between two
//! breakpoints. Here is what is unsafe in the audit.

use std::arch::asm;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use libloading::Library;

/// Called before each call of a function, where the object has one for it.
type SetUp = unsafe extern "C" fn(u64);
/// An audited function.
type Audited = unsafe extern "C" fn();

/// Runs in the child: asks to be traced, and makes the calls. A breakpoint
/// stops it before each, with the function's address in `rax`, and after it.
///
/// # Errors
/// Where the object or the function in it cannot be loaded, or no parent can
/// trace this process.
pub fn host(path: &Path, symbol: &str, calls: u64) -> Result<()> {
    // SAFETY: the object is one that was built to be audited: a `no_std`
    // library without initialisers of its own.
    let library = unsafe { Library::new(path) };
    let library = library.with_context(|| format!("{} cannot be loaded", path.display()))?;
    // SAFETY: `rows.toml` states that its symbols are functions of this type.
    let audited = unsafe { library.get::<Audited>(symbol) };
    let audited = *audited.with_context(|| format!("no function {symbol} can be called"))?;
    // SAFETY: as above, for the name with `_set_up` added.
    let set_up = unsafe { library.get::<SetUp>(format!("{symbol}_set_up")) };
    let set_up = set_up.ok().map(|symbol| *symbol);
    if let Err(errno) = nix::sys::ptrace::traceme() {
        bail!("this process cannot be traced: {errno}");
    }
    for seed in 0..calls {
        if let Some(set_up) = set_up {
            // SAFETY: the object is single-threaded here, and states its own
            // type in `rows.toml`.
            unsafe { set_up(seed) };
        }
        call(audited);
    }
    Ok(())
}

/// The call, between two breakpoints.
fn call(audited: Audited) {
    // SAFETY: a breakpoint stops a traced process and nothing else; the call
    // follows the C convention, whose clobbered registers are declared, and
    // `asm!` hands the block an aligned stack, since it may push.
    unsafe {
        asm!(
            "int3",
            "call rax",
            "int3",
            inout("rax") audited as usize => _,
            clobber_abi("C"),
        );
    }
}
