#!/usr/bin/env bash
# Breaks one line of the planner at a time, in a copy of the tree, and wants the
# named test to fail: what a test claims, it sees.
set -euo pipefail
cd "$(dirname "$0")/.."

table=ci/lib/planner-mutants.txt

usage() {
    cat <<USAGE
Usage: ci/mutants.sh [--help] [MUTANT...]

Without arguments: all mutants of $table. With arguments: these
only, each by a part of its name. A mutant takes about ten seconds of processor.
USAGE
}

if [[ ${1:-} == --help ]]; then
    usage
    exit
fi

tree=$PWD/target/mutants/tree
export CARGO_TARGET_DIR=$PWD/target/mutants/build RUST_BACKTRACE=0
export CARGO_PROFILE_DEV_DEBUG=0 CARGO_INCREMENTAL=0
rm -rf "$tree"
mkdir -p "$tree"
git ls-files -z | xargs -0 cp --parents -t "$tree"

# Less is compiled than optimised: the crate is compiled for each mutant.
tests() {
    (cd "$tree" && cargo test --locked --quiet -p faregate-planner --test manager \
        --test exchanged --no-fail-fast \
        --config profile.dev.package.faregate-planner.opt-level=0 2>&1)
}

# What fails, one name on a line.
failures() {
    sed -n 's/^test \(.*\) \.\.\. FAILED$/\1/p; s/^    \([a-z_0-9:]*\)$/\1/p' | sort -u
}

echo "the tree as it is"
tests >target/mutants/none.log || {
    tail -n 40 target/mutants/none.log
    echo "its tests fail without any mutant" >&2
    exit 1
}

survivors=0 tried=0
# Only the named test counts: a mutant that does not build has not been killed.
kill_mutant() {
    local name=$1 file=$2 from=$3 to=$4 test=$5 source rest log
    log=target/mutants/${name//[^a-z0-9]/-}.log
    source=$(cat "$file"; printf x)
    source=${source%x}
    rest=${source/"$from"/}
    if [[ $rest == "$source" || $rest == *"$from"* ]]; then
        echo "$name: $file has not exactly one '$from'" >&2
        survivors=$((survivors + 1))
        return
    fi
    printf %s "${source/"$from"/"$to"}" >"$tree/$file"
    if tests >"$log" || ! failures <"$log" | grep -Fxq "$test"; then
        tail -n 20 "$log"
        echo "'$name' survives $test" >&2
        survivors=$((survivors + 1))
    else
        printf '%-40s killed by %s\n' "$name" "$test"
    fi
    printf %s "$source" >"$tree/$file"
}

wanted() {
    local part
    [[ $# -gt 1 ]] || return 0
    for part in "${@:2}"; do
        [[ $1 != *"$part"* ]] || return 0
    done
    return 1
}

while read -r name; do
    [[ -n $name && $name != \#* ]] || continue
    IFS= read -r file
    IFS= read -r from
    IFS= read -r to
    IFS= read -r test
    wanted "$name" "$@" || continue
    tried=$((tried + 1))
    to=${to#+}
    kill_mutant "$name" "${file#  }" "${from#- }" "${to# }" "${test#! }" </dev/null
done <"$table"
if [[ $tried -eq 0 ]]; then
    echo "there is no such mutant; see $table" >&2
    exit 2
fi
if [[ $survivors -gt 0 ]]; then
    echo "$survivors of $tried mutants survived" >&2
    exit 1
fi
echo "all $tried mutants were killed"
