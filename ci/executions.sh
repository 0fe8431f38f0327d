#!/usr/bin/env bash
# Executes random plans on the simulated rover, checks every execution, and wants
# no rule broken and each kind of abort, cleanups, early starts, pauses, vetoes
# and handovers seen at least once.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
    cat <<'USAGE'
Usage: ci/executions.sh [--executions N] [--seed N] [--help]

    --executions N   so many, each of another plan (2000)
    --seed N         the first seed (1)

The counts are printed, and are in target/executions.log. An execution that
breaks a rule is named by its seed: `faregate plan run --random --seed N` shows
it again.
USAGE
}

executions=2000
seed=1
while (($#)); do
    case $1 in
    --executions) executions=$2 && shift 2 ;;
    --seed) seed=$2 && shift 2 ;;
    --help) usage && exit ;;
    *) usage >&2 && exit 2 ;;
    esac
done
run() {
    cargo run --locked --quiet --release -p faregate-cli -- plan run --random "$@"
}
mkdir -p target
# The control: in a single execution most of it cannot come up.
if run --campaign 1 >target/executions.log 2>&1 || ! grep -q '^no handover' target/executions.log; then
    cat target/executions.log
    echo "ci/executions.sh: what never came up was not noticed" >&2
    exit 1
fi
run --campaign "$executions" --seed "$seed" >target/executions.log || {
    cat target/executions.log
    exit 1
}
cat target/executions.log
