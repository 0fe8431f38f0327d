#!/usr/bin/env bash
# Draws the README's picture again and wants the same one: it is what the code
# does now. Usage: ci/picture.sh [--write]
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p target
picture=target/emergency.svg
[[ ${1:-} == --write ]] && picture=docs/emergency.svg
cargo run --locked --quiet --release --example stuck_thruster -- --seed 1 --runs 1 --svg "$picture" >/dev/null
cmp "$picture" docs/emergency.svg || {
    echo "the README's picture is old: run ci/picture.sh --write, and look at it" >&2
    exit 1
}
