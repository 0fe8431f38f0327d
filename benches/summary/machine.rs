//! Where and how it was measured.

use std::process::Command;
use std::{env, fs};

/// A paragraph for the documentation.
pub(crate) fn paragraph(command: &str) -> String {
    let cpus = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "Printed by `{command}` on {cpus} CPUs of {}, {}, load {}; {}, release with fat LTO and one \
         codegen unit{}.",
        field("/proc/cpuinfo", "model name"),
        kernel(),
        load(),
        compiler(),
        flags(),
    )
}

fn unknown() -> String {
    "(unknown)".to_owned()
}

/// The first value of this name in a file of `name : value` lines.
fn field(path: &str, name: &str) -> String {
    let text = fs::read_to_string(path).unwrap_or_default();
    let values = text.lines().filter_map(|line| line.split_once(':'));
    let mut named = values.filter(|(key, _)| key.trim() == name);
    named.next().map_or_else(unknown, |(_, value)| value.trim().to_owned())
}

fn kernel() -> String {
    let release = fs::read_to_string("/proc/sys/kernel/osrelease");
    release
        .map_or_else(|_| env::consts::OS.to_owned(), |release| format!("Linux {}", release.trim()))
}

/// Of the last minute: that of the benches themselves is in it.
fn load() -> String {
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    load.split_whitespace().next().map_or_else(unknown, str::to_owned)
}

fn compiler() -> String {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    let text = version.ok().and_then(|output| String::from_utf8(output.stdout).ok());
    text.map_or_else(unknown, |text| text.trim().to_owned())
}

fn flags() -> String {
    match env::var("RUSTFLAGS") {
        Ok(flags) if !flags.is_empty() => format!(", RUSTFLAGS `{flags}`"),
        _ => String::new(),
    }
}
