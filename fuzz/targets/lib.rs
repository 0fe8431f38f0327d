//! What the targets share: a file is read, and what came of it is held to what
//! is promised.

use std::sync::LazyLock;

use faregate_planner::file::{self, Document, template};
use faregate_planner::{Parameters, Plan, State};
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

/// What plans and states are read with, and judged by.
static KNOWN: LazyLock<(Parameters, Plan, State)> = LazyLock::new(|| {
    let parameters = file::parameters("parameters", template::PARAMETERS.as_bytes());
    let parameters = parameters.expect("the template is good").value;
    let plan = file::plan("plan", template::PLAN.as_bytes(), Some(&parameters));
    let state = file::state("state", template::STATE.as_bytes(), Some(&parameters));
    let (plan, state) = (plan.expect("it is good").value, state.expect("it is good").value);
    (parameters, plan, state)
});

/// Reads a file of the planner with and without parameters, and checks what
/// comes of it.
pub fn plan(name: &str, bytes: &[u8]) {
    for parameters in [Some(&KNOWN.0), None] {
        match file::read(name, bytes, parameters) {
            Ok(loaded) => {
                told(&loaded.warnings, bytes);
                same(&loaded.value, parameters);
                together(&loaded.value, name, bytes);
            }
            Err(found) => {
                assert!(found.iter().any(Diagnostic::is_error), "nothing is loaded, and why?");
                told(&found, bytes);
            }
        }
    }
}

/// What was loaded can be written in both forms, and is the same when it is
/// read again.
fn same(document: &Document, parameters: Option<&Parameters>) {
    let xml = file::to_xml(document, parameters);
    let again = file::read("written", xml.as_bytes(), parameters).map(|loaded| loaded.value);
    assert_eq!(again.as_ref(), Ok(document), "{xml}");
    let compact = file::to_binary(document);
    let again = file::read("written", &compact, parameters).map(|loaded| loaded.value);
    assert_eq!(again.as_ref(), Ok(document), "{xml}");
    assert_eq!(file::differences(document, document, parameters), Some(Vec::new()));
}

/// With what it would be made with. Changes are told whatever they are.
fn together(document: &Document, name: &str, bytes: &[u8]) {
    let (parameters, plan, state) = &*KNOWN;
    let (other, found) = match document {
        Document::Plan(one) => {
            let at = ("state", template::STATE.as_bytes());
            told(&file::together(one, parameters, state, at), at.1);
            (Document::Plan(plan.clone()), Vec::new())
        }
        Document::State(one) => {
            let found = file::together(plan, parameters, one, (name, bytes));
            (Document::State(state.clone()), found)
        }
        Document::Parameters(one) => {
            let at = ("state", template::STATE.as_bytes());
            told(&file::together(plan, one, state, at), at.1);
            (Document::Parameters(parameters.clone()), Vec::new())
        }
    };
    told(&found, bytes);
    let changes = file::differences(&other, document, Some(parameters)).expect("of one kind");
    assert_eq!(changes.is_empty(), other == *document, "{changes:?}");
}
