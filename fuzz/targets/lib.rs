//! What the targets share: a file is read, and what came of it is held to what
//! is promised.

use faregate_scheduler::Mission;
use faregate_scheduler::format::{
    Against, Conflict, Diagnostic, Kind, Loaded, Options, read_with, render, write,
};

/// Reads a file in every way, and checks what comes of it.
pub fn schedule(kind: Kind, bytes: &[u8]) {
    let name = format!("fuzzed.{}", format!("{kind:?}").to_lowercase());
    assert_eq!(Kind::of(&name), Some(kind));
    let mission = Mission { memory: Some(1_000), ..Mission::default() };
    let ways = [
        (Conflict::Mask, Against::Own, true),
        (Conflict::Number, Against::Nothing, false),
        (Conflict::Mask, Against::Mission(&mission), true),
    ];
    for (conflict, against, whole) in ways {
        let options = Options { kind: None, conflict, against, whole };
        match read_with(options, &name, bytes) {
            Ok(loaded) => {
                told(&loaded.warnings, bytes);
                held(&loaded);
            }
            Err(found) => {
                assert!(found.iter().any(Diagnostic::is_error), "nothing is loaded, and why?");
                told(&found, bytes);
            }
        }
    }
}

/// Each message has a place in the file, and can be shown.
fn told(found: &[Diagnostic], bytes: &[u8]) {
    let lines = bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() + 1;
    for one in found {
        let place = &one.place;
        assert!((1..=lines).contains(&place.line) && place.column >= 1, "{one}");
        assert!(!one.to_string().contains(char::is_control), "a terminal would obey this");
        assert!(place.span.start <= place.span.end && place.span.end <= bytes.len(), "{one}");
    }
    let tools = serde_json::to_string(found).expect("tools can be told");
    assert!(tools.matches("\"severity\":").count() >= found.len());
    let some = found.get(..found.len().min(20)).unwrap_or_default();
    let shown = render(some, bytes, false);
    assert!(!shown.contains('\u{1b}'), "a terminal would obey this");
}

/// What was loaded can be written, and is the same when it is read again.
fn held(loaded: &Loaded) {
    let (text, lost) = write(Kind::Toml, &loaded.tasks, loaded.mission.as_ref());
    assert!(lost.is_empty(), "{lost:?}\n{loaded:?}");
    let again = again(Kind::Toml, &text);
    assert_eq!((&again.tasks, &again.mission), (&loaded.tasks, &loaded.mission), "{text}");
    for kind in [Kind::Csv, Kind::Txt] {
        let (text, lost) = write(kind, &loaded.tasks, None);
        let left_out = lost.iter().filter(|one| one.field == "task").count();
        assert_eq!(self::again(kind, &text).tasks.len() + left_out, loaded.tasks.len(), "{text}");
    }
}

fn again(kind: Kind, text: &str) -> Loaded {
    let options =
        Options { kind: Some(kind), against: Against::Nothing, whole: false, ..Options::default() };
    read_with(options, "written", text.as_bytes())
        .unwrap_or_else(|found| panic!("{}\n{text}", render(&found, text.as_bytes(), false)))
}
