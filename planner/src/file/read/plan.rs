//! A plan from its elements.

use std::collections::BTreeMap;

use faregate_scheduler::format::reading::Report;

use crate::file::fields::Fields;
use crate::file::names::Names;
use crate::file::read::{Placed, activity, version};
use crate::file::schema;
use crate::file::value;
use crate::file::xml::Element;
use crate::plan::{ActivityId, Plan};
use crate::units::{Bytes, Ppm};

/// Where the activities of a plan stand.
#[derive(Debug, Default)]
pub(in crate::file) struct Places<'e> {
    /// Of each that could be read, in their order.
    pub(in crate::file) activities: Vec<&'e Element<'e>>,
    /// Of each whose number could be read.
    pub(in crate::file) known: BTreeMap<ActivityId, &'e Element<'e>>,
    /// Of all.
    all: Vec<&'e Element<'e>>,
}

impl<'e> Places<'e> {
    /// Whether every activity could be read: nobody misses another one then.
    pub(in crate::file) fn whole(&self) -> bool {
        self.activities.len() == self.all.len()
    }

    /// Of all, those included that could not be read.
    pub(in crate::file) fn all(&self) -> impl Iterator<Item = &'e Element<'e>> {
        self.all.iter().copied()
    }
}

/// Reads a plan; tells what is wrong with it. `None`: of another version.
pub(in crate::file) fn plan<'e>(
    root: &'e Element<'e>,
    names: &Names<'_>,
    report: &mut Report<'_>,
) -> Option<Placed<'e, Plan, Places<'e>>> {
    let mut fields = Fields::new(root, &schema::PLAN, names, report);
    if !version(&mut fields) {
        return None;
    }
    let mut plan = Plan {
        name: fields.need("name", String::new(), value::name),
        handover: fields.time("handover"),
        handover_min_soc: fields.need("handover_min_soc", Ppm::ZERO, value::fraction),
        end: fields.time("end"),
        max_delta_data: fields.need("max_delta_data", Bytes::ZERO, value::data),
        next_plan: fields.read("next_plan", value::name),
        activities: Vec::new(),
    };
    let good = fields.good();
    let mut places = Places::default();
    for element in fields.children(&schema::ACTIVITY) {
        places.all.push(element);
        let mut fields = fields.within(element, &schema::ACTIVITY);
        let read = activity::activity(&mut fields);
        // A number that stands in for one that cannot be read is nobody's.
        let id = element.attribute("id").and_then(|id| value::activity(&id.value).ok());
        if let Some(first) = id.and_then(|id| places.known.get(&id)) {
            fields.twice("id", &read.id.to_string(), first.span("id"));
        } else if let Some(id) = id {
            places.known.insert(id, element);
        }
        if fields.good() {
            plan.activities.push(read);
            places.activities.push(element);
        }
    }
    Some(Placed { value: plan, places, root, good })
}
