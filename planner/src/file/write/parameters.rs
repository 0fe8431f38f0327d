//! Parameters as elements.

use crate::file::names::Names;
use crate::file::schema::{self, Known};
use crate::file::words::{TIMELINES, word};
use crate::file::write::Build;
use crate::file::xml::Element;
use crate::file::{VERSION, show, times};
use crate::parameters::{Parameters, Phase};

pub(super) fn parameters(parameters: &Parameters) -> Element<'static> {
    let names = Names::new(None);
    let mut root = Build::new(&schema::PARAMETERS, &names);
    root.set("version", VERSION.to_string())
        .set("mandatory_from", parameters.mandatory_from.to_string())
        .set("soft_min_soc", show::fraction(parameters.soft_min_soc))
        .set("hard_min_soc", show::fraction(parameters.hard_min_soc))
        .set("max_soc", show::fraction(parameters.max_soc))
        .set("peak_limit", show::power(parameters.peak_limit))
        .set("engines", parameters.engines.to_string())
        .set("rtg", show::power(parameters.rtg))
        .set("base", show::power(parameters.base))
        .set("min_awake", show::span(parameters.min_awake))
        .set("min_sleep", show::span(parameters.min_sleep))
        .set("commit", show::span(parameters.commit))
        .set("expansion_grace", show::span(parameters.expansion_grace))
        .set("handover_tolerance", show::span(parameters.handover_tolerance))
        .set("soft_samples", parameters.soft_samples.to_string());
    root.add(&schema::AWAKE, |awake| {
        awake.load(parameters.awake);
    });
    phase(&mut root, &schema::WAKEUP, parameters.wakeup);
    phase(&mut root, &schema::SHUTDOWN, parameters.shutdown);
    root.add(&schema::DAY, |day| {
        day.set("length", show::span(parameters.day.length));
        // In seconds: a time of day means nothing before this is read.
        day.time("midnight", parameters.day.midnight);
    });
    named(parameters, &mut root);
    root.element
}

fn phase(root: &mut Build<'_, '_>, known: &Known, phase: Phase) {
    root.add(known, |element| {
        element.set("duration", show::span(phase.duration)).load(phase.load);
    });
}

/// Zones, timelines and resources.
fn named(parameters: &Parameters, root: &mut Build<'_, '_>) {
    for zone in &parameters.zones {
        root.add(&schema::ZONE, |element| {
            element.set("name", &zone.name).load(zone.load);
            for row in &zone.table {
                element.add(&schema::PREHEAT, |element| {
                    element.set("from", times::shown_clock(row.from));
                    element.set("duration", show::span(row.duration));
                });
            }
        });
    }
    for timeline in &parameters.timelines {
        root.add(&schema::TIMELINE, |element| {
            element
                .set("name", &timeline.name)
                .set("kind", word(timeline.kind, &TIMELINES))
                .set("initial", timeline.initial.to_string())
                .limits(timeline.min, timeline.max);
        });
    }
    for (name, bit) in &parameters.resources {
        root.add(&schema::RESOURCE, |element| {
            element.set("name", name).set("bit", bit.to_string());
        });
    }
}
