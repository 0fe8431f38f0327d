//! What is executed wrongly.

use faregate_checker::Rule;

use super::Entry;
use super::Mutant::Executed;
use crate::executions::{changes as executions, physics};

/// Which rule catches which mutant.
pub(super) const MUTANTS: &[Entry] = &[
    (Rule::Dispatched, "starts before its range", Executed(executions::before_its_range)),
    (Rule::DispatchedAfter, "does not wait", Executed(executions::prior_fails)),
    (Rule::DispatchedWarm, "a zone is not ok", Executed(executions::cold)),
    (Rule::DispatchedWarm, "a zone is truly cold", Executed(executions::truly_cold)),
    (Rule::DispatchedVariables, "a variable is unknown", Executed(executions::unknown)),
    (Rule::DispatchedAwake, "the computer goes down", Executed(executions::goes_down)),
    (Rule::RanResources, "bits are not looked at", Executed(executions::shares_bits)),
    (Rule::RanEngines, "engines are not counted", Executed(executions::too_many_engines)),
    (Rule::RanPeak, "peaks are not counted", Executed(executions::too_much_peak)),
    (Rule::RanPastCutoff, "runs 1 ms past its cutoff", Executed(executions::past_cutoff)),
    (Rule::RanAtHardLimit, "an estimate is ignored", Executed(executions::below_hard)),
    (Rule::RanAtHardLimit, "estimates are wrong", Executed(executions::truly_below_hard)),
    (Rule::RanBelowSoft, "optional ones go on", Executed(executions::below_soft)),
    (Rule::RanPastDuration, "an optional one goes on", Executed(executions::past_duration)),
    (Rule::AbortCause, "aborts without need", Executed(executions::aborted_for_nothing)),
    (Rule::AbortSafed, "does not revoke", Executed(executions::not_revoked)),
    (Rule::AbortSafed, "does not make safe", Executed(executions::not_safed)),
    (Rule::Paused, "pauses what cannot be", Executed(executions::paused)),
    (Rule::CleanupAfter, "cleans up for nothing", Executed(executions::cleans_up)),
    (Rule::RanGroup, "starts two of a group", Executed(executions::two_of_a_group)),
    (Rule::Recommitted, "replans at once", Executed(executions::recommitted)),
    (Rule::RanBlind, "trusts an old estimate", Executed(physics::trusts_old)),
    (Rule::EarlyBeside, "starts early at any price", Executed(physics::early_in_the_way)),
    (Rule::SleptTooShort, "sleeps 1 ms short", Executed(physics::short_sleep)),
    (Rule::TookOver, "forgets the next plan", Executed(physics::forgets_next)),
    (Rule::TookOver, "hands over 1 ms late", Executed(physics::hands_over_late)),
    (Rule::TrueLoad, "draws 1 mW asleep", Executed(physics::draws_asleep)),
    (Rule::TrueCharge, "finds 1 J", Executed(physics::finds_charge)),
    (Rule::TrueData, "loses 1 B", Executed(physics::loses_data)),
    (Rule::TimelinesTold, "plans with what was", Executed(physics::old_timelines)),
    (Rule::InOrder, "records late", Executed(executions::out_of_order)),
    (Rule::Fate, "loses one", Executed(executions::loses_one)),
    (Rule::Fate, "starts one twice", Executed(executions::twice)),
];
