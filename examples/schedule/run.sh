#!/usr/bin/env bash
# Runs examples of the schedule manager, in real time where they are not virtual.
# Fails where the program says that something went wrong.
# Usage: examples/schedule/run.sh upload|stp_h6|stp_h7|recovery|all
# FAREGATE_BIN: the program; without it, it is built.
set -euo pipefail
cd "$(dirname "$0")"

usage() {
    sed -n '2,5s/^# //p' run.sh
    exit "$1"
}

if [[ -z ${FAREGATE_BIN:-} ]]; then
    cargo build --quiet --locked -p faregate-cli
    target=$(cargo metadata --locked --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
    FAREGATE_BIN=$target/debug/faregate
fi
# Scripts inside tasks call it by its name.
PATH=$(dirname "$(realpath "$FAREGATE_BIN")"):$PATH
export PATH

upload() {
    cd upload
    directory=$(mktemp -d)
    export FAREGATE_SOCKET=$directory/faregate.sock
    faregate run mission.toml --socket "$FAREGATE_SOCKET" --for 10 &
    manager=$!
    # Whatever goes wrong, no manager is left behind.
    trap 'kill "$manager" 2>/dev/null || true; rm -rf "$directory"' EXIT
    for _ in $(seq 100); do
        [[ -S $FAREGATE_SOCKET ]] && break
        sleep 0.05
    done
    faregate add upload.csv
    faregate status
    wait "$manager"
}

stp_h6() {
    cd stp_h6
    faregate check schedule.csv
    faregate run --virtual --for 1600 schedule.csv
    faregate analyze schedule.csv --horizon 1600 --at 0
}

stp_h7() {
    cd stp_h7
    faregate check schedule.toml
    faregate run schedule.toml
}

recovery() {
    cd recovery
    faregate check schedule.toml
    faregate run schedule.toml
}

[[ $# -eq 1 ]] || usage 2
case $1 in
    upload | stp_h6 | stp_h7 | recovery) "$1" ;;
    all)
        for example in upload stp_h6 stp_h7 recovery; do
            echo "== $example"
            ("$example")
        done
        ;;
    -h | --help) usage 0 ;;
    *) usage 2 ;;
esac
