//! What became another when it was written and read again.

use crate::format::native::keys;
use crate::format::write::{NotHeld, native};
use crate::format::{self, Kind, Options};
use crate::mission::Mission;
use crate::task::Task;

/// Which fields are not the same, by their keys.
pub(crate) fn of_tasks(one: &Task, other: &Task) -> Vec<&'static str> {
    let windows = if one.windows.len() > 1 { "window" } else { "st" };
    let body = keys::BODY.first().copied().unwrap_or("run");
    let fields = [
        ("id", one.id == other.id),
        ("name", one.name == other.name),
        (windows, one.windows == other.windows),
        ("cutoff", one.cutoff == other.cutoff),
        ("dur", one.duration == other.duration),
        ("dur_min", one.spread == other.spread),
        ("con", one.categories == other.categories),
        ("pri", one.priority == other.priority),
        ("interval", one.interval == other.interval),
        (body, one.body == other.body),
        ("memory", one.memory == other.memory),
        ("storage", one.storage == other.storage),
        ("power", one.battery == other.battery),
        ("draw_w", one.peak_draw == other.peak_draw),
        ("average_draw_w", one.average_draw == other.average_draw),
        ("data", one.data == other.data),
        ("gates", one.gates == other.gates),
        ("gap", one.gap == other.gap),
        ("preempt", one.preemption == other.preemption),
        ("restart", one.restart == other.restart),
        ("overrun", one.overrun == other.overrun),
        ("heartbeat", one.heartbeat == other.heartbeat),
        ("after", one.after == other.after),
        ("cleanup", one.cleanup == other.cleanup),
        ("mandatory", one.mandatory == other.mandatory),
    ];
    fields.into_iter().filter(|(_, same)| !same).map(|(field, _)| field).collect()
}

/// Why a field is lost.
pub(crate) fn why(kind: Kind, field: &str) -> String {
    match (kind, field) {
        (Kind::Toml, _) => "the native format cannot say this value".to_owned(),
        (_, "window") => "one window alone has columns: the first was written".to_owned(),
        (_, "st" | "cutoff") => "a time before 1970 has no number: 0 was written".to_owned(),
        (_, "gates") => "a name has a separator or a quote in it".to_owned(),
        _ => "there is no column for it".to_owned(),
    }
}

/// Whether the mission can be read again as it is.
pub(crate) fn of_mission(kind: Kind, mission: &Mission, lost: &mut Vec<NotHeld>) {
    if kind != Kind::Toml {
        let why = "SMAARTE's files have no mission".to_owned();
        lost.push(NotHeld { task: None, field: "mission", why });
        return;
    }
    let text = native::write(&[], Some(mission), None);
    let options = Options { kind: Some(kind), ..Options::default() };
    let again = format::read_with(options, "", text.as_bytes());
    if again.ok().and_then(|again| again.mission).as_ref() != Some(mission) {
        let why = "the native format cannot say all of it".to_owned();
        lost.push(NotHeld { task: None, field: "mission", why });
    }
}
