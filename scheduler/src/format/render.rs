//! Diagnostics as people read them: with the line that they are about.

use ariadne::{Color, Config, IndexType, Label, Report, ReportKind, Source};

use crate::format::diagnostic::{Diagnostic, Place, Severity};

/// The diagnostics of a file, each with the line that it is about.
///
/// `colour` is for whoever knows whether a terminal reads this. What the file
/// itself holds is shown without control characters, which a terminal would
/// obey.
#[must_use]
pub fn render(found: &[Diagnostic], bytes: &[u8], colour: bool) -> String {
    let text = Text::new(bytes);
    let source = Source::from(text.shown.as_str());
    let mut all = Vec::new();
    for one in found {
        if text.longest_of(one) > LONGEST_SHOWN {
            all.extend(without_its_line(one).into_bytes());
            continue;
        }
        let report = report(one, &text, colour);
        // Writing into memory cannot fail.
        let _ = report.write((one.file.as_str(), &source), &mut all);
        all.push(b'\n');
    }
    String::from_utf8_lossy(&all).into_owned()
}

/// A longer line is not shown: what is one enormous line is seldom what somebody
/// wrote, and shown it would be megabytes for each mistake in it.
const LONGEST_SHOWN: usize = 4_000;

fn without_its_line(one: &Diagnostic) -> String {
    let kind = match one.severity {
        Severity::Error => "Error",
        Severity::Warning => "Warning",
    };
    let Place { line, column, .. } = one.place;
    let (rule, message, wanted) = (one.rule.name(), &one.message, expectation(one));
    let help = one.help.as_ref().map(|help| format!("   Help: {help}\n")).unwrap_or_default();
    format!(
        "[{rule}] {kind}: {message}\n   {}:{line}:{column} (a line too long to be shown)\n   \
         {wanted}\n{help}\n",
        one.file
    )
}

type Span<'a> = (&'a str, core::ops::Range<usize>);

fn report<'a>(one: &'a Diagnostic, text: &Text, colour: bool) -> Report<'a, Span<'a>> {
    let (kind, tint) = match one.severity {
        Severity::Error => (ReportKind::Error, Color::Red),
        Severity::Warning => (ReportKind::Warning, Color::Yellow),
    };
    let config = Config::default().with_color(colour).with_index_type(IndexType::Char);
    let at = |place: &Place| (one.file.as_str(), text.characters(place));
    let label = Label::new(at(&one.place)).with_color(tint);
    let mut report = Report::build(kind, at(&one.place))
        .with_config(config)
        .with_code(one.rule.name())
        .with_message(&one.message)
        .with_label(label.with_message(expectation(one)));
    if let Some(also) = &one.also {
        let label = Label::new(at(&also.place)).with_color(Color::Cyan);
        report = report.with_label(label.with_message(&also.message));
    }
    if let Some(help) = &one.help {
        report = report.with_help(help);
    }
    report.finish()
}

fn expectation(one: &Diagnostic) -> String {
    let field = one.field.as_ref().map(|field| format!("{field}: ")).unwrap_or_default();
    match &one.expected {
        Some(expected) => format!("{field}expected {expected}"),
        None => format!("{field}here"),
    }
}

/// A file as it is shown, character for character.
struct Text {
    shown: String,
    /// How many characters stand before each line.
    lines: Vec<usize>,
    characters: usize,
    plain: String,
}

impl Text {
    fn new(bytes: &[u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let plain = String::from_utf8_lossy(bytes).into_owned();
        let mut lines = vec![0];
        let mut shown = String::with_capacity(plain.len());
        let mut count = 0;
        let mut characters = plain.chars().enumerate().peekable();
        while let Some((index, character)) = characters.next() {
            count = index + 1;
            let next = characters.peek().map(|(_, next)| *next);
            if character == '\n' || (character == '\r' && next != Some('\n')) {
                lines.push(index + 1);
            }
            shown.push(harmless(character, next));
        }
        Self { shown, lines, characters: count, plain }
    }

    /// How many characters the longest of the lines that it is about has.
    fn longest_of(&self, one: &Diagnostic) -> usize {
        let places = [Some(&one.place), one.also.as_ref().map(|also| &also.place)];
        places.into_iter().flatten().map(|place| self.length(place.line)).max().unwrap_or(0)
    }

    fn length(&self, line: usize) -> usize {
        let start = |line: usize| self.lines.get(line).copied();
        let from = start(line.saturating_sub(1)).unwrap_or(0);
        start(line).unwrap_or(self.characters).saturating_sub(from)
    }

    /// The same place, counted in characters.
    fn characters(&self, place: &Place) -> core::ops::Range<usize> {
        let line = self.lines.get(place.line.saturating_sub(1)).copied().unwrap_or(0);
        let start = line + place.column.saturating_sub(1);
        let within = self.plain.get(place.span.clone()).unwrap_or_default();
        start..start + within.chars().count()
    }
}

/// What a terminal would obey, or take for the end of a line where we do not,
/// as a character that can be seen.
fn harmless(character: char, next: Option<char>) -> char {
    match character {
        '\n' | '\t' => character,
        '\r' if next == Some('\n') => character,
        '\r' => '\n',
        '\u{2028}' | '\u{2029}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}' => '\u{FFFD}',
        _ if character.is_control() => '\u{FFFD}',
        _ => character,
    }
}

#[cfg(test)]
mod tests {
    use crate::format;

    fn rendered(text: &[u8], colour: bool) -> String {
        let found = format::read("a.csv", text).unwrap_err();
        super::render(&found, text, colour)
    }

    const BAD: &[u8] =
        b"id,st,et,dur,con,pri,type,interval,args\n1,9,5,3,1,1,0,0,\x1b[2Jx\x0cy\xC2\x85\n";

    #[test]
    fn the_line_is_shown_with_what_was_expected() {
        let shown = rendered(BAD, false);
        for part in ["a.csv:2:5", "[window]", "1,9,5,3", "et: expected", "not before st"] {
            assert!(shown.contains(part), "{part} is not in\n{shown}");
        }
    }

    #[test]
    fn a_line_that_nobody_can_read_is_not_shown() {
        let long = [BAD, &b"x".repeat(1 << 20)].concat();
        let shown = rendered(&long, false);
        assert!(shown.len() < 2_000, "{} bytes", shown.len());
        for part in ["a.csv:2:5", "1,9,5,3", "a.csv:3:1 (a line too long", "id: expected a task"] {
            assert!(shown.contains(part), "{part} is not in\n{shown}");
        }
    }

    #[test]
    fn a_terminal_obeys_nothing_of_the_file() {
        assert!(!rendered(BAD, false).chars().any(|one| one.is_control() && one != '\n'));
        assert!(rendered(BAD, true).contains("\u{1b}[31m"));
        assert!(!rendered(BAD, true).contains("\u{1b}[2J"));
    }

    #[test]
    fn names_that_somebody_else_chose_are_harmless_in_messages() {
        let found = format::read("a\u{1b}[2J.csv", b"id,st,\x1b[2J\n").unwrap_err();
        let shown = super::render(&found, b"", false);
        assert!(!shown.contains('\u{1b}') && shown.contains("\\u{1b}[2J"), "{shown}");
    }

    #[test]
    fn what_is_no_text_is_shown_as_far_as_it_is_one() {
        assert!(rendered(b"id,st\n1,caf\xE9", false).contains("a.csv:2:6"));
    }
}
