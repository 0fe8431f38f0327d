//! The audit can fail: each function of the must-reject set is rejected for its
//! own reason, and what a row says too little or too much of is noticed.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// The set, compiled as flight software is.
static OBJECT: LazyLock<String> = LazyLock::new(|| {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("must-reject");
    let built = Command::new(env!("CARGO"))
        .args(["build", "--release", "--locked", "--target-dir"])
        .arg(&target)
        .current_dir(folder())
        .env("RUSTFLAGS", "-C jump-tables=no -C link-arg=-Wl,-Bsymbolic")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .status();
    assert!(built.expect("cargo runs").success(), "the set does not compile");
    format!("x86_64={}", target.join("release/libfaregate_audit_must_reject.so").display())
});

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("must-reject")
}

fn audit(command: &str, rows: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_faregate-audit"))
        .args([command, "--rows"])
        .arg(rows)
        .arg(&*OBJECT)
        .output()
        .expect("the audit runs")
}

/// Runs a command with these rows. Answers whether all held, and what it printed.
fn judge(command: &str, rows: &str) -> (bool, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rows.toml");
    fs::write(&path, rows).expect("a file");
    let output = audit(command, &path);
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    (output.status.success(), text)
}

const LOOP: &str = "[[row]]\nsymbol = \"accept_loop\"\nname = \"l\"\ntargets = [\"x86_64\"]\n";
const STRAIGHT: &str =
    "[[row]]\nsymbol = \"accept_straight\"\nname = \"s\"\ntargets = [\"x86_64\"]\n";

fn with_loop(most: u64) -> String {
    format!("{LOOP}loops = [{{ in = \"accepted::count\", most = {most}, why = \"inputs\" }}]\n")
}

#[test]
fn each_is_rejected_for_its_own_reason_and_the_others_are_accepted() {
    let output = audit("reject", &folder().join("rows.toml"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn a_function_that_is_rejected_for_another_reason_is_noticed() {
    let rows = format!("{LOOP}rejected = [\"division\"]\n");
    let (holds, text) = judge("reject", &rows);
    assert!(!holds && text.contains("1 of them wrongly"), "{text}");
}

#[test]
fn a_function_that_should_be_rejected_and_is_not_is_noticed() {
    let (holds, text) = judge("reject", &format!("{STRAIGHT}rejected = [\"loop\"]\n"));
    assert!(!holds && text.contains("1 of them wrongly"), "{text}");
}

#[test]
fn a_loop_needs_a_bound() {
    let (holds, text) = judge("check", LOOP);
    assert!(!holds && text.contains("no bound is stated for this loop of"), "{text}");
    let (holds, text) = judge("check", &with_loop(8));
    assert!(holds && text.contains("0 of them broken"), "{text}");
}

#[test]
fn a_bound_for_no_loop_is_noticed() {
    let rows = with_loop(8).replace("accept_loop", "accept_straight");
    let (holds, text) = judge("check", &rows);
    assert!(!holds && text.contains("no loop is in accepted::count"), "{text}");
}

#[test]
fn an_excuse_that_nothing_needs_is_noticed() {
    let (holds, text) = judge("check", &format!("{STRAIGHT}may = [\"division: rates\"]\n"));
    assert!(!holds && text.contains("nothing needs"), "{text}");
}

#[test]
fn random_calls_stay_within_the_bound() {
    let (holds, text) = judge("step", &with_loop(8));
    assert!(holds && text.contains("1 functions stepped"), "{text}");
}

#[test]
fn a_bound_that_is_too_small_is_seen_by_stepping() {
    let (holds, text) = judge("step", &with_loop(1));
    assert!(!holds && text.contains("at most"), "{text}");
}

#[test]
fn a_straight_function_reaches_its_bound() {
    let (holds, text) = judge("step", &format!("{STRAIGHT}reaches_bound = true\n"));
    assert!(holds && text.contains("1 of them up to their bound"), "{text}");
}

#[test]
fn a_bound_that_no_call_reaches_is_noticed_where_one_has_to() {
    let (holds, text) = judge("step", &format!("{}reaches_bound = true\n", with_loop(9)));
    assert!(!holds && text.contains("no call reached the bound"), "{text}");
}

#[test]
fn what_is_no_object_and_what_are_no_rows_is_said() {
    let (holds, text) = judge("check", "[[row]]\nsymbol = 5");
    assert!(!holds && text.contains("cannot be used"), "{text}");
    let output = Command::new(env!("CARGO_BIN_EXE_faregate-audit"))
        .args(["show", "x86_64=/dev/null", "main"])
        .output()
        .expect("the audit runs");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no ELF object"));
}
