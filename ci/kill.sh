#!/usr/bin/env bash
# Kills a schedule manager, with real processes and a device, at every named
# place of its journal, its execs and its reaps; starts it again until its
# schedule is over; and looks at what came of it. Then breaks it on purpose in
# two ways, and wants that seen.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
    cat <<'USAGE'
Usage: ci/kill.sh [--help] [DEATHS]

Without arguments: at least 20 deaths at each place, about 2 minutes on two
processors. A place that is never died at is a failure. Linux only: elsewhere it
says that it is skipped, and with CI=true that is a failure.
USAGE
}

if [[ ${1:-} == --help ]]; then
    usage
    exit
fi
if [[ $(uname -s) != Linux ]]; then
    echo "skipped: children die with their manager on Linux alone" >&2
    [[ ${CI:-} != true ]]
    exit
fi
campaign() {
    cargo test --locked --quiet -p faregate-scheduler --features kill-points \
        --test kill_campaign -- "$@"
}
campaign --deaths "${1:-20}"
for how in uncommitted left-on; do
    echo "== broken on purpose: $how"
    campaign --break "$how" --deaths 20
done
