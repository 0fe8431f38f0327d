#!/usr/bin/env bash
# What runs without an operating system: flies the emergency on a simulated
# Cortex-M4, twice, with its breaks as controls, compares its instruction counts
# and its memory with docs/timing.md, and builds the core for other bare-metal
# targets.
set -euo pipefail
cd "$(dirname "$0")/.."
source ci/lib/bare-metal.sh

usage() {
    cat <<'USAGE'
Usage: ci/bare-metal.sh [--help] [--write]

  --write   write the figures into docs/timing.md instead of comparing them

Installs Debian's compiler, its sources and QEMU where it may; says what is
missing where it may not, and goes on without it. With CI=true that is a failure.
USAGE
}

case ${1:-} in
    --help) usage && exit ;;
    --write) write=true ;;
    '') write=false ;;
    *) usage >&2 && exit 2 ;;
esac

# The target of the firmware, and those for which the core is only built:
# without compare-and-swap; RISC-V; a large core without a system; LEON.
readonly BOARD=thumbv7em-none-eabihf
readonly WITHOUT_SWAP=thumbv6m-none-eabi
readonly ONLY_BUILT="$WITHOUT_SWAP riscv32imac-unknown-none-elf aarch64-unknown-none sparc-unknown-none-elf"
readonly LINUX_ON_ARM=aarch64-unknown-linux-gnu
readonly FIRMWARE=examples/bare-metal
readonly PAGE=docs/timing.md
out=$(bare_dir "$BOARD")/flights
mkdir -p "$out"

fail() {
    echo "$1" >&2
    exit 1
}

skip() {
    echo "skipped: $1" >&2
    [[ ${CI:-} != true ]] || exit 1
}

# The image must be the same wherever it is built: no path of this machine.
paths_out_of_the_image() {
    local flags=${RUSTFLAGS:-} registry compiler
    flags+=" --remap-path-prefix=$PWD=."
    for registry in "${CARGO_HOME:-$HOME/.cargo}"/registry/src/*/; do
        flags+=" --remap-path-prefix=${registry%/}=registry"
    done
    for compiler in rustc /usr/bin/rustc; do
        if bare_has_sources "$compiler"; then
            flags+=" --remap-path-prefix=$(bare_sysroot "$compiler")/lib/rustlib/src/rust=rust"
        fi
    done
    export RUSTFLAGS=$flags
}

lint_firmware() {
    cargo fmt --manifest-path "$FIRMWARE/Cargo.toml" --check
    if bare_clippy "$BOARD"; then
        (cd "$FIRMWARE" && bare_cargo "$BOARD" clippy --locked --quiet --release -- -D warnings)
    else
        skip "clippy on the firmware"
    fi
}

# build_image NAME CARGO-ARGUMENTS...
build_image() {
    local name=$1
    shift
    (cd "$FIRMWARE" && bare_cargo "$BOARD" build --locked --quiet --release "$@")
    cp "$(bare_dir "$BOARD")/$BOARD/release/faregate-bare-metal" "$out/$name.elf"
}

# The board, as `cargo run` has it.
board() {
    sed -n '/^runner = \[/,/^\]/p' "$FIRMWARE/.cargo/config.toml" | grep -o '"[^"]*"' | tr -d '"'
}

# fly NAME: runs an image; its exit code is the flight's. An instruction takes
# 2^7 ns, or what log2_ns says.
fly() {
    local command
    mapfile -t command < <(board)
    timeout 60 "${command[@]/shift=7/shift=${log2_ns:-7}}" "$out/$1.elf" </dev/null
}

fly_twice() {
    fly whole >"$out/first.txt" || fail "the flight ended with exit code $?"
    fly whole >"$out/second.txt" || fail "the second flight ended with exit code $?"
    cat "$out/first.txt"
    cmp "$out/first.txt" "$out/second.txt" || fail "two flights of one image differ"
}

# must_end CODE NAME TEXT: the image ends with this code, and says so.
must_end() {
    local code=0
    fly "$2" >"$out/$2.txt" 2>&1 || code=$?
    if [[ $code -ne $1 ]] || ! grep -Fq "$3" "$out/$2.txt"; then
        tail -n 5 "$out/$2.txt" >&2
        fail "$2 ends with exit code $code; it should end with $1 and say '$3'"
    fi
    echo "$2: exit code $code, $3"
}

# break | exit code | what it must say
readonly BREAKS="
revocation | 2 | LOST by bus trip
confirmation | 2 | LOST by bus trip
restoration | 1 | FAILED: this should be so, and is not: 8 the emergency relinquishes
"

fly_the_breaks() {
    local name code text
    while IFS='|' read -r name code text; do
        read -r name <<<"$name"
        [[ -n $name ]] || continue
        build_image "break-$name" --features "break-$name" </dev/null
        must_end $((code)) "break-$name" "${text# }"
    done <<<"$BREAKS"
    # Where an instruction takes another time, the counter must notice.
    cp "$out/whole.elf" "$out/another-clock.elf"
    log2_ns=6 must_end 1 another-clock "a hundred instructions are counted as a hundred"
}

# The image's sizes in bytes: code and constants, initialised data, other data.
sizes() {
    local tool
    for tool in size llvm-size rust-size; do
        "$tool" "$1" 2>/dev/null | awk 'NR == 2 { print $1, $2, $3 }' | grep . && return
    done
    echo "missing: size; on Debian: apt-get install binutils" >&2
    return "$BARE_MISSING"
}

# The rows "  count  what" of the output that follow a heading, as a table.
rows() {
    awk -v heading="$1" '
        /^[^ ]/ { on = $0 == heading; next }
        on && /^ +[0-9]+  / { n = $1; sub(/^ +[0-9]+  /, ""); printf "| %s | %d |\n", $0, n; next }
        on { sub(/^ +/, ""); printf "| *%s* | |\n", $0 }' "$out/first.txt"
}

figures() {
    local text data bss
    read -r text data bss < <(sizes "$out/whole.elf")
    cat <<FIGURES
<!-- bare-metal:begin -->
Written by \`ci/bare-metal.sh --write\`: $(bare_how "$BOARD"); \`$BOARD\`, optimised for size, under QEMU.

| memory | bytes |
|---|---:|
| flash of the whole example, simulated spacecraft and texts included | $((text + data)) |
| RAM of the whole example: statics | $((data + bss)) |
$(rows "bytes of memory")

| operation, on one core with interrupts masked | instructions |
|---|---:|
$(rows instructions)
<!-- bare-metal:end -->
FIGURES
}

committed() {
    [[ -e $PAGE ]] || return 0
    sed -n '/<!-- bare-metal:begin -->/,/<!-- bare-metal:end -->/p' "$PAGE"
}

write_figures() {
    [[ -e $PAGE ]] || printf '# Timing\n' >"$PAGE"
    grep -q '<!-- bare-metal:begin -->' "$PAGE" ||
        printf '\n## Bare metal\n\n<!-- bare-metal:begin -->\n<!-- bare-metal:end -->\n' >>"$PAGE"
    awk -v file="$out/figures.md" '
        /<!-- bare-metal:begin -->/ { while ((getline line < file) > 0) print line; old = 1 }
        !old
        /<!-- bare-metal:end -->/ { old = 0 }' "$PAGE" >"$out/page.md"
    cp "$out/page.md" "$PAGE"
    echo "written: $PAGE"
}

# Where the sources lie decides about the order of the functions, and so about
# some bytes of padding between them. Everything else is compared as it is.
readonly PADDING=64
readonly FLASH='^| flash of the whole example'

compare_flash() {
    local there here
    there=$(committed | grep "$FLASH" | tr -dc 0-9)
    here=$(grep "$FLASH" "$out/figures.md" | tr -dc 0-9)
    [[ $((here - there)) -le $PADDING && $((there - here)) -le $PADDING ]] ||
        fail "$PAGE has $there bytes of flash, and here it is $here: run ci/bare-metal.sh --write"
}

# Another compiler makes other figures, of the same things.
compare_figures() {
    local version
    version=$(bare_how "$BOARD")
    if committed | grep -qF -- "--write\`: $version;"; then
        diff <(committed | grep -v "$FLASH") <(grep -v "$FLASH" "$out/figures.md") ||
            fail "$PAGE has other figures: run ci/bare-metal.sh --write, and look at them"
        compare_flash
        echo "the figures are those of $PAGE"
        return
    fi
    diff <(committed | cut -d'|' -f2 | grep -v '^Written') \
        <(cut -d'|' -f2 "$out/figures.md" | grep -v '^Written') ||
        fail "$PAGE measures other things: run ci/bare-metal.sh --write, and look at them"
    echo "not compared: the figures; those of $PAGE are another compiler's than $version"
}

the_emergency() {
    bare_how "$BOARD"
    lint_firmware
    build_image whole
    fly_twice
    fly_the_breaks
    figures >"$out/figures.md"
    if $write; then write_figures; else compare_figures; fi
}

build_core() {
    local target
    for target in $ONLY_BUILT; do
        if ! bare_how "$target" >/dev/null; then
            skip "the core for $target"
            continue
        fi
        bare_cargo "$target" build --locked --quiet -p faregate-agents --features critical-section
        echo "builds: faregate-agents for $target ($(bare_how "$target"))"
    done
}

# The control: what needs compare-and-swap must not build where there is none.
build_without_sections() {
    local log=$out/without-sections.log
    if bare_cargo "$WITHOUT_SWAP" build --locked --quiet -p faregate-agents >"$log" 2>&1; then
        fail "read-modify-writes build for $WITHOUT_SWAP without critical sections: it is something else"
    fi
    grep -q 'requires atomic CAS' "$log" || fail "it does not build for another reason: see $log"
}

check_linux_on_arm() {
    bare_cargo "$LINUX_ON_ARM" check --locked --quiet -p faregate-tickets --features linux
    echo "checks: faregate-tickets with its Linux locks for $LINUX_ON_ARM ($(bare_how "$LINUX_ON_ARM"))"
}

# The steps are called plainly, never in a condition: there, `set -e` is off.
paths_out_of_the_image
if bare_packages qemu-system-arm qemu-system-arm && bare_how "$BOARD" >/dev/null; then
    the_emergency
else
    skip "the emergency on a Cortex-M4"
    # What could not be installed once will not be a moment later.
    export BARE_INSTALL=no
fi
build_core
if bare_how "$WITHOUT_SWAP" >/dev/null 2>&1; then build_without_sections; fi
if bare_how "$LINUX_ON_ARM" >/dev/null; then check_linux_on_arm; else skip "the Linux locks on Arm"; fi
