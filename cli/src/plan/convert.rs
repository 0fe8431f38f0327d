//! `plan convert`: a plan, parameters or a state in the other form.

use faregate_planner::file;

use crate::args::PlanConvertArgs;
use crate::exit::{Exit, Failure};
use crate::plan::files;
use crate::{disk, out};

pub(crate) fn convert(args: &PlanConvertArgs) -> Result<Exit, Failure> {
    let ending = args.to.extension().map(|ending| ending.to_ascii_lowercase());
    let to_xml = match ending.as_ref().and_then(|ending| ending.to_str()) {
        Some("xml") => true,
        Some("bin") => false,
        _ => {
            let why = format!("{} ends neither in .xml nor in .bin", args.to.display());
            return Err(Failure::Because(Exit::Usage, why));
        }
    };
    disk::are_two(&args.from, &args.to)?;
    let parameters = files::parameters(args.parameters.as_deref(), Exit::Failed)?;
    let document = files::document(&args.from, parameters.as_ref(), Exit::Failed)?;
    let bytes = match to_xml {
        true => file::to_xml(&document, parameters.as_ref()).into_bytes(),
        false => file::to_binary(&document),
    };
    disk::write(&args.to, &bytes)?;
    let (to, what, length) = (args.to.display(), document.what(), bytes.len());
    out::line(format_args!("{to}: {what}, {length} bytes"))?;
    Ok(Exit::Done)
}
