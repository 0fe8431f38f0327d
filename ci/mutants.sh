#!/usr/bin/env bash
# Breaks one line of the planner or the schedule manager at a time, in a copy of
# the tree, and wants the named test to fail: what a test claims, it sees.
set -euo pipefail
cd "$(dirname "$0")/.."

tables=(ci/lib/planner-mutants.txt ci/lib/scheduler-mutants.txt)

usage() {
    cat <<USAGE
Usage: ci/mutants.sh [--help] [--list] [--in FILE] [MUTANT...]

Without arguments: all mutants of ci/lib/*-mutants.txt. With arguments: these
only, each by a part of its name, or with --in all that break a file, by a part
of its path. --list says what would be broken, and breaks nothing. For each
mutant the crate that it breaks is compiled once, and one test of it run.
USAGE
}

lists=false in_file=
while (($#)); do
    case $1 in
    --help) usage && exit ;;
    --list) lists=true && shift ;;
    --in) in_file=${2:?'--in wants a file'} && shift 2 ;;
    --*) usage >&2 && exit 2 ;;
    *) break ;;
    esac
done

tree=$PWD/target/mutants/tree logs=$PWD/target/mutants
export CARGO_TARGET_DIR=${MUTANTS_TARGET_DIR:-$PWD/target/mutants/build}
export RUST_BACKTRACE=0 CARGO_PROFILE_DEV_DEBUG=0 CARGO_INCREMENTAL=1
# Some mutants go on for ever: that is no kill, and must not stop the others.
# Seconds of processor, so that a slow machine makes no difference.
patience=300

# The package and the target of a test, as cargo is told.
target() {
    case $1 in
    lib) echo -p faregate-planner --lib ;;
    trust) echo -p faregate-checker --test trust ;;
    rehearsal | broken) echo -p faregate-rehearsal --test "$1" ;;
    scheduler:*) echo -p faregate-scheduler --test "${1#*:}" ;;
    *) echo -p faregate-planner --test "$1" ;;
    esac
}

# Compiled for each mutant, and run once: so nothing is optimised, and what a
# mutant does not change is kept.
quick=()
for crate in planner checker rehearsal; do
    quick+=(--config "profile.dev.package.faregate-$crate.opt-level=0")
done

# Runs these tests of a target in the copy.
tests() {
    local target=$1 package
    shift
    read -ra package <<<"$(target "$target")"
    (cd "$tree" && ulimit -t "$patience" && cargo test --locked --quiet "${package[@]}" \
        "${quick[@]}" -- --exact "$@" 2>&1)
}

wanted() {
    local name=$1 file=$2 part
    shift 2
    [[ $file == *"$in_file"* ]] || return 1
    [[ $# -gt 0 ]] || return 0
    for part in "$@"; do
        [[ $name != *"$part"* ]] || return 0
    done
    return 1
}

names=() files=() froms=() tos=() targets=() killers=()
# A mutant is a name, a file, what stands there and what is to, and who sees it.
while IFS= read -r name; do
    [[ -n $name && $name != \#* ]] || continue
    IFS= read -r file && IFS= read -r from && IFS= read -r to && IFS= read -r test
    read -r file <<<"$file"
    if [[ $from != '- '* || $to != +* || $test != '! '*' '* ]]; then
        echo "'$name' is no mutant: it wants lines that begin with -, + and !" >&2
        exit 2
    fi
    wanted "$name" "$file" "$@" || continue
    to=${to#+} test=${test#! }
    names+=("$name") files+=("$file") froms+=("${from#- }") tos+=("${to# }")
    targets+=("${test%% *}") killers+=("${test#* }")
done < <(cat "${tables[@]}")

if [[ ${#names[@]} -eq 0 ]]; then
    echo "there is no such mutant; see ${tables[*]}" >&2
    exit 2
fi
if $lists; then
    for i in "${!names[@]}"; do
        printf '%-36s %-42s %s %s\n' "${names[i]}" "${files[i]}" "${targets[i]}" "${killers[i]}"
    done
    exit
fi

rm -rf "$tree"
mkdir -p "$tree"
git ls-files -z | xargs -0 cp --parents -t "$tree"

# The control: the tree as it is. A test that is not there passes, too, and so
# they are counted.
for target in $(printf '%s\n' "${targets[@]}" | sort -u); do
    mapfile -t all < <(for i in "${!names[@]}"; do
        [[ ${targets[i]} != "$target" ]] || echo "${killers[i]}"
    done | sort -u)
    echo "the tree as it is: ${#all[@]} tests of $target"
    if ! tests "$target" "${all[@]}" >"$logs/none-${target//:/-}.log" ||
        ! grep -q "test result: ok. ${#all[@]} passed" "$logs/none-${target//:/-}.log"; then
        tail -n 40 "$logs/none-${target//:/-}.log"
        echo "without any mutant, not all of these tests of $target are there and pass:" >&2
        printf '    %s\n' "${all[@]}" >&2
        exit 1
    fi
done

survivors=()
# Only the named test counts: a mutant that does not build has not been killed.
break_one() {
    local i=$1 source rest log
    log=$logs/${names[i]//[^a-zA-Z0-9]/-}.log
    source=$(cat "${files[i]}" && printf x)
    source=${source%x}
    rest=${source/"${froms[i]}"/}
    if [[ $rest == "$source" || $rest == *"${froms[i]}"* ]]; then
        echo "'${names[i]}': ${files[i]} has not exactly one '${froms[i]}'" >&2
        survivors+=("${names[i]}")
        return
    fi
    printf %s "${source/"${froms[i]}"/"${tos[i]}"}" >"$tree/${files[i]}"
    if tests "${targets[i]}" "${killers[i]}" >"$log" ||
        ! grep -q '^test result: FAILED' "$log"; then
        tail -n 20 "$log"
        echo "'${names[i]}' survives ${targets[i]} ${killers[i]}" >&2
        survivors+=("${names[i]}")
    else
        printf '%-40s killed by %s %s\n' "${names[i]}" "${targets[i]}" "${killers[i]}"
    fi
    printf %s "$source" >"$tree/${files[i]}"
}

for i in "${!names[@]}"; do
    break_one "$i"
done
if [[ ${#survivors[@]} -gt 0 ]]; then
    printf '%s\n' "${survivors[@]}"
    echo "${#survivors[@]} of ${#names[@]} mutants survived" >&2
    exit 1
fi
echo "all ${#names[@]} mutants were killed"
