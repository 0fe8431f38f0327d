#!/usr/bin/env bash
# Explores the loom models, then breaks one line of production code at a time
# and wants the named claim of the named model to fail.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
    cat <<'USAGE'
Usage: ci/loom.sh [--help] [MUTANT...]

Without arguments: all models, then all mutants. With arguments: these mutants
only. LOOM_MAX_PREEMPTIONS explores further than the models' own bounds.
USAGE
}

# What loom says when two threads are in one cell.
one_inside="Causality violation: Concurrent write accesses"
# feature | model | the claim that must fail
mutants="
tickets/any-tenant | doors::one_tenant | One Tenant: two tickets of one gate are valid together
tickets/check-then-act | doors::closed_door | Closed Door: a command was issued after quiescence
tickets/exempt-by-name | safe_mode::nobody_is_resurrected | Closed Door: revoke_all_but_me resurrected its ticket
tickets/late-epoch | safe_mode::late_epoch | Late Epoch Invariant: valid below the floor
tickets/late-safing | hand_over::late_safing | Restoration: late safing hit the restored holder
tickets/look-before-announcing | ways::empty_room_by_fence | $one_inside
tickets/look-first | shared::interlock | Interlock: both sides are on
tickets/no-fence | shared::interlock | Interlock: both sides are on
tickets/no-quiescence | doors::empty_room | Empty Room: a command was in progress
tickets/relaxed-entry | ways::quiescence_while_hammered | $one_inside
tickets/relaxed-exit | ways::empty_room_by_fence | $one_inside
tickets/relaxed-floor | safe_mode::revoke_all_but_me | Closed Door: a service revoked the exempt ticket
tickets/relaxed-publish | shared::telemetry | Bounded Validity: an old value was read with a new time
tickets/relaxed-withdrawal | shared::interlock_withdrawn | Interlock: the other side was still on
tickets/sections-go-on | ways::quiescence_by_store | Closed Door: a store was done after quiescence
tickets/stamp-outside | hand_over::restoration | Restoration: the restored ticket refuses
tickets/torn-reason | shared::reasons | Every Refusal Explains Itself: nobody revoked it like that
tickets/try-lock | doors::open_door | Open Door: a command of the valid ticket was not issued
tickets/turned-on-early | hand_over::margin_kept_while_commanded | Margin Kept: the draw exceeds the supply
tickets/unfenced | ways::empty_room_by_fence | $one_inside
agents/early-credit | hand_over::margin_kept | Margin Kept: the draw exceeds the supply
agents/late-admission | source_death::death_while_served | Source Death: the dead one's charge stays
agents/lost-bar | bars::bar_against_preemption | Closed Door: a restoration undid a bar
agents/noted-early | bars::bar_against_grant | Restoration: a reinstated ticket is valid
agents/stale-estimate | hand_over::only_fresh_estimates_credit | Margin Kept: an old estimate was credited
agents/taken-in-vain | sets::taken_in_vain | Highest First: a victim was taken in vain
scheduler/look-then-enter | shut_entrance | Causality violation: Concurrent read and write accesses
scheduler/relaxed-leave | shut_entrance | Causality violation: Concurrent read and write accesses
scheduler/ring-first | no_lost_beat | No Lost Beat: a beat waits, and nobody was rung for it
scheduler/silent-leave | shut_entrance | Shut Entrance: nobody told that the last one has left
"

explore() {
    RUSTFLAGS="--cfg loom" RUST_BACKTRACE=0 CARGO_PROFILE_RELEASE_DEBUG=0 \
        cargo test --locked --quiet --release --target-dir target/loom "$@" 2>&1
}

all_models() {
    explore -p faregate-tickets --lib
    explore -p faregate-agents --test loom -- --nocapture >target/loom/models.log || {
        cat target/loom/models.log
        return 1
    }
    explore -p faregate-scheduler-models -- --nocapture >>target/loom/models.log || {
        cat target/loom/models.log
        return 1
    }
    grep -o 'model [a-z_]*: [0-9]* executions' target/loom/models.log | tr -d : | sort |
        awk '{ printf "%-32s %9d executions\n", $2, $3 }'
}

# Only the claim counts: a mutant that does not build, or fails a floor or
# another claim, has not been killed.
kill_mutant() {
    local crate=${1%%/*} mutant=mutant-${1#*/} model=$2 claim=$3
    local log=target/loom/$mutant.log
    local models=(-p faregate-agents --features "faregate-$crate/$mutant" --test loom)
    if [[ $crate == scheduler ]]; then
        models=(-p faregate-scheduler-models --features "$mutant")
    fi
    if explore "${models[@]}" -- --nocapture --exact "$model" >"$log" || ! grep -Fq "$claim" "$log"; then
        tail -n 20 "$log"
        echo "$mutant survives $model, which should say '$claim'" >&2
        return 1
    fi
    printf '%-32s killed by %s (%s)\n' "$mutant" "$model" "${claim%:}"
}

if [[ ${1:-} == --help ]]; then
    usage
    exit
fi
for mutant in "$@"; do
    grep -Eq "^(tickets|agents|scheduler)/$mutant \|" <<<"$mutants" || {
        echo "there is no mutant $mutant; see the table in $0" >&2
        exit 2
    }
done
mkdir -p target/loom
if [[ $# -eq 0 ]]; then
    all_models
fi
survivors=0
while IFS='|' read -r feature model claim; do
    read -r feature <<<"$feature"
    read -r model <<<"$model"
    read -r claim <<<"$claim"
    [[ -n $feature ]] || continue
    [[ $# -eq 0 || " $* " == *" ${feature#*/} "* ]] || continue
    kill_mutant "$feature" "$model" "$claim" </dev/null || survivors=$((survivors + 1))
done <<<"$mutants"
if [[ $survivors -gt 0 ]]; then
    echo "$survivors mutants survived" >&2
    exit 1
fi
