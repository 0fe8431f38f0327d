#!/usr/bin/env bash
# Runs invocation and revocation under the realtime sanitizer, and controls that
# it must report. Takes a nightly compiler: without one it says so, and passes.
# Usage: ci/rtsan.sh
set -euo pipefail
cd "$(dirname "$0")/.."

if ! rustc +nightly -V >/dev/null 2>&1; then
    echo "skipped: there is no nightly compiler (rustup toolchain install nightly)"
    exit
fi
host=$(rustc +nightly -vV | sed -n 's/^host: //p')
runtime=$(rustc +nightly --print sysroot)/lib/rustlib/$host/lib/librustc-nightly_rt.rtsan.a
if [[ ! -f $runtime ]]; then
    echo "skipped: $(rustc +nightly -V) for $host has no realtime sanitizer: $runtime is not there"
    exit
fi
target=${CARGO_TARGET_DIR:-$PWD/target}/rtsan
mkdir -p "$target"
probe='#![feature(sanitize)] #[sanitize(realtime = "nonblocking")] fn main() {}'
# Not to /dev/null: the compiler puts a file in the place of what is there.
if ! rustc +nightly -Zsanitizer=realtime --emit metadata -o "$target/probe.rmeta" - \
    <<<"$probe" 2>"$target/probe.log"; then
    echo "skipped: $(rustc +nightly -V) does not know #[sanitize(realtime = ..)] as it is written here"
    exit
fi
# With a target named, build scripts and macros are not instrumented.
RUSTFLAGS="-Zsanitizer=realtime" cargo +nightly build --locked --quiet --target "$host" \
    --target-dir "$target" --manifest-path ci/rtsan/Cargo.toml
run() {
    RTSAN_OPTIONS="suppressions=ci/rtsan/may-be-called" \
        "$target/$host/debug/faregate-rtsan" "$1" >"$target/$1.log" 2>&1
}
run paths || {
    cat "$target/paths.log"
    exit 1
}
grep behind "$target/paths.log"
# control | what must be reported
while read -r control called; do
    if run "$control" || ! grep -Fq "real-time unsafe function \`$called\`" "$target/$control.log"; then
        cat "$target/$control.log"
        echo "the control '$control' was not reported as a call of $called" >&2
        exit 1
    fi
    echo "control: '$control' is reported as a call of $called"
done <<'CONTROLS'
allocates malloc
frees free
locks syscall
contended syscall
CONTROLS
# Without its exemption the one system call is reported: it is the only one.
if RTSAN_OPTIONS="" "$target/$host/debug/faregate-rtsan" paths >"$target/exempt.log" 2>&1 ||
    ! grep -Fq 'rseq::membarrier' "$target/exempt.log"; then
    echo "what ci/rtsan/may-be-called names is not called any more" >&2
    exit 1
fi
echo "exempt: membarrier, of gates with restartable stores"
