#!/usr/bin/env bash
# Feeds everything that reads what somebody else wrote with what nobody would
# write, and says which of its lines that reached.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
    cat <<'USAGE'
Usage: ci/fuzz.sh [--help] [--seconds N | --minutes N] [--jobs N] [--write] [TARGET...]

Runs each target (all without arguments: txt csv toml values command control
journal xml compact) for N seconds, 20 by default, --jobs at a time, as many as
there are processors by default. Then prints which lines of the readers were
reached by what was found, and fails below 90 of a hundred (only where all
targets ran). --write puts the figures into docs/fuzzing.md.

Needs a C++ compiler for libFuzzer, and no nightly compiler: the counters are a
pass of LLVM, and the readers have no unsafe code that a sanitizer would watch.
What was found is kept in target/fuzz/corpus; what failed, in
target/fuzz/failed: run target/fuzz/bin/TARGET FILE to see it again.
USAGE
}

seconds=20
jobs=$(nproc)
write=
targets=()
while [[ $# -gt 0 ]]; do
    case $1 in
    --help) usage && exit ;;
    --seconds) seconds=${2:?} && shift ;;
    --minutes) seconds=$((${2:?} * 60)) && shift ;;
    --jobs) jobs=${2:?} && shift ;;
    --write) write=yes ;;
    -*) usage >&2 && exit 2 ;;
    *) targets+=("$1") ;;
    esac
    shift
done
# A reader that takes so long for one input has failed. Counted by the clock on
# the wall, so a busy machine must not look like a slow reader.
export patience=60
all=(txt csv toml values command control journal xml compact)
[[ ${#targets[@]} -gt 0 ]] || targets=("${all[@]}")
for target in "${targets[@]}"; do
    [[ -f fuzz/targets/$target.rs ]] || {
        echo "there is no target $target; see ci/fuzz.sh --help" >&2
        exit 2
    }
done

# In CI a skip is a failure: nobody would see it.
skip() {
    echo "skipped: $1"
    [[ ${CI:-} != true ]] || exit 1
    exit
}
host=$(rustc -vV | sed -n 's/^host: //p')
[[ $host == *-linux-* ]] || skip "libFuzzer is built for Linux here, and this is $host"
if ! command -v "${CXX:-c++}" >/dev/null && [[ $(id -u) == 0 ]] && command -v apt-get >/dev/null; then
    apt-get update -qq && apt-get install -qq -y --no-install-recommends g++ >/dev/null || true
fi
command -v "${CXX:-c++}" >/dev/null || skip "there is no C++ compiler for libFuzzer (apt-get install g++)"

out=${CARGO_TARGET_DIR:-$PWD/target}/fuzz
mkdir -p "$out/bin" "$out/reach" "$out/failed"
build() {
    cargo build --locked --quiet --manifest-path fuzz/Cargo.toml --target "$host" "$@"
}
# With a target named, build scripts and macros get no counters.
counters="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters
    -Cllvm-args=-sanitizer-coverage-pc-table
    -Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1 --cfg fuzzing"
RUSTFLAGS=$counters build --release --target-dir "$out/counted" "${targets[@]/#/--bin=}"

# The words of the references, so that they need not be found letter by letter.
cat docs/schedule-format.md docs/plan-format.md | tr '`' '\n' |
    grep -E '^"?[][a-z_=A-Z0-9:" -]{2,24}$' | sort -u |
    sed 's/["\\]/\\&/g; s/.*/"&"/' >"$out/words"

# What people wrote, each file by itself.
seeds() {
    case $1 in
    csv | txt | toml)
        cp scheduler/tests/cases/*.{csv,txt} "$2"
        find scheduler/tests/format cli/missions examples -name '*.toml' -not -name Cargo.toml \
            -exec cp {} "$2" \; 2>/dev/null || true
        ;;
    # Files of one name lie in several folders.
    xml) find planner/templates examples -name '*.xml' -exec cp --backup=numbered {} "$2" \; ;;
    compact) cp planner/tests/compact/*.bin "$2" ;;
    esac
    [[ ! -d fuzz/seeds/$1 ]] || cp fuzz/seeds/"$1"/* "$2"
}

fuzz() {
    local target=$1 out=$2 seconds=$3 binary
    binary=$out/bin/$target
    mkdir -p "$out/corpus/$target" "$out/seeds/$target" "$out/failed/$target"
    if ! "$binary" -max_total_time="$seconds" -timeout="$patience" -rss_limit_mb=2048 -max_len=8192 \
        -dict="$out/words" -artifact_prefix="$out/failed/$target/" -print_final_stats=1 \
        "$out/corpus/$target" "$out/seeds/$target" >"$out/$target.log" 2>&1; then
        tail -n 40 "$out/$target.log"
        echo "$target fails: see $out/failed/$target" >&2
        return 1
    fi
    awk -v target="$target" '
        /stat::number_of_executed_units/ { runs = $2 }
        /cov: / { for (i = 1; i < NF; i++) if ($i == "cov:") branches = $(i + 1) }
        END { printf "%-10s %12d inputs %8d branches\n", target, runs, branches }
    ' "$out/$target.log"
}
export -f fuzz

for target in "${targets[@]}"; do
    cp "$out/counted/$host/release/$target" "$out/bin/$target"
    rm -rf "$out/seeds/$target" && mkdir -p "$out/seeds/$target"
    seeds "$target" "$out/seeds/$target"
done
printf '%s\n' "${targets[@]}" |
    xargs -P "$jobs" -I{} bash -c 'fuzz "$@"' _ {} "$out" "$seconds" | tee "$out/runs"

[[ ${#targets[@]} -eq ${#all[@]} ]] || exit 0
[[ $host == x86_64-* ]] || skip "lines are counted by breakpoints of x86-64, and this is $host"
# Without counters and optimization: each line has code of its own.
RUSTFLAGS="-Ccodegen-units=16" build --target-dir "$out/plain" "${all[@]/#/--bin=}"
build --release --target-dir "$out/plain" -p faregate-fuzz-lines
runs=()
for target in "${all[@]}"; do
    # What was found, reduced to what reaches more, and what people wrote.
    rm -rf "$out/reach/$target" && mkdir -p "$out/reach/$target"
    "$out/bin/$target" -merge=1 -timeout="$patience" "$out/reach/$target" "$out/seeds/$target" \
        "$out/corpus/$target" >"$out/$target.merge.log" 2>&1
    cp "$out/seeds/$target"/* "$out/reach/$target"
    runs+=("$out/plain/$host/debug/$target:$out/reach/$target")
done
"$out/plain/$host/release/faregate-fuzz-lines" --at-least 90 --of scheduler/src/format \
    --of scheduler/src/format.rs --of planner/src/file --of planner/src/file.rs \
    --of client/src/wire --of client/src/wire.rs \
    --of scheduler/src/journal/frame.rs --of scheduler/src/journal/segment.rs \
    "${runs[@]}" | tee "$out/lines.md"

if [[ -n $write ]]; then
    awk -v seconds="$seconds" -v figures="$out" '
        /<!-- figures -->/ { print; skip = 1
            print "\nEach target for " seconds " s:\n\n| target | inputs | branches |\n|---|---|---|"
            while ((getline line <(figures "/runs")) > 0) {
                split(line, word, " ")
                print "| `" word[1] "` | " word[2] " | " word[4] " |"
            }
            print "\nLines of the readers that they reach:\n"
            while ((getline line <(figures "/lines.md")) > 0) print line
            print "" }
        /<!-- end of figures -->/ { skip = 0 }
        !skip' docs/fuzzing.md >"$out/fuzzing.md"
    cp "$out/fuzzing.md" docs/fuzzing.md
fi
