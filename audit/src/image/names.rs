//! Names: what a symbol is called in the source, and what it is for.

use rustc_demangle::demangle;

use crate::code::Kind;

/// A symbol's path in the source, without its hash, its generic arguments and
/// the closures in it.
pub fn path_of(symbol: &str) -> String {
    let written = format!("{:#}", demangle(symbol));
    let mut path = without_generics(&unwrapped(&written));
    for closure in ["::{{closure}}", "::{closure#0}", "::{closure#1}", "::{closure#2}"] {
        path = path.replace(closure, "");
    }
    path
}

/// `<a::B<T>>::c` is written `a::B::c`, and so are `<a::B as d::E>::c`,
/// `m::<impl a::B<T>>::c` and `m::<impl d::E for a::B>::c`: a row names the type,
/// wherever its function stands, whichever trait it comes from, and however the
/// compiler writes it.
fn unwrapped(written: &str) -> String {
    let at = written.find("<impl ").filter(|at| *at == 0 || written[..*at].ends_with("::"));
    let begins = at.map(|at| at + "<impl ".len());
    let begins = begins.or_else(|| written.starts_with('<').then_some(1));
    let Some((this, rest)) = begins.and_then(|at| closed(&written[at..])) else {
        return written.to_owned();
    };
    let this = outside_brackets(this, " as ").map_or(this, |(this, _)| this);
    let this = outside_brackets(this, " for ").map_or(this, |(_, this)| this);
    format!("{}{rest}", unwrapped(this))
}

/// What is before the bracket that closes the one before it, and what is after.
fn closed(inside: &str) -> Option<(&str, &str)> {
    let mut depth = 1_usize;
    let closing = inside.char_indices().find_map(|(at, letter)| {
        depth = match letter {
            '<' => depth + 1,
            '>' if !inside[..at].ends_with('-') => depth - 1,
            _ => depth,
        };
        (depth == 0).then_some(at)
    })?;
    let (this, rest) = inside.split_at(closing);
    Some((this, rest.strip_prefix('>')?))
}

/// What is before and after the word, where that is in no brackets.
fn outside_brackets<'a>(text: &'a str, word: &str) -> Option<(&'a str, &'a str)> {
    let count = |part: &str, bracket: &str| part.matches(bracket).count();
    text.match_indices(word)
        .map(|(at, _)| (&text[..at], &text[at + word.len()..]))
        .find(|(before, _)| count(before, "<") + count(before, "->") == count(before, ">"))
}

fn without_generics(path: &str) -> String {
    let mut depth = 0_usize;
    let mut kept = String::with_capacity(path.len());
    for letter in path.chars() {
        match letter {
            '<' => depth += 1,
            '>' if !kept.ends_with('-') => depth = depth.saturating_sub(1),
            _ if depth == 0 => kept.push(letter),
            _ => {}
        }
    }
    kept.trim_end_matches("::").replace("::::", "::")
}

/// Whether `pattern` is a part of `path`, from one `::` to another.
pub fn matches(path: &str, pattern: &str) -> bool {
    path.match_indices(pattern).any(|(at, _)| {
        let before = path[..at].ends_with("::") || at == 0;
        let after =
            path[at + pattern.len()..].starts_with("::") || at + pattern.len() == path.len();
        before && after
    })
}

/// What the audit knows a function by its name to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A copy, fill or comparison, whose length is this argument.
    Memory(usize),
    /// What no audited function may call, unless its row says so.
    Denied(Kind),
}

/// The function's role, if it has one.
pub fn role_of(symbol: &str) -> Option<Role> {
    let path = path_of(symbol);
    let allocates =
        format!("{:#}", demangle(symbol)).contains(" as core::alloc::global::GlobalAlloc>");
    let allocator = allocates.then_some(Role::Denied(Kind::Allocation));
    let denied = || denied(&path).map(Role::Denied);
    memory(symbol).map(Role::Memory).or(allocator).or_else(denied)
}

fn memory(symbol: &str) -> Option<usize> {
    let name = symbol.strip_prefix("__aeabi_").map(|name| name.trim_end_matches(['4', '8']));
    match (symbol, name) {
        ("memcpy" | "memmove" | "memset" | "memcmp" | "bcmp", _) => Some(2),
        (_, Some("memcpy" | "memmove")) => Some(2),
        (_, Some("memset" | "memclr")) => Some(1),
        _ => None,
    }
}

fn denied(path: &str) -> Option<Kind> {
    let begins = |names: &[&str]| names.iter().any(|name| path.starts_with(name));
    let is_panic =
        begins(&["core::panicking", "std::panicking", "rust_begin_unwind", "rust_panic"])
            || path.contains("_fail") && path.starts_with("core::")
            || path.contains("unwrap_failed")
            || path.contains("expect_failed")
            || path.starts_with("core::cell::panic_already")
            || matches!(path, "abort" | "core::intrinsics::abort" | "_Unwind_Resume");
    let allocators = &["__rust_", "__rdl_", "__rg_", "alloc::", "__rustc::__rust_"];
    if is_panic {
        Some(Kind::Panic)
    } else if begins(allocators) || matches!(path, "malloc" | "calloc" | "realloc" | "free") {
        Some(Kind::Allocation)
    } else if is_division(path) {
        Some(Kind::Division)
    } else {
        None
    }
}

/// The divisions that a target has no instruction for.
fn is_division(path: &str) -> bool {
    let name = path.trim_start_matches("__aeabi_").trim_start_matches("__");
    let (wide, plain) = (name.trim_start_matches('u'), path != name);
    plain
        && ([
            "divti3",
            "modti3",
            "divmodti4",
            "divdi3",
            "moddi3",
            "divmoddi4",
            "divsi3",
            "modsi3",
            "divmodsi4",
        ]
        .contains(&wide)
            || ["uidiv", "uidivmod", "idiv", "idivmod", "uldivmod", "ldivmod", "fdiv", "ddiv"]
                .contains(&name))
        || path.starts_with("compiler_builtins::int::specialized_div_rem")
}

#[cfg(test)]
mod tests {
    use super::{Role, matches, path_of, role_of, unwrapped};
    use crate::code::Kind;

    #[test]
    fn a_path_has_no_hash_and_no_generic_arguments() {
        let legacy =
            "_ZN16faregate_tickets4lock3sys20PiMutex$LT$T$C$I$GT$4wait17h00639d2e0302e174E";
        assert_eq!(path_of(legacy), "faregate_tickets::lock::sys::PiMutex::wait");
        let v0 = "_RNvMs1b_NtNtCsgEmfK2I1SDS_4core4sync6atomicNtB6_9AtomicU324load";
        assert_eq!(path_of(v0), "core::sync::atomic::AtomicU32::load");
        assert_eq!(path_of("audit_invoke"), "audit_invoke");
    }

    #[test]
    fn a_trait_s_function_is_its_type_s() {
        let legacy =
            "_ZN55_$LT$a..B$LT$T$GT$$u20$as$u20$core..ops..drop..Drop$GT$4drop17h00639d2e0302e174E";
        assert_eq!(path_of(legacy), "a::B::drop");
    }

    #[test]
    fn a_function_is_its_type_s_wherever_it_stands() {
        let legacy = "_ZN1a5other35_$LT$impl$u20$a..B$LT$_$C$_$GT$$GT$3put17h00639d2e0302e174E";
        assert_eq!(path_of(legacy), "a::B::put");
        let traits = "_ZN1a5other39_$LT$impl$u20$d..E$u20$for$u20$a..B$GT$3put17h00639d2e0302e174E";
        assert_eq!(path_of(traits), "a::B::put");
    }

    #[test]
    fn a_closure_is_its_function() {
        let written = "<<a::B<C> as d::E>::next::{closure#0} as core::ops::function::FnOnce<(F,)>>";
        assert_eq!(
            unwrapped(&format!("{written}::call_once")),
            "a::B<C>::next::{closure#0}::call_once"
        );
    }

    #[test]
    fn a_pattern_matches_whole_words() {
        assert!(matches("a::books::Books::step", "Books::step"));
        assert!(matches("a::books::Books::step", "a::books"));
        assert!(!matches("a::books::Books::step", "ooks::step"));
        assert!(!matches("a::books::Books::step_on", "Books::step"));
    }

    #[test]
    fn names_say_what_no_audited_function_calls() {
        assert_eq!(role_of("__udivti3"), Some(Role::Denied(Kind::Division)));
        assert_eq!(role_of("__aeabi_uldivmod"), Some(Role::Denied(Kind::Division)));
        assert_eq!(role_of("__aeabi_lmul"), None);
        assert_eq!(role_of("__aeabi_memclr8"), Some(Role::Memory(1)));
        assert_eq!(role_of("memcpy"), Some(Role::Memory(2)));
        assert_eq!(role_of("malloc"), Some(Role::Denied(Kind::Allocation)));
    }
}
