//! SMAARTE's `type` and `args` as a body, and back.

use crate::format::diagnostic::Rule;
use crate::format::scalar;
use crate::format::words;
use crate::format::wrong::{Wrong, shown};
use crate::task::{Body, BuiltIn, TaskId};

/// The first type that is a registered function.
pub(crate) const REGISTERED: u16 = 16;

/// Which types there are.
pub(crate) fn check_type(number: u16) -> Result<(), Wrong> {
    if matches!(number, 7..REGISTERED) {
        return Err(Wrong::new(Rule::Range, format!("type {number} is reserved"))
            .expected("0 to 6, or 16 and more for a registered function"));
    }
    Ok(())
}

/// The body of this type with these arguments.
pub(crate) fn from_type(number: u16, words: Vec<String>) -> Result<Body, Wrong> {
    let built_in = match number {
        0 => return process(words),
        1 => clear(&words)?,
        2 => BuiltIn::Remove(remove(&words)?),
        3 => BuiltIn::Load(one(words, "the file to load")?),
        4 => BuiltIn::EnterMode(one(words, "the mode to enter")?),
        5 => BuiltIn::LeaveMode(one(words, "the mode to leave")?),
        6 => return hold(&words),
        number => return Ok(Body::Function { number, arguments: words }),
    };
    Ok(Body::BuiltIn(built_in))
}

/// A program and its arguments.
pub(crate) fn process(words: Vec<String>) -> Result<Body, Wrong> {
    let expected = "a program and its arguments";
    let mut words = words.into_iter();
    match words.next() {
        None => Err(Wrong::new(Rule::Missing, "there is no program").expected(expected)),
        Some(program) if program.is_empty() => {
            Err(Wrong::new(Rule::Value, "the program's name is empty").expected(expected))
        }
        Some(program) => Ok(Body::Process { program, arguments: words.collect() }),
    }
}

fn clear(words: &[String]) -> Result<BuiltIn, Wrong> {
    match words {
        [] => Ok(BuiltIn::Clear { all: false }),
        [all] if all == "all" => Ok(BuiltIn::Clear { all: true }),
        [first, ..] => Err(Wrong::new(Rule::Body, format!("clear does not know {}", shown(first)))
            .expected("nothing (what is pending is dropped), or all (what runs ends, too)")),
    }
}

fn remove(words: &[String]) -> Result<Vec<TaskId>, Wrong> {
    if words.is_empty() {
        return Err(Wrong::new(Rule::Missing, "there is no task to remove")
            .expected("the numbers of the tasks to remove"));
    }
    words.iter().map(|word| scalar::task_id(word)).collect()
}

fn hold(words: &[String]) -> Result<Body, Wrong> {
    match words {
        [] => Ok(Body::Hold),
        [first, ..] => {
            Err(Wrong::new(Rule::Body, format!("a hold does nothing with {}", shown(first)))
                .expected("nothing: a hold occupies its categories for its duration"))
        }
    }
}

fn one(words: Vec<String>, what: &str) -> Result<String, Wrong> {
    match <[String; 1]>::try_from(words) {
        Ok([word]) if !word.is_empty() => Ok(word),
        Ok(_) => Err(Wrong::new(Rule::Missing, format!("{what} has no name")).expected(what)),
        Err(words) if words.is_empty() => {
            Err(Wrong::new(Rule::Missing, format!("{what} is not named")).expected(what))
        }
        Err(words) => Err(Wrong::new(Rule::Body, format!("there are {} words", words.len()))
            .expected(format!("one word: {what}"))
            .help("quote a name that has spaces in it")),
    }
}

/// The type and the arguments of a body; `None` for a sequence, which has no
/// type.
pub(crate) fn to_type(body: &Body) -> Option<(u16, Vec<String>)> {
    let built_in = match body {
        Body::Process { program, arguments } => {
            return Some((0, [core::slice::from_ref(program), arguments.as_slice()].concat()));
        }
        Body::Function { number, arguments } => return Some((*number, arguments.clone())),
        Body::Sequence(_) => return None,
        Body::Hold => return Some((6, Vec::new())),
        Body::BuiltIn(built_in) => built_in,
    };
    Some(match built_in {
        BuiltIn::Clear { all } => (1, all.then(|| "all".to_owned()).into_iter().collect()),
        BuiltIn::Remove(tasks) => (2, tasks.iter().map(|task| task.get().to_string()).collect()),
        BuiltIn::Load(file) => (3, vec![file.clone()]),
        BuiltIn::EnterMode(mode) => (4, vec![mode.clone()]),
        BuiltIn::LeaveMode(mode) => (5, vec![mode.clone()]),
    })
}

/// The line of arguments that the words are read from again.
pub(crate) fn line(arguments: &[String]) -> Option<String> {
    words::join(arguments.iter().map(String::as_str))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(number: u16, line: &str) -> Result<Body, Rule> {
        check_type(number).map_err(|wrong| wrong.rule)?;
        let words = words::split(line).map_err(|wrong| wrong.rule)?.words;
        from_type(number, words).map_err(|wrong| wrong.rule)
    }

    #[test]
    fn each_type_says_what_its_arguments_are() {
        let good = [
            (0, "sleep 3"),
            (1, ""),
            (1, "all"),
            (2, "4 5"),
            (3, "next.csv"),
            (4, "'safe mode'"),
            (5, "safe"),
            (6, ""),
            (16, "a b"),
            (65_535, ""),
        ];
        for (number, arguments) in good {
            let body = read(number, arguments).unwrap();
            let (again, words) = to_type(&body).unwrap();
            assert_eq!(again, number);
            assert_eq!(read(number, &line(&words).unwrap()), Ok(body));
        }
    }

    #[test]
    fn a_body_that_does_not_fit_its_type_is_refused() {
        assert_eq!(read(0, ""), Err(Rule::Missing));
        assert_eq!(read(0, "''"), Err(Rule::Value));
        assert_eq!(read(1, "some"), Err(Rule::Body));
        assert_eq!(read(2, ""), Err(Rule::Missing));
        assert_eq!(read(2, "0"), Err(Rule::Range));
        assert_eq!(read(3, "a b"), Err(Rule::Body));
        assert_eq!(read(4, "''"), Err(Rule::Missing));
        assert_eq!(read(6, "sleep 3"), Err(Rule::Body));
        assert_eq!(read(7, ""), Err(Rule::Range));
        assert_eq!(read(15, ""), Err(Rule::Range));
    }
}
