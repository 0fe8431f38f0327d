#!/usr/bin/env bash
# Plans the example sols: prints the tables, and draws pictures. Fails where a
# plan breaks a rule, or where a mandatory activity is left out of any but the
# plan that is too much, which must end with exit code 2.
# Usage: examples/sols/run.sh busy|winter|conjunction|too-much|all [DIRECTORY]
# DIRECTORY: where the pictures go; without it, none are drawn.
# FAREGATE_BIN: the program; without it, it is built.
set -euo pipefail

usage() {
    sed -n '2,7s/^# //p' "$0"
    exit "$1"
}

[[ $# -ge 1 && $# -le 2 ]] || usage 2
case $1 in
    busy | winter | conjunction | too-much) sols=("$1") ;;
    all) sols=(busy winter conjunction too-much) ;;
    -h | --help) usage 0 ;;
    *) usage 2 ;;
esac
pictures=
if [[ $# -eq 2 ]]; then
    mkdir -p "$2"
    pictures=$(realpath "$2")
fi
cd "$(dirname "$0")"

if [[ -z ${FAREGATE_BIN:-} ]]; then
    cargo build --quiet --locked -p faregate-cli
    target=$(cargo metadata --locked --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
    FAREGATE_BIN=$target/debug/faregate
fi

# The exit code of each plan.
declare -A expected=([busy]=0 [winter]=0 [conjunction]=0 [too-much]=2)
for sol in "${sols[@]}"; do
    arguments=("$sol/plan.xml" --parameters parameters.xml --state "$sol/state.xml")
    [[ -n $pictures ]] && arguments+=(--svg "$pictures/$sol.svg")
    code=0
    "$FAREGATE_BIN" plan make "${arguments[@]}" || code=$?
    [[ $code -eq ${expected[$sol]} ]] || {
        echo "$sol ended with exit code $code, and not with ${expected[$sol]}" >&2
        exit 1
    }
done
