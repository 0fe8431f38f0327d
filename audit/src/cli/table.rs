//! `table`: the table in a document.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context as _, Result};
use faregate_audit::findings::find;
use faregate_audit::image::Image;
use faregate_audit::isa::Isa;
use faregate_audit::rows::Rows;
use faregate_audit::table::{Comparison, compare, markdown, replace};

use super::Verdict;

/// Writes it, or compares.
pub(super) fn table(
    rows: &Rows,
    images: &BTreeMap<Isa, Image>,
    document: &Path,
    write: bool,
) -> Result<Verdict> {
    let shown = document.display();
    let text =
        std::fs::read_to_string(document).with_context(|| format!("{shown} cannot be read"))?;
    let table = markdown(&find(rows, images)?, images);
    if write {
        let text = replace(&text, &table).with_context(|| format!("{shown} cannot be changed"))?;
        std::fs::write(document, text).with_context(|| format!("{shown} cannot be written"))?;
        println!("{shown} has the table");
        return Ok(Verdict::Holds);
    }
    match compare(&text, &table).with_context(|| format!("{shown} cannot be compared"))? {
        Comparison::Same => println!("{shown} says what the audit finds"),
        Comparison::OtherCompiler { document, here } => println!(
            "{shown} is of {document}; here it is {here}, so that its figures are not compared"
        ),
        Comparison::Different(difference) => {
            println!("{shown} says something else than the audit finds:\n{difference}");
            return Ok(Verdict::Broken);
        }
    }
    Ok(Verdict::Holds)
}
