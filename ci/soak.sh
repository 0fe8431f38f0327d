#!/usr/bin/env bash
# Revokes under load, and wants no command after quiescence. Then breaks it on
# purpose in two ways, and wants that seen.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
    cat <<'USAGE'
Usage: ci/soak.sh [--help] [REVOCATIONS]

Without arguments: 10^7 revocations, at most 3 minutes on two processors. The
figures are in target/bench/soak.json. What the host does not permit is said;
with CI=true it is a failure.
USAGE
}

if [[ ${1:-} == --help ]]; then
    usage
    exit
fi
soak() {
    cargo run --locked --quiet --release --example soak -- "$@"
}
soak --json --revocations "${1:-10000000}"
# Every row of these must show commands after quiescence, or the exit code is 1.
for how in skip-quiescence check-outside; do
    echo "== broken on purpose: $how"
    soak --break "$how" --revocations 100000
done
