//! A state as elements.

use faregate_tickets::amount::Milliwatts;

use crate::file::names::Names;
use crate::file::words::{MODES, OUTCOMES, word};
use crate::file::write::Build;
use crate::file::xml::Element;
use crate::file::{VERSION, schema, show};
use crate::state::{State, Window};
use crate::units::Bytes;

pub(super) fn state(state: &State, names: &Names<'_>) -> Element<'static> {
    let mut root = Build::new(&schema::STATE, names);
    root.set("version", VERSION.to_string())
        .time("now", state.now)
        .set("mode", word(state.mode, &MODES))
        .time("mode_since", state.mode_since)
        .set("charge", show::energy(state.charge))
        .set("capacity", show::energy(state.capacity));
    named(state, &mut root);
    activities(state, &mut root);
    for one in &state.windows {
        root.add(&schema::WINDOW, |element| window(one, element));
    }
    root.element
}

/// Zones, variables and timelines.
fn named(state: &State, root: &mut Build<'_, '_>) {
    for (zone, since) in &state.heating {
        root.add(&schema::HEATING, |element| {
            element.set("zone", zone).time("since", *since);
        });
    }
    for zone in &state.cold {
        root.add(&schema::COLD, |element| {
            element.set("zone", zone);
        });
    }
    for (name, value) in &state.variables {
        root.add(&schema::VARIABLE, |element| {
            element.set("name", name).set("value", value.to_string());
        });
    }
    for (name, value) in &state.timelines {
        root.add(&schema::VALUE, |element| {
            element.set("name", name).set("value", value.to_string());
        });
    }
}

fn activities(state: &State, root: &mut Build<'_, '_>) {
    for ended in &state.ended {
        root.add(&schema::ENDED, |element| {
            element
                .set("activity", ended.id.get().to_string())
                .set("outcome", word(ended.outcome, &OUTCOMES))
                .time_if("started", ended.started)
                .time("ended", ended.ended)
                .unless(Bytes::ZERO, "data", ended.data, show::data);
        });
    }
    for running in &state.running {
        root.add(&schema::RUNNING, |element| {
            element
                .set("activity", running.id.get().to_string())
                .time("started", running.started)
                .time("ends", running.ends)
                .time("cutoff", running.cutoff)
                .time_if("paused", running.paused)
                .unless(Bytes::ZERO, "data", running.data, show::data);
        });
    }
}

fn window(window: &Window, element: &mut Build<'_, '_>) {
    element
        .set("name", &window.name)
        .time("start", window.start)
        .time("end", window.end)
        .unless(false, "awake", window.awake, |awake| awake.to_string())
        .unless(Milliwatts::ZERO, "marginal", window.marginal, show::power)
        .unless(Milliwatts::ZERO, "peak", window.peak, show::power)
        .unless(Bytes::ZERO, "data", window.data, show::data)
        .unless(0, "engines", window.engines, |engines| engines.to_string());
    element.uses(window.resources);
}
