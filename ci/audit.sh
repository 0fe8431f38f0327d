#!/usr/bin/env bash
# The bounded-time audit of the compiled core: builds what is audited, for
# x86-64 and for Thumb-2, and judges it.
#   1. Each function of the must-reject set is rejected, for its own reason.
#   2. Each item that promises constant time has a row in audit/rows.toml.
#   3. Each row holds: closed call graph, loops with bounds, nothing unbounded.
#   4. The table in docs/timing.md says what was found.
#   5. Random calls, single-stepped, stay within the bounds.
# Usage: ci/audit.sh [--write]
#   --write  writes the table into docs/timing.md instead of comparing it
# Without a compiler for Thumb-2 this half and the table are skipped, which it
# says; with CI=true it fails there. The same holds for single-stepping where
# the machine is not Linux on x86-64.
set -euo pipefail
# Or a build that fails in `$(...)` would leave the last one to be judged.
shopt -s inherit_errexit
cd "$(dirname "$0")/.."
source ci/lib/bare-metal.sh

table=--check
case "${1:-}" in
    "") ;;
    --write) table=--write ;;
    -h | --help)
        sed -n '2,/^set -euo/p' "$0" | sed '$d; s/^# \{0,1\}//'
        exit
        ;;
    *)
        echo "unknown argument $1; see ci/audit.sh --help" >&2
        exit 2
        ;;
esac

targets=${CARGO_TARGET_DIR:-$PWD/target}
thumb_target=thumbv7em-none-eabihf
# Tables of addresses make an indirect jump of every `match`; see audit/README.md.
# Names are of one kind, whichever compiler it is.
flags="-C jump-tables=no -C force-frame-pointers=no -C symbol-mangling-version=v0"
flags+=" --remap-path-prefix=$PWD=."
skipped=()

skip() {
    skipped+=("$1")
    echo "skipped: $1" >&2
    if [[ ${CI:-} == true ]]; then
        echo "with CI=true nothing may be skipped" >&2
        exit 1
    fi
}

host_is_x86_64() {
    [[ $(rustc -vV | sed -n 's/^host: //p') == x86_64-unknown-linux-gnu ]]
}

# Builds the workspace of its own in a folder; answers `x86_64=PATH`.
for_x86_64() {
    local folder=$1 library=$2
    # Its own copies are what it calls, whatever else is loaded.
    RUSTFLAGS="$flags -C link-arg=-Wl,-Bsymbolic" cargo build --quiet --locked --release \
        --manifest-path "$folder/Cargo.toml" --target-dir "$targets/audit" >&2
    echo "x86_64=$targets/audit/release/lib$library.so"
}

# The same for Thumb-2. There are no dynamic libraries for it: the archive is
# linked as it is, with all that is in it.
for_thumb() {
    local folder=$1 library=$2 archive linked=$targets/audit/$2.elf
    RUSTFLAGS=$flags bare_cargo "$thumb_target" rustc --quiet --locked --release \
        --manifest-path "$folder/Cargo.toml" --crate-type staticlib >&2
    archive=$(bare_dir "$thumb_target")/$thumb_target/release/lib$library.a
    mkdir -p "$targets/audit"
    PATH="$(bare_linker_path rustc)$PATH" rust-lld -flavor gnu --entry=0 --no-gc-sections \
        --whole-archive "$archive" -o "$linked"
    echo "thumb=$linked"
}

# Fills `objects` with what can be built of the folder.
objects_of() {
    local object
    objects=()
    if host_is_x86_64; then
        object=$(for_x86_64 "$1" "$2")
        objects+=("$object")
    fi
    if [[ $has_thumb == yes ]]; then
        object=$(for_thumb "$1" "$2")
        objects+=("$object")
    fi
}

audit() {
    "$targets/debug/faregate-audit" "$@"
}

has_thumb=yes
bare_how "$thumb_target" || {
    has_thumb=no
    skip "Thumb-2: no compiler for $thumb_target, as said above"
}
host_is_x86_64 || skip "x86-64: this host compiles for another processor"

cargo build --quiet --locked -p faregate-audit

echo "--- what must be rejected"
objects_of audit/must-reject faregate_audit_must_reject
audit reject "${objects[@]}"

echo "--- what promises constant time"
audit items

echo "--- what is audited"
objects_of audit/shims faregate_audit_shims
audit check "${objects[@]}"

if [[ ${#objects[@]} -eq 2 ]]; then
    audit table "$table" "${objects[@]}"
else
    skip "the table in docs/timing.md, which is of both"
fi

if host_is_x86_64; then
    echo "--- random calls"
    audit step "${objects[0]}"
fi

if [[ ${#skipped[@]} -gt 0 ]]; then
    printf 'the audit holds, but for what was skipped: %s\n' "${skipped[@]}"
else
    echo "the audit holds"
fi
