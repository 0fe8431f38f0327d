//! The table of guarantees speaks of what is there: every file, test and mutant
//! that `docs/guarantees.md` names exists.

use std::path::Path;

const GUARANTEES: [&str; 24] = [
    "No Bypass",
    "Open Door",
    "Closed Door",
    "Empty Room",
    "One Tenant",
    "Constant Revoke",
    "Bounded Hand-over",
    "Highest First",
    "Margin Kept",
    "Bounded Validity",
    "Restoration",
    "Source Death",
    "No Allocation",
    "Every Refusal Explains Itself",
    "Nothing Lost",
    // The schedule manager's.
    "No Task Without Tickets",
    "Highest First, Among Tasks",
    "Foretold",
    "At Most Once",
    "Shut Entrance",
    // The planner's.
    "Limits Kept",
    "No Activity Without Tickets",
    "No Start Unready",
    // Of all that reads files.
    "All Mistakes At Once",
];

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn page() -> String {
    read("docs/guarantees.md")
}

/// What stands between backquotes, in order.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

#[test]
fn every_guarantee_has_its_section_with_code_test_and_break() {
    let page = page();
    let mut sections = page.split("\n## ").skip(1);
    for name in GUARANTEES {
        let section = sections.next().unwrap_or_else(|| panic!("{name} has no section"));
        assert!(section.starts_with(name), "{name} is missing before: {section}");
        for part in ["\n- code: ", "\n- shown by: ", "\n- break: "] {
            assert!(section.contains(part), "{name} lacks '{}'", part.trim());
        }
    }
    assert_eq!(sections.next(), None);
}

#[test]
fn every_file_and_every_test_in_it_exists() {
    let page = page();
    let mut tests = 0;
    for item in page.split("\n- ").skip(1) {
        let item = item.split("\n## ").next().unwrap_or_default();
        let mut file: Option<(&str, String)> = None;
        for word in quoted(item) {
            if word.contains('/') && word.ends_with(".rs") {
                file = Some((word, read(word)));
            } else if let Some((path, text)) = file.as_ref().filter(|_| is_a_test_name(word)) {
                if !path.contains("tests/") {
                    continue;
                }
                assert!(text.contains(&format!("fn {word}")), "{path} has no {word}");
                tests += 1;
            }
        }
    }
    assert!(tests > 60, "only {tests} tests were found: has the page another form now?");
}

#[test]
fn every_slide_has_its_code_and_its_test() {
    let page = read("docs/planner-slides.md");
    let mut tests = 0;
    for row in page.lines().filter(|line| line.starts_with('|') && line.contains(".rs`")) {
        let before = tests;
        let mut file = None;
        for word in quoted(row) {
            if word.ends_with(".rs") {
                file = Some((word, read(word)));
            } else if let Some((path, text)) = file.as_ref().filter(|_| is_a_test_name(word)) {
                assert!(text.contains(&format!("fn {word}(")), "{path} has no {word}");
                tests += 1;
            }
        }
        assert!(tests > before, "no test in: {row}");
    }
    assert!(tests > 40, "only {tests} tests were found: has the page another form now?");
}

fn is_a_test_name(word: &str) -> bool {
    word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

#[test]
fn every_mutant_exists_is_named_and_is_killed_in_ci() {
    let (page, script) = (page(), read("ci/loom.sh"));
    for (folder, crate_name) in
        [("tickets", "tickets"), ("agents", "agents"), ("scheduler/models", "scheduler")]
    {
        let manifest = read(&format!("{folder}/Cargo.toml"));
        for line in manifest.lines().filter(|line| line.starts_with("mutant-")) {
            let mutant = line.split(' ').next().unwrap_or_default();
            let name = mutant.trim_start_matches("mutant-");
            assert!(page.contains(&format!("`{folder}/{mutant}`")), "{mutant} is not named");
            assert!(script.contains(&format!("{crate_name}/{name} |")), "{mutant} is not killed");
        }
    }
    for mutant in quoted(&page).filter(|word| word.contains("/mutant-")) {
        let (folder, feature) = mutant.rsplit_once('/').expect("a crate and a feature");
        let manifest = read(&format!("{folder}/Cargo.toml"));
        assert!(manifest.contains(&format!("\n{feature} = ")), "{mutant} does not exist");
    }
}

/// The mutants of a table: name, file, what stands there, and the target and the
/// test that see it.
fn mutants_of(table: &str) -> Vec<[&str; 5]> {
    let lines = table.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let lines: Vec<_> = lines.collect();
    let mutants = lines.chunks(5).map(|lines| match *lines {
        [name, file, from, _, test] => {
            let from = from.strip_prefix("- ").expect("what stands there");
            let test = test.strip_prefix("! ").and_then(|test| test.split_once(' '));
            let (target, test) = test.expect("a target and a test");
            [name, file.trim(), from, target, test]
        }
        _ => panic!("the last mutant is cut off: {lines:?}"),
    });
    mutants.collect()
}

/// The files that the tests of a target are in.
fn tests_of(target: &str) -> String {
    let place = match target {
        target if target.starts_with("scheduler:") => target.replace(':', "/tests/"),
        "lib" => "planner/src".to_owned(),
        "trust" => "planner/checker/tests/trust".to_owned(),
        "rehearsal" | "broken" => format!("planner/rehearsal/tests/{target}"),
        _ => format!("planner/tests/{target}"),
    };
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join(place);
    let root = std::fs::read_to_string(place.with_extension("rs")).unwrap_or_default();
    if place.is_dir() { root + &all_in(&place) } else { root }
}

fn all_in(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).expect("it can be read");
    let paths = entries.map(|entry| entry.expect("it can be read").path());
    let text = |path: std::path::PathBuf| {
        if path.is_dir() {
            all_in(&path)
        } else {
            std::fs::read_to_string(path).unwrap_or_default()
        }
    };
    paths.map(text).collect()
}

#[test]
fn every_mutant_of_a_line_breaks_one_that_is_there_and_names_a_test_that_is() {
    let tables = ["planner", "scheduler"].map(|of| read(&format!("ci/lib/{of}-mutants.txt")));
    let mutants: Vec<_> = tables.iter().flat_map(|table| mutants_of(table)).collect();
    let mut names = std::collections::BTreeSet::new();
    for [name, file, from, target, test] in &mutants {
        assert!(names.insert(*name), "two mutants have the name '{name}'");
        assert_eq!(read(file).matches(from).count(), 1, "'{name}': '{from}' in {file}");
        let test = test.rsplit("::").next().unwrap_or_default();
        let tests = tests_of(target);
        assert!(tests.contains(&format!("fn {test}(")), "'{name}': no {test} in {target}");
    }
    assert!(mutants.len() > 100, "only {} were found", mutants.len());
    let page = page();
    let mut named = 0;
    for command in quoted(&page).filter_map(|word| word.strip_prefix("ci/mutants.sh ")) {
        let words = command.replace('\n', " ");
        for name in words.split('"').skip(1).step_by(2) {
            let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(names.contains(name.as_str()), "there is no mutant '{name}'");
            named += 1;
        }
    }
    assert!(named > 10, "only {named} were found: has the page another form now?");
}

#[test]
fn every_mutant_that_an_essay_breaks_is_in_the_table() {
    let script = read("ci/loom.sh");
    let mut broken = 0;
    for essay in ["arbitration", "gate", "hand-over", "time"] {
        let text = read(&format!("docs/{essay}.md")).replace('\n', " ");
        for command in quoted(&text).filter_map(|word| word.strip_prefix("ci/loom.sh ")) {
            for mutant in command.split_whitespace() {
                assert!(script.contains(&format!("/{mutant} |")), "{essay}: no {mutant}");
                broken += 1;
            }
        }
    }
    assert!(broken >= 5, "only {broken} mutants were found: have the essays another form now?");
}

#[test]
fn every_check_that_the_readme_names_is_there() {
    let readme = read("README.md");
    let mut checks = 0;
    for command in quoted(&readme).filter(|word| word.starts_with("cargo test -p ")) {
        let package = command.split(' ').nth(3).unwrap_or_default();
        let folder = package.trim_start_matches("faregate-");
        for test in command.split("--test ").skip(1).map(str::trim) {
            let files =
                [format!("{folder}/tests/{test}.rs"), format!("{folder}/tests/{test}/main.rs")];
            let is_there = |file| Path::new(env!("CARGO_MANIFEST_DIR")).join(file).is_file();
            assert!(files.iter().any(is_there), "there is none of {files:?}");
            checks += 1;
        }
    }
    assert!(checks >= 8, "only {checks} checks were found: has the README another form now?");
}
