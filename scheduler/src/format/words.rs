//! Arguments: split into words as a POSIX shell splits them, and joined again.

use crate::format::diagnostic::Rule;
use crate::format::wrong::{Wrong, shown};

/// What a shell would act on. Nobody does here.
const OPERATORS: [&str; 10] = ["|", "||", "&", "&&", ";", ">", ">>", "<", "2>", "2>&1"];

/// The words of a line, and what a reader may have meant otherwise.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Words {
    pub(crate) words: Vec<String>,
    pub(crate) warning: Option<Wrong>,
}

/// Splits a line into words.
///
/// # Errors
///
/// A quote is not closed, or there is a NUL, which no argument can hold.
pub(crate) fn split(line: &str) -> Result<Words, Wrong> {
    let words = shlex::split(line).ok_or_else(|| {
        let message = format!("a quote in {} is not closed, or its end is escaped", shown(line));
        Wrong::new(Rule::Quote, message).expected("words as in a POSIX shell")
    })?;
    check(&words)?;
    let warning = comment(line, &words).or_else(|| operator(line, &words));
    Ok(Words { words, warning })
}

/// Checks that a program can be given these words.
pub(crate) fn check(words: &[String]) -> Result<(), Wrong> {
    if words.iter().any(|word| word.contains('\0')) {
        return Err(Wrong::new(Rule::Value, "an argument cannot hold a NUL"));
    }
    Ok(())
}

/// The line that splits into these words; `None` where there is none.
pub(crate) fn join<'a>(words: impl IntoIterator<Item = &'a str>) -> Option<String> {
    shlex::try_join(words).ok()
}

/// A `#` at the start of a word begins a comment: nobody should lose an
/// argument by that without being told.
fn comment(line: &str, words: &[String]) -> Option<Wrong> {
    let plain = ['\u{E000}', '\u{E001}'].into_iter().find(|mark| !line.contains(*mark))?;
    let without = shlex::split(&line.replace('#', plain.encode_utf8(&mut [0; 4])))?;
    let same = without.len() == words.len();
    (!same).then(|| {
        Wrong::new(Rule::NoShell, "what follows # is a comment, and no argument")
            .help("quote the # where it is meant")
    })
}

/// An operator that stands alone and is not quoted.
fn operator(line: &str, words: &[String]) -> Option<Wrong> {
    let meant = |word: &&str| OPERATORS.contains(word) && words.iter().any(|other| other == word);
    let found = line.split_ascii_whitespace().find(meant)?;
    let message = format!("there is no shell: `{found}` is an argument like any other");
    Some(Wrong::new(Rule::NoShell, message).help("write sh -c \"...\" where a shell is meant"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<String> {
        split(line).unwrap().words
    }

    #[test]
    fn words_are_split_as_a_shell_splits_them() {
        assert_eq!(words("sleep  3"), ["sleep", "3"]);
        assert_eq!(words(r#"sh -c "a 'b' > c" '' d\ e"#), ["sh", "-c", "a 'b' > c", "", "d e"]);
        assert_eq!(words(" \t"), [""; 0]);
        assert_eq!(split("echo \"a").unwrap_err().rule, Rule::Quote);
        assert_eq!(split("echo 'a\0'").unwrap_err().rule, Rule::Value);
    }

    #[test]
    fn what_only_a_shell_would_do_is_warned_of() {
        let warned = |line| split(line).unwrap().warning.is_some();
        assert!(warned("take | send"));
        assert!(warned("take > file"));
        assert!(warned("sleep 3 # a while"));
        assert!(!warned("sh -c 'take | send'"));
        assert!(!warned("take '|' send"));
        assert!(!warned("take a#b '#c'"));
    }

    #[test]
    fn joined_words_split_into_themselves() {
        let hard = ["a b", "", "'", "\"", "\\", "#", "$x", "\n", "!", "^", "é"];
        assert_eq!(words(&join(hard).unwrap()), hard);
        assert_eq!(join(["\0"]), None);
    }
}
