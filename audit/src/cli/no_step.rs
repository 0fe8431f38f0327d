//! `step`, where it cannot be.

use std::path::Path;

use anyhow::{Result, bail};
use faregate_audit::rows::Rows;

use super::{Object, Verdict};

/// Says so.
pub(super) fn step(_: &Rows, _: &Object, _: u64, _: u64, _: bool) -> Result<Verdict> {
    bail!("single-stepping is for Linux on x86-64")
}

/// Says so.
pub(super) fn host(_: &Path, _: &str, _: u64) -> Result<Verdict> {
    bail!("single-stepping is for Linux on x86-64")
}
