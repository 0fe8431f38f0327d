#!/usr/bin/env bash
# Draws the documentation's pictures again and wants the same ones: they are
# what the code does now. Usage: ci/picture.sh [--write]
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p target
directory=target
[[ ${1:-} == --write ]] && directory=docs
cargo run --locked --quiet --release --example stuck_thruster -- --seed 1 --runs 1 --svg "$directory/emergency.svg" >/dev/null
sols=examples/sols
cargo run --locked --quiet -p faregate-cli -- plan make "$sols/busy/plan.xml" --parameters "$sols/parameters.xml" \
    --state "$sols/busy/state.xml" --svg "$directory/plan.svg" >/dev/null
for picture in emergency plan; do
    cmp "$directory/$picture.svg" "docs/$picture.svg" || {
        echo "docs/$picture.svg is old: run ci/picture.sh --write, and look at it" >&2
        exit 1
    }
done
