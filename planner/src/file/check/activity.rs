//! One activity.

use faregate_scheduler::format::Rule;
use faregate_tickets::amount::Microjoules;

use crate::file::check::{About, PEAK_BELOW, raise};
use crate::file::names::Names;
use crate::file::show;
use crate::parameters::{Parameters, TimelineKind};
use crate::plan::{Activity, Effect, Kind, Plan, StartRange, Status};
use crate::units::Span;

pub(super) fn activity(
    activity: &Activity,
    plan: Option<&Plan>,
    names: &Names<'_>,
    about: &mut About<'_, '_, '_>,
) {
    durations(activity, about);
    ranges(activity, about);
    if let Some(plan) = plan {
        within(activity, plan, about);
    }
    energy(activity, about);
    peak(activity, about);
    kind(activity, about);
    timelines(activity, names, about);
    if let Some(parameters) = names.parameters {
        limits(activity, parameters, about);
        if let Some(plan) = plan {
            data(activity, plan, parameters, about);
        }
    }
}

fn durations(activity: &Activity, about: &mut About<'_, '_, '_>) {
    if activity.duration <= Span::ZERO {
        about.error("duration", Rule::Range, "it takes no time", "more than 0 ms");
    }
    match activity.kind {
        Kind::Expanding { minimum } if minimum > activity.duration => {
            let message = "its shortest duration is longer than its longest";
            about.error("minimum", Rule::Limits, message, "at most the duration");
        }
        Kind::Expanding { minimum } if minimum <= Span::ZERO => {
            about.error("minimum", Rule::Range, "its shortest duration is none", "more than 0 ms");
        }
        Kind::ManualShutdown { shutdown, wakeup }
            if shutdown.get().saturating_add(wakeup.get()) > activity.duration.get() =>
        {
            let message = "shutdown and wakeup take longer than the whole";
            about.error("duration", Rule::Limits, message, "at least shutdown and wakeup together");
        }
        _ => {}
    }
}

/// What needs the plan's own limits to be known.
fn within(activity: &Activity, plan: &Plan, about: &mut About<'_, '_, '_>) {
    let ends = |range: &StartRange| range.from.after(activity.placed());
    if !activity.starts.iter().any(|range| ends(range) <= plan.end) {
        let message = "it cannot be over by the end of the plan";
        about.warn("", Rule::NeverRuns, message, None);
    }
}

fn ranges(activity: &Activity, about: &mut About<'_, '_, '_>) {
    let shortest = activity.placed();
    for (index, range) in activity.starts.iter().enumerate() {
        let element = about.element.nth("start", index);
        if range.from.after(shortest) > range.cutoff {
            let message = "from the earliest start to the cutoff is less than it takes";
            let expected = format!("at least {} after from", show::span(shortest));
            about.error_at(element, "cutoff", Rule::Window, message, expected);
        }
        let before = index.checked_sub(1).and_then(|index| activity.starts.get(index));
        if before.is_some_and(|before| before.from > range.from) {
            let message = "a start range begins before the one in front of it";
            let help = Some("where two admit the same start, the first in the file counts".into());
            about.warn_at(element, "from", Rule::Window, message, help);
        }
    }
}

/// What the ground says as power and as energy must be about the same.
fn energy(activity: &Activity, about: &mut About<'_, '_, '_>) {
    let Some(energy) = activity.energy else { return };
    let product = i128::from(activity.marginal.get()) * i128::from(activity.duration.get());
    let difference = (i128::from(energy.get()) - product).abs();
    if difference * 100 > product {
        let message = "its energy is not its average power times its duration";
        let product = u64::try_from(product).map(Microjoules::new);
        let expected = match product {
            Ok(product) => format!("{}, within 1 %", show::energy(product)),
            Err(_) => "a power and a duration that can be multiplied".to_owned(),
        };
        about.error("energy", Rule::Energy, message, expected);
    }
}

/// What draws more on average than at most.
fn peak(activity: &Activity, about: &mut About<'_, '_, '_>) {
    let Activity { marginal, peak, .. } = activity;
    if peak < marginal {
        about.warn("peak", Rule::Limits, PEAK_BELOW, Some(raise(*marginal)));
    }
}

fn kind(activity: &Activity, about: &mut About<'_, '_, '_>) {
    match activity.kind {
        Kind::Cleanup if !activity.after.iter().any(|one| waits_for_failure(&one.statuses)) => {
            let message = "a cleanup waits for no activity to fail or to be aborted";
            about.error(
                "",
                Rule::Kind,
                message,
                "<after activity=\"..\" status=\"FAILED ABORTED\"/>",
            );
        }
        Kind::ManualShutdown { .. } if uses_something(activity) => {
            let message = "a manual shutdown is placed before everything, and uses nothing";
            about.warn("", Rule::NoEffect, message, Some("leave its uses out".into()));
        }
        _ => {}
    }
}

fn waits_for_failure(statuses: &[Status]) -> bool {
    statuses.iter().any(|one| matches!(one, Status::Failed | Status::Aborted))
}

fn uses_something(activity: &Activity) -> bool {
    !activity.marginal.is_zero()
        || !activity.peak.is_zero()
        || activity.data.get() != 0
        || activity.engines != 0
        || !activity.resources.is_empty()
        || !activity.zones.is_empty()
        || !activity.after.is_empty()
        || !activity.impacts.is_empty()
        || !activity.constraints.is_empty()
        || activity.group.is_some()
        || activity.sequence.is_some()
}

/// What it does to timelines must be what can be done to them.
fn timelines(activity: &Activity, names: &Names<'_>, about: &mut About<'_, '_, '_>) {
    for (index, impact) in activity.impacts.iter().enumerate() {
        let element = about.element.nth("impact", index);
        if let Effect::Hold(amount) = impact.effect
            && amount <= 0
        {
            about.error_at(element, "hold", Rule::Range, "it holds nothing", "1 or more");
        }
        let Some(timeline) = names.timeline_of(&impact.timeline) else { continue };
        if !can_do(impact.effect, timeline.kind) {
            let message = format!("this cannot be done to {}", timeline.name);
            let expected = match timeline.kind {
                TimelineKind::State => "set_at_start or set_at_end, for a state",
                TimelineKind::Unit => "hold, for a unit",
                TimelineKind::Renewable => "hold, for a renewable",
                TimelineKind::Consumable => "add_at_start, add_at_end or rate, for a consumable",
            };
            about.error_at(element, "timeline", Rule::Kind, &message, expected);
        }
    }
    for (index, constraint) in activity.constraints.iter().enumerate() {
        let Some(timeline) = names.timeline_of(&constraint.timeline) else { continue };
        if constraint.min > timeline.max || constraint.max < timeline.min {
            let element = about.element.nth("constraint", index);
            let message = format!("{} never has such a value", timeline.name);
            about.warn_at(element, "timeline", Rule::NeverRuns, &message, None);
        }
    }
}

const fn can_do(effect: Effect, kind: TimelineKind) -> bool {
    matches!(
        (effect, kind),
        (Effect::SetAtStart(_) | Effect::SetAtEnd(_), TimelineKind::State)
            | (Effect::Hold(_), TimelineKind::Unit | TimelineKind::Renewable)
            | (
                Effect::AddAtStart(_) | Effect::AddAtEnd(_) | Effect::Rate(_),
                TimelineKind::Consumable
            )
    )
}

/// What is more than there is never fits.
fn limits(activity: &Activity, parameters: &Parameters, about: &mut About<'_, '_, '_>) {
    let with_computer = activity.peak.saturating_add(parameters.awake.peak);
    if !matches!(activity.kind, Kind::ManualShutdown { .. })
        && with_computer > parameters.peak_limit
    {
        let message = format!(
            "its peak and the computer's are {}, above the limit of {}",
            show::power(with_computer),
            show::power(parameters.peak_limit)
        );
        about.warn("peak", Rule::NeverRuns, &message, None);
    }
    if activity.engines > parameters.engines {
        let message = format!("there are {} sequence engines", parameters.engines);
        about.warn("engines", Rule::NeverRuns, &message, None);
    }
}

/// Mandatory activities may exceed it.
fn data(activity: &Activity, plan: &Plan, parameters: &Parameters, about: &mut About<'_, '_, '_>) {
    let optional = activity.priority < parameters.mandatory_from;
    if optional && activity.data.get() > 0 && activity.data > plan.max_delta_data {
        let message = format!(
            "it is optional, and makes more data than the plan's {}",
            show::data(plan.max_delta_data)
        );
        about.warn("data", Rule::NeverRuns, &message, None);
    }
}
