//! A plan as elements.

use faregate_tickets::amount::Milliwatts;

use crate::file::names::Names;
use crate::file::words::{STATUSES, TYPES, Type, VARIABLES, word};
use crate::file::write::Build;
use crate::file::xml::Element;
use crate::file::{VERSION, schema, show};
use crate::plan::{Activity, Effect, Kind, Plan};
use crate::units::Bytes;

pub(super) fn plan(plan: &Plan, names: &Names<'_>) -> Element<'static> {
    let mut root = Build::new(&schema::PLAN, names);
    root.set("version", VERSION.to_string())
        .set("name", &plan.name)
        .time("handover", plan.handover)
        .set("handover_min_soc", show::fraction(plan.handover_min_soc))
        .time("end", plan.end)
        .set("max_delta_data", show::data(plan.max_delta_data))
        .set_if("next_plan", plan.next_plan.as_deref());
    for one in &plan.activities {
        root.add(&schema::ACTIVITY, |element| activity(one, element));
    }
    root.element
}

fn activity(activity: &Activity, element: &mut Build<'_, '_>) {
    element
        .set("id", activity.id.get().to_string())
        .set_if("name", activity.name.as_deref())
        .unless(Type::Generic, "type", of(activity.kind), |of| word(of, &TYPES).to_owned())
        .set_if("sequence", activity.sequence.as_deref())
        .set("priority", activity.priority.to_string())
        .set_if("value", activity.value.map(|value| value.to_string()))
        .set("duration", show::span(activity.duration));
    kind(activity.kind, element);
    element
        .unless(Milliwatts::ZERO, "marginal", activity.marginal, show::power)
        .set_if("energy", activity.energy.map(show::energy))
        .unless(Milliwatts::ZERO, "peak", activity.peak, show::power)
        .unless(Bytes::ZERO, "data", activity.data, show::data)
        .unless(0, "engines", activity.engines, |engines| engines.to_string())
        .set_if("group", activity.group.as_deref())
        .unless(false, "pausable", activity.pausable, |pausable| pausable.to_string());
    times(activity, element);
    element.uses(activity.resources);
    for zone in &activity.zones {
        element.add(&schema::USES, |uses| {
            uses.set("zone", zone);
        });
    }
    named(activity, element);
}

const fn of(kind: Kind) -> Type {
    match kind {
        Kind::Generic => Type::Generic,
        Kind::Expanding { .. } => Type::Expanding,
        Kind::StayAwake => Type::StayAwake,
        Kind::ManualShutdown { .. } => Type::ManualShutdown,
        Kind::Cleanup => Type::Cleanup,
    }
}

fn kind(kind: Kind, element: &mut Build<'_, '_>) {
    match kind {
        Kind::Expanding { minimum } => {
            element.set("minimum", show::span(minimum));
        }
        Kind::ManualShutdown { shutdown, wakeup } => {
            element.set("shutdown", show::span(shutdown)).set("wakeup", show::span(wakeup));
        }
        Kind::Generic | Kind::StayAwake | Kind::Cleanup => {}
    }
}

/// When it can start, and after what.
fn times(activity: &Activity, element: &mut Build<'_, '_>) {
    for range in &activity.starts {
        element.add(&schema::START, |start| {
            start.time("from", range.from).time("to", range.to).time("cutoff", range.cutoff);
        });
    }
    for after in &activity.after {
        let statuses: Vec<_> = after.statuses.iter().map(|one| word(*one, &STATUSES)).collect();
        element.add(&schema::AFTER, |element| {
            element.set("activity", after.prior.get().to_string());
            element.set("status", statuses.join(" "));
        });
    }
}

/// Variables and timelines.
fn named(activity: &Activity, element: &mut Build<'_, '_>) {
    for condition in &activity.conditions {
        element.add(&schema::CONDITION, |element| {
            element.set("kind", word(condition.kind, &VARIABLES));
            element.set("variable", &condition.name).limits(condition.min, condition.max);
        });
    }
    for impact in &activity.impacts {
        let (effect, amount) = effect(impact.effect);
        element.add(&schema::IMPACT, |element| {
            element.set("timeline", &impact.timeline).set(effect, amount.to_string());
        });
    }
    for constraint in &activity.constraints {
        element.add(&schema::CONSTRAINT, |element| {
            element.set("timeline", &constraint.timeline).limits(constraint.min, constraint.max);
        });
    }
}

const fn effect(effect: Effect) -> (&'static str, i64) {
    match effect {
        Effect::SetAtStart(value) => ("set_at_start", value),
        Effect::SetAtEnd(value) => ("set_at_end", value),
        Effect::Hold(amount) => ("hold", amount),
        Effect::AddAtStart(amount) => ("add_at_start", amount),
        Effect::AddAtEnd(amount) => ("add_at_end", amount),
        Effect::Rate(amount) => ("rate", amount),
    }
}
