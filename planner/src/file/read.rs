//! Models from elements.

mod activity;
mod parameters;
mod plan;
mod state;

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::{Wrong, shown};

pub(super) use parameters::parameters;
pub(super) use plan::{Places as PlanPlaces, plan};
pub(super) use state::state;

use crate::file::VERSION;
use crate::file::fields::Fields;
use crate::file::value;
use crate::parameters::Load;
use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;

/// What was read, and where each part of it stands.
#[derive(Debug)]
pub(super) struct Placed<'e, T, P> {
    pub(super) value: T,
    pub(super) places: P,
    pub(super) root: &'e super::xml::Element<'e>,
    /// Whether everything could be read; of a plan: all but the activities.
    pub(super) good: bool,
}

/// Refuses a file of another version: what its words mean is not known here.
/// `false`: it is one.
fn version(fields: &mut Fields<'_, '_, '_, '_>) -> bool {
    let stand_in = VERSION.to_string();
    let version = fields.need("version", stand_in.clone(), |text| Ok(text.to_owned()));
    if version != stand_in {
        let message = format!("version {} is not known here", shown(&version));
        let wrong = Wrong::new(Rule::Version, message).expected(stand_in);
        fields.error(fields.element.span("version"), "version", wrong);
        return false;
    }
    true
}

fn load(fields: &mut Fields<'_, '_, '_, '_>) -> Load {
    Load {
        marginal: fields.or("marginal", Milliwatts::ZERO, value::power),
        peak: fields.or("peak", Milliwatts::ZERO, value::power),
    }
}

/// The bit that a `<uses>` names, by its resource or itself.
fn used_bit(fields: &mut Fields<'_, '_, '_, '_>, how: &str) -> Categories {
    let names = fields.names;
    let bit = match how {
        "resource" => fields.read("resource", |text| names.resource(text)).flatten(),
        _ => fields.read("bit", value::bit),
    };
    bit.map_or(Categories::NONE, value::only)
}

/// The smallest and the largest value, where nobody limits them.
fn limits(fields: &mut Fields<'_, '_, '_, '_>) -> (i64, i64) {
    let min = fields.or("min", i64::MIN, value::number);
    let max = fields.or("max", i64::MAX, value::number);
    if min > max && fields.good() {
        let wrong = Wrong::new(Rule::Limits, "no value is that small and that large");
        let at = fields.element.span("max");
        fields.error(at, "max", wrong.expected("not below min"));
    }
    (min, max)
}
