//! Parameters.

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::Report;

use crate::file::check::{About, PEAK_BELOW, clean, overflow, raise};
use crate::file::read::Placed;
use crate::file::{schema, show, times};
use crate::parameters::{Load, Parameters, Zone};
use crate::units::Span;

pub(in crate::file) fn parameters(
    parameters: &Placed<'_, Parameters, ()>,
    report: &mut Report<'_>,
) {
    let before = report.found.len();
    let Placed { value, root, .. } = parameters;
    let mut about = About::new(root, "the parameters".into(), report);
    if value.hard_min_soc > value.soft_min_soc {
        let message = "the hard minimum is above the soft one";
        about.error("hard_min_soc", Rule::Limits, message, "at most soft_min_soc");
    }
    if value.soft_min_soc > value.max_soc {
        let message = "the soft minimum is above the maximum";
        about.error("soft_min_soc", Rule::Limits, message, "at most max_soc");
    }
    if value.soft_samples == 0 {
        let message = "no estimate at all aborts nothing";
        about.error("soft_samples", Rule::Range, message, "1 or more");
    }
    peaks(value, &mut about);
    for (index, zone) in value.zones.iter().enumerate() {
        let element = root.nth(schema::ZONE.name, index);
        let who = format!("zone {}", zone.name);
        if zone.load.peak < zone.load.marginal {
            let mut about = About::new(element, who.clone(), report);
            about.warn("peak", Rule::Limits, PEAK_BELOW, Some(raise(zone.load.marginal)));
        }
        table(zone, value.day.length, &mut About::new(element, who, report));
    }
    for (index, timeline) in value.timelines.iter().enumerate() {
        if timeline.initial < timeline.min || timeline.initial > timeline.max {
            let element = root.nth(schema::TIMELINE.name, index);
            let who = format!("timeline {}", timeline.name);
            let mut about = About::new(element, who, report);
            about.error("initial", Rule::Limits, "its first value is out of range", "min to max");
        }
    }
    if clean(report, before) {
        overflow::parameters(value, root, report);
    }
}

/// What the planner itself brings must fit beside nothing else.
fn peaks(value: &Parameters, about: &mut About<'_, '_, '_>) {
    let loads =
        [("awake", value.awake), ("wakeup", value.wakeup.load), ("shutdown", value.shutdown.load)];
    for (name, Load { marginal, peak }) in loads {
        let element = about.element.nth(name, 0);
        if peak < marginal {
            about.warn_at(element, "peak", Rule::Limits, PEAK_BELOW, Some(raise(marginal)));
        }
        if peak > value.peak_limit {
            let message = format!(
                "{name} alone has a peak of {}, above the limit: nothing ever runs",
                show::power(peak)
            );
            about.warn_at(element, "peak", Rule::NeverRuns, &message, None);
        }
    }
}

/// Rows in order from 0, inside the day.
fn table(zone: &Zone, day: Span, about: &mut About<'_, '_, '_>) {
    let Some(first) = zone.table.first() else {
        let expected = "one <preheat from=\"00:00\" duration=\"..\"/> or more";
        about.error("", Rule::Table, "nothing says how long heating takes", expected);
        return;
    };
    if first.from != Span::ZERO {
        let element = about.element.nth("preheat", 0);
        about.error_at(element, "from", Rule::Table, "the first row begins late", "00:00");
    }
    for (index, row) in zone.table.iter().enumerate() {
        let element = about.element.nth("preheat", index);
        let before = index.checked_sub(1).and_then(|index| zone.table.get(index));
        if let Some(before) = before
            && row.from <= before.from
        {
            let message = "a row does not begin after the one in front of it";
            let expected = format!("later than {}", times::shown_clock(before.from));
            about.error_at(element, "from", Rule::Table, message, expected);
        }
        if row.from >= day {
            let message = "a row begins when the day is over";
            let expected = format!("before {}", times::shown_clock(day));
            about.error_at(element, "from", Rule::Table, message, expected);
        }
    }
}
