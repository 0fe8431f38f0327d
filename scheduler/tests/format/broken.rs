//! Good files in which some fields are broken: those are told, and nothing
//! else.

use faregate_scheduler::format::{self, Kind};
use proptest::prelude::*;
use proptest::sample::{Index, subsequence};

/// A piece of a file, and how it can be broken.
struct Piece {
    text: String,
    /// At most one piece of a group is broken: what is wrong with one may leave
    /// another without a meaning.
    group: Option<usize>,
    /// What stands there then, and how far from its start the mistake is.
    broken: Vec<(String, usize)>,
}

/// A good file.
#[derive(Default)]
struct Good {
    pieces: Vec<Piece>,
    groups: usize,
}

impl Good {
    fn plain(&mut self, text: impl Into<String>) {
        self.pieces.push(Piece { text: text.into(), group: None, broken: Vec::new() });
    }

    /// A group of its own.
    fn field(&mut self, text: impl Into<String>, broken: &[&str]) {
        self.groups += 1;
        self.also(text, broken);
    }

    /// One more of the group before.
    fn also(&mut self, text: impl Into<String>, broken: &[&str]) {
        self.of_group(self.groups - 1, text, broken);
    }

    fn of_group(&mut self, group: usize, text: impl Into<String>, broken: &[&str]) {
        let broken = broken.iter().map(|text| ((*text).to_owned(), 0)).collect();
        self.pieces.push(Piece { text: text.into(), group: Some(group), broken });
    }

    /// The text with one piece of each chosen group broken, and where that is.
    fn broken(&self, groups: &[usize], choices: &[Index]) -> (String, Vec<(usize, usize)>) {
        let chosen: Vec<(usize, &(String, usize))> = groups
            .iter()
            .zip(choices)
            .map(|(group, choice)| {
                let all: Vec<_> = (self.pieces.iter().enumerate())
                    .filter(|(_, piece)| piece.group == Some(*group))
                    .flat_map(|(at, piece)| piece.broken.iter().map(move |way| (at, way)))
                    .collect();
                *choice.get(&all)
            })
            .collect();
        let (mut text, mut places) = (String::new(), Vec::new());
        for (at, piece) in self.pieces.iter().enumerate() {
            match chosen.iter().find(|(chosen, _)| *chosen == at) {
                None => text.push_str(&piece.text),
                Some((_, (broken, offset))) => {
                    let line = text.matches('\n').count() + 1;
                    let column = text.len() - text.rfind('\n').map_or(0, |end| end + 1) + 1;
                    places.push((line, column + offset));
                    text.push_str(broken);
                }
            }
        }
        (text, places)
    }
}

/// A row of SMAARTE's, with this between its fields.
fn row(good: &mut Good, id: usize, between: &str, txt: bool) {
    let numbers = ["x", "-1", "1e3", "99999999999999999999999"];
    let first = ["0", "x", "-4", "1.5", "4294967296", "1"];
    // Nobody can have the number of the first one, which keeps it.
    if id == 1 {
        good.plain("1");
    } else {
        good.field(id.to_string(), &first);
    }
    let next = |good: &mut Good, text: &str, broken: &[&str]| {
        good.plain(between);
        good.field(text, broken);
    };
    next(good, "+100", &["soon", "-5", "+", "++1", "2026-03-01T00:00:00Z"]);
    good.plain(between);
    good.also("+200", &["later", "+50", "+x"]);
    next(good, "3.5", &numbers);
    next(good, "0x5", &["0y5", "-1", "340282366920938463463374607431768211456", "everything"]);
    next(good, "7", &["240", "-1", "high", "1.0"]);
    next(good, "0", &["7", "15", "65536", "run"]);
    let type_group = good.groups - 1;
    next(good, "60", &numbers);
    next(good, "5", &["x", "-2"]);
    next(good, "kill:2", &["stop", "kill:x", "pause:3", "checkpoint:1:SIGKILL"]);
    let args = if txt { &["'take", "''"][..] } else { &["'take", "", "''", "take \\"][..] };
    // What arguments mean depends on the type.
    good.plain(between);
    good.of_group(type_group, "take 1", args);
    good.plain("\n");
}

const COLUMNS: [&str; 11] =
    ["id", "st", "et", "dur", "con", "pri", "type", "interval", "gap", "preempt", "args"];

/// Thirty tasks, of which the last five can be cut short or have too much.
fn rows(between: &str, txt: bool) -> Good {
    let mut good = Good::default();
    good.plain(COLUMNS.join(between) + "\n");
    for id in 1..=25 {
        row(&mut good, id, between, txt);
    }
    for id in 26..=30 {
        let whole = format!("{id} 0 0 3 1 1 0 0 5 wait").replace(' ', between);
        let cut = format!("{id} 0 0 3").replace(' ', between);
        good.field(format!("{whole}{between}take"), &[]);
        let broken = &mut good.pieces.last_mut().unwrap().broken;
        broken.push((cut.clone(), cut.len()));
        if !txt {
            let more = format!("{whole},take 1");
            broken.push((format!("{more},2"), more.len() + 1));
        }
        good.plain("\n");
    }
    good
}

/// Keys and values; one of the two is broken.
fn keys(good: &mut Good, all: &[(&str, &str, &[&str])]) {
    for (key, value, broken) in all {
        // Without `run` the task would do nothing, which is another mistake.
        let unknown = [format!("{key}_x"), format!("\"{key} \"")];
        let unknown = unknown.each_ref().map(String::as_str);
        good.field(*key, if *key == "run" { &[] } else { &unknown });
        good.plain(" = ");
        good.also(*value, broken);
        good.plain("\n");
    }
}

fn native() -> Good {
    let mut good = Good::default();
    good.plain("[mission]\n");
    keys(
        &mut good,
        &[
            ("memory", "\"3MiB\"", &["\"much\"", "-1", "true", "[1]"]),
            ("lease", "\"2s\"", &["\"2 parsecs\"", "-2", "1e3"]),
        ],
    );
    good.plain("[mission.battery]\nlow = ");
    good.field("10", &["101", "-1", "\"low\""]);
    good.plain("\n[mission.categories]\ncamera = ");
    good.field("0", &["128", "-1", "\"first\"", "1.5"]);
    good.plain("\n[[mission.agent]]\nname = ");
    good.field("\"power\"", &["\"\"", "7", "true"]);
    good.plain("\nsupply_w = ");
    good.field("42.5", &["-42", "\"much\"", "0.0001"]);
    good.plain("\n[[mission.device]]\nname = ");
    good.field("\"camera\"", &["\"\"", "[]"]);
    good.plain("\nkind = \"camera\"\nagent = ");
    good.field("\"power\"", &["3", "\"\""]);
    good.plain("\n[[mission.mode]]\nname = \"safe\"\nfloor = ");
    good.field("200", &["240", "\"high\""]);
    good.plain("\n");
    for id in 1..=25 {
        native_task(&mut good, id);
    }
    good
}

fn native_task(good: &mut Good, id: usize) {
    good.plain("[[task]]\nid = ");
    if id == 1 {
        good.plain("1");
    } else {
        good.field(id.to_string(), &["0", "-4", "1", "\"x\"", "4294967296", "1.5"]);
    }
    good.plain("\n");
    keys(
        good,
        &[
            ("name", "\"a\"", &["\"\"", "3"]),
            ("run", "\"take 1\"", &["\"take '\"", "\"\"", "[]", "[\"take\", 1]", "3"]),
            (
                "st",
                "2026-03-01T12:00:00Z",
                &["2026-03-01", "\"soon\"", "-1", "\"2026-13-01T00:00:00Z\""],
            ),
            ("et", "0", &["\"later\"", "+5", "true"]),
            ("interval", "\"20min\"", &["\"20 parsecs\"", "-1", "\"-20min\""]),
            ("dur", "3.5", &["-3", "\"long\"", "0.0000001", "nan", "inf"]),
            ("gap", "1", &["[]", "{}", "\"x\""]),
            ("pri", "7", &["240", "-1", "\"7\"", "7.5"]),
            ("power", "20", &["101", "true"]),
            ("draw_w", "4.5", &["-1", "\"4\"", "0.0001"]),
            ("preempt", "\"checkpoint\"", &["\"stop\"", "3"]),
            ("overrun", "\"abort\"", &["\"shout\"", "false"]),
            ("heartbeat", "5", &["0", "\"x\""]),
            ("after", "[]", &["1", "\"x\""]),
            ("mandatory", "true", &["1", "\"yes\""]),
        ],
    );
    good.plain("con = [");
    good.field("\"camera\"", &["128", "true", "-1"]);
    good.plain("]\n");
}

fn told(kind: Kind, text: &str) -> Vec<(usize, usize)> {
    let options = format::Options { kind: Some(kind), ..format::Options::default() };
    let found = format::read_with(options, "broken", text.as_bytes()).err().unwrap_or_default();
    let errors = found.iter().filter(|one| one.is_error());
    errors.map(|one| (one.place.line, one.place.column)).collect()
}

/// Which groups are broken, and how.
fn breaks(groups: usize) -> impl Strategy<Value = (Vec<usize>, Vec<Index>)> {
    let chosen = subsequence((0..groups).collect::<Vec<_>>(), 1..=20);
    (chosen, proptest::collection::vec(any::<Index>(), 20))
}

fn check(
    kind: Kind,
    good: &Good,
    groups: &[usize],
    choices: &[Index],
) -> Result<(), TestCaseError> {
    let (text, places) = good.broken(groups, choices);
    prop_assert_eq!(places.len(), groups.len());
    prop_assert_eq!(told(kind, &text), places, "{}", text);
    Ok(())
}

#[test]
fn what_is_broken_here_was_good() {
    for (kind, good) in
        [(Kind::Csv, rows(",", false)), (Kind::Txt, rows(" ", true)), (Kind::Toml, native())]
    {
        let text = good.broken(&[], &[]).0;
        assert_eq!(told(kind, &text), [], "{text}");
        assert!(good.groups > 100);
    }
}

proptest! {
    #[test]
    fn exactly_what_is_broken_in_a_file_with_commas_is_told(
        (groups, choices) in breaks(rows(",", false).groups),
    ) {
        check(Kind::Csv, &rows(",", false), &groups, &choices)?;
    }

    #[test]
    fn exactly_what_is_broken_in_a_file_with_spaces_is_told(
        (groups, choices) in breaks(rows(" ", true).groups),
    ) {
        check(Kind::Txt, &rows(" ", true), &groups, &choices)?;
    }

    #[test]
    fn exactly_what_is_broken_in_a_native_file_is_told(
        (groups, choices) in breaks(native().groups),
    ) {
        check(Kind::Toml, &native(), &groups, &choices)?;
    }
}
