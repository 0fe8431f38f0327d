#!/usr/bin/env bash
# Builds `tickets` and `agents` against a sysroot that holds core alone: std and
# alloc are taken away, so whoever names them does not find them. It needs no
# other target; `ci/bare-metal.sh` has those. Usage: ci/no-std.sh
set -euo pipefail
cd "$(dirname "$0")/.."

host=$(rustc -vV | sed -n 's/^host: //p')
core_only=$PWD/target/no-std/sysroot
libs=lib/rustlib/$host/lib
rm -rf "$core_only"
mkdir -p "$core_only/$libs"
cp "$(rustc --print sysroot)/$libs"/lib{core,compiler_builtins}-*.r{lib,meta} "$core_only/$libs/"
build() {
    RUSTFLAGS="--sysroot=$core_only" cargo build --locked --target "$host" --target-dir target/no-std "$@"
}
build -p faregate-agents --features critical-section
# The control: a crate that uses std must fail here.
if build -p faregate-devices-sim >target/no-std/control.log 2>&1; then
    echo "the core-only sysroot let a crate with std pass: this check checks nothing" >&2
    exit 1
fi
grep -Eq 'find crate for .(std|alloc).' target/no-std/control.log
echo "tickets and agents build with core alone"
