#!/usr/bin/env bash
# Has an exact solver (HiGHS, from PyPI) find the best that can be made of the
# small worlds that benches/planner compares with. Says how many it has proven.
# Usage: ci/optimum.sh [--write | --verify] [--seconds LIMIT]
#   --write    puts the optima into planner/tools/optima.csv; else they are printed
#   --verify   solves nothing: only forces plans of the planner's into the solver's
#              model, each of which must fit
#   --seconds  so long for each world at most (120); what is not proven then
#              stands with its bound
# Skipped, with a message, where there is no Python or no PyPI. With CI=true that
# is a failure.
set -euo pipefail
cd "$(dirname "$0")/.."

write=0 verify=() seconds=120
while (($#)); do
    case "$1" in
        --write) write=1 ;;
        --verify) verify=(--verify) ;;
        --seconds)
            seconds="${2:?--seconds takes a number}"
            shift
            ;;
        -h | --help)
            sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//p}' "$0"
            exit 0
            ;;
        *)
            echo "unknown argument $1; see --help" >&2
            exit 2
            ;;
    esac
    shift
done

skip() {
    echo "optimum: skipped, $1" >&2
    [[ "${CI:-}" == true ]] && exit 1
    exit 0
}

command -v python3 >/dev/null || skip "there is no python3"
venv="${CARGO_TARGET_DIR:-target}/optimum"
python3 -m venv "$venv" || skip "python3 cannot make a virtual environment"
"$venv/bin/pip" install --quiet --requirement planner/tools/requirements.txt ||
    skip "the solver cannot be installed"

worlds() {
    cargo run --locked --quiet --release --package faregate-planner --example small_worlds -- \
        0 15 20 30 40
}

found="$(mktemp)"
trap 'rm -f "$found"' EXIT
worlds | "$venv/bin/python" planner/tools/optimum.py "${verify[@]}" --seconds "$seconds" >"$found"
if ((write)) && ! ((${#verify[@]})); then
    cp "$found" planner/tools/optima.csv
    echo "planner/tools/optima.csv: $(($(wc -l <"$found") - 1)) worlds"
else
    cat "$found"
fi
