#!/usr/bin/env bash
# Runs every example to its end. Usage: ci/examples.sh
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p target
# The soak has a check of its own; here it only shows that it runs.
declare -A arguments=([latency]="--quick" [soak]="--revocations 200000")
for file in examples/*.rs examples/*/main.rs; do
    example=$(basename "${file%/main.rs}" .rs)
    echo "== $example"
    read -ra given <<<"${arguments[$example]:-}"
    cargo run --locked --quiet --release --example "$example" -- "${given[@]}" >"target/example-$example.log" 2>&1 || {
        cat "target/example-$example.log"
        echo "example $example failed" >&2
        exit 1
    }
    tail -n 3 "target/example-$example.log"
done
echo "== schedule"
if [[ $(uname) == Linux ]]; then
    examples/schedule/run.sh all >target/example-schedule.log 2>&1 || {
        cat target/example-schedule.log
        echo "example schedule failed" >&2
        exit 1
    }
    tail -n 3 target/example-schedule.log
else
    echo "skipped: processes are run on Linux alone"
    [[ ${CI:-} != true ]]
fi
echo "== sols"
examples/sols/run.sh all >target/example-sols.log 2>&1 || {
    cat target/example-sols.log
    echo "example sols failed" >&2
    exit 1
}
tail -n 3 target/example-sols.log
