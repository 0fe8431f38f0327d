//! A state.

use faregate_scheduler::format::Rule;
use faregate_scheduler::format::reading::Report;
use faregate_tickets::amount::Microjoules;

use crate::file::check::{About, PEAK_BELOW, clean, overflow, raise};
use crate::file::read::Placed;
use crate::file::schema;
use crate::file::xml::Element;
use crate::state::State;
use crate::units::Time;

pub(in crate::file) fn state(state: &Placed<'_, State, ()>, report: &mut Report<'_>) {
    let before = report.found.len();
    let Placed { value, root, .. } = state;
    let mut about = About::new(root, "the state".into(), report);
    if value.capacity == Microjoules::ZERO {
        about.error("capacity", Rule::Range, "the battery holds nothing", "more than 0 Wh");
    } else if value.charge > value.capacity {
        let message = "the battery has more than it can hold";
        about.error("charge", Rule::Limits, message, "at most capacity");
    }
    past(value.mode_since, value, root, "mode_since", &mut about);
    for (index, since) in value.heating.values().enumerate() {
        past(*since, value, root.nth(schema::HEATING.name, index), "since", &mut about);
    }
    for (index, ended) in value.ended.iter().enumerate() {
        let element = root.nth(schema::ENDED.name, index);
        past(ended.ended, value, element, "ended", &mut about);
    }
    for (index, running) in value.running.iter().enumerate() {
        let element = root.nth(schema::RUNNING.name, index);
        past(running.started, value, element, "started", &mut about);
        let Some(paused) = running.paused else { continue };
        past(paused, value, element, "paused", &mut about);
        if paused < running.started {
            let message = "it was paused before it started";
            about.error_at(element, "paused", Rule::Window, message, "not before started");
        }
    }
    for (index, window) in value.windows.iter().enumerate() {
        if window.peak < window.marginal {
            let element = root.nth(schema::WINDOW.name, index);
            let help = Some(raise(window.marginal));
            about.warn_at(element, "peak", Rule::Limits, PEAK_BELOW, help);
        }
    }
    if clean(report, before) {
        overflow::state(value, root, report);
    }
}

/// What has happened has happened by now.
fn past(at: Time, state: &State, element: &Element<'_>, name: &str, about: &mut About<'_, '_, '_>) {
    if at > state.now {
        let message = "what has happened is after now";
        about.error_at(element, name, Rule::Window, message, "not after now");
    }
}
