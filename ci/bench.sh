#!/usr/bin/env bash
# Runs every bench, the latency example and a short soak, sums them up in
# target/bench/summary.json, and prints the table. The figures inform: a target
# that is missed fails nothing, a bench that breaks does.
# Usage: ci/bench.sh [--write] [--quick]
#   --write  puts the table and the curves into docs/
#   --quick  a tenth of the rounds, and a shorter soak: a look
set -euo pipefail
cd "$(dirname "$0")/.."

write=() quick=() revocations=2000000
for argument in "$@"; do
    case "$argument" in
        --write) write=(--write) ;;
        --quick) quick=(--quick) revocations=200000 ;;
        -h | --help)
            sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//p}' "$0"
            exit 0
            ;;
        *)
            echo "unknown argument $argument; see --help" >&2
            exit 2
            ;;
    esac
done

out="${CARGO_TARGET_DIR:-target}/bench"
mkdir -p "$out"
# What an earlier run left must not pass for this one's.
rm -f "$out"/*.json

# Which of the names after `--bench` or `--example` this checkout has.
has() {
    cargo metadata --locked --no-deps --format-version 1 |
        grep -q "\"kind\":\[\"$1\"\],\"crate_types\":\[\"bin\"\],\"name\":\"$2\""
}

for bench in invoke curves emergency schedule journal planner; do
    if ! has bench "$bench"; then
        echo "== bench $bench: skipped, there is none"
        continue
    fi
    echo "== bench $bench"
    cargo bench --locked --quiet --bench "$bench" -- "${quick[@]}" --out "$out"
done

if has example latency; then
    echo "== example latency"
    cargo run --locked --quiet --release --example latency -- "${quick[@]}" --json "$out/latency.json"
else
    echo "== example latency: skipped, there is none"
fi
if has example soak; then
    echo "== example soak"
    cargo run --locked --quiet --release --example soak -- --revocations "$revocations" --json
else
    echo "== example soak: skipped, there is none"
fi

cargo bench --locked --quiet --bench summary -- --fragments "$out" "${write[@]}"
