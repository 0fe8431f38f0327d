//! What is wrong with a timed plan or with an execution.

use core::fmt;

use faregate_planner::plan::ActivityId;
use faregate_planner::units::Time;

macro_rules! rules {
    ($($(#[$doc:meta])* $rule:ident = $words:literal,)*) => {
        /// What a timed plan or an execution keeps.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Rule {
            $($(#[$doc])* $rule,)*
        }

        impl Rule {
            /// All of them, in order.
            pub const ALL: &'static [Self] = &[$(Self::$rule),*];

            /// What is wrong where it is broken.
            #[must_use]
            pub const fn words(self) -> &'static str {
                match self {
                    $(Self::$rule => $words,)*
                }
            }
        }
    };
}

rules! {
    /// One row for each activity, in the plan's order, true to the state.
    Rows = "the rows do not match the plan and the state",
    /// A start lies in the range that its row names.
    Range = "starts outside its start range",
    /// An end is not after the cutoff of the same range.
    Cutoff = "ends after its cutoff",
    /// An end is not after the plan's.
    End = "ends after the plan's end",
    /// It lasts as long as the ground says.
    Duration = "does not last its duration",
    /// An expanding one lasts at least its minimum, at most its duration.
    Expansion = "lasts shorter or longer than it can be expanded",
    /// What it depends on is over as it should be.
    Dependency = "starts although a dependency is not satisfied",
    /// At most one member of a group is selected or has started.
    Group = "another member of its group is selected",
    /// Two with a common resource usage bit never overlap.
    Resources = "shares a resource usage bit with what runs beside it",
    /// There are enough sequence engines.
    Engines = "more sequence engines are used than there are",
    /// The sum of peaks stays within the limit.
    Peak = "the sum of peaks is above the limit",
    /// Optional activities do not make more data than the plan allows.
    Data = "there is more data than the plan allows",
    /// Named timelines stay within their limits, and within what is asked of them.
    Timeline = "a timeline leaves its limits",
    /// Zones are warm when they are used.
    Heating = "a zone is not heated long enough before its use",
    /// Nothing is heated twice, or for nothing.
    HeatedTwice = "a zone is heated where no use needs it",
    /// The computer is up for what needs it.
    Computer = "the computer is not up for what needs it",
    /// Nothing that needs the computer overlaps a manual block.
    Manual = "a manual shutdown is not left alone",
    /// A wakeup takes as long as it takes.
    Wakeup = "a wakeup does not take its time",
    /// So does a shutdown.
    Shutdown = "a shutdown does not take its time",
    /// No awake phase is shorter than the minimum.
    MinAwake = "an awake phase is too short",
    /// No sleep is shorter than the minimum.
    MinSleep = "a sleep is too short",
    /// No sleep goes past the maximum state of charge.
    Full = "a sleep goes past the maximum state of charge",
    /// What is generated is what the rules make of the activities.
    Generated = "generated otherwise than the rules say",
    /// Nothing brings the charge below the soft minimum.
    SoftMinimum = "the charge falls below the soft minimum",
    /// Optional activities leave the handover minimum.
    Handover = "the charge at handover falls below its minimum",
    /// What starts within the commit window is left alone.
    Commit = "the commit window is not kept",
    /// Limits that mandatory activities exceed are listed.
    Excess = "what mandatory activities exceed is not listed truly",
    /// Limits that are broken whatever is planned are listed.
    Unavoidable = "what is broken whatever is planned is not listed truly",
    /// No activity that is left out could have started in a sleep.
    Sleep = "could have been scheduled in a sleep",
    /// The reason for which one is left out is true.
    Reason = "the reason for which it is left out is not true",
    /// Execution: it starts inside a start range.
    Dispatched = "was dispatched outside its start ranges",
    /// Execution: what it depends on has ended as it should.
    DispatchedAfter = "was dispatched although a dependency was not satisfied",
    /// Execution: the zones that it uses are warm, by estimate and in truth.
    DispatchedWarm = "was dispatched although a zone was not warm",
    /// Execution: the variables that it asks for are as they should be.
    DispatchedVariables = "was dispatched although a variable was not as it should be",
    /// Execution: the computer is up.
    DispatchedAwake = "ran although the computer was not up",
    /// Execution: no two with a common bit run.
    RanResources = "ran beside another with the same resource usage bit",
    /// Execution: there are enough sequence engines.
    RanEngines = "more sequence engines were used than there are",
    /// Execution: the truth about peaks stays within the limit.
    RanPeak = "the sum of peaks was above the limit",
    /// Execution: nothing runs or is paused past its cutoff.
    RanPastCutoff = "was not over at its cutoff",
    /// Execution: nothing that draws power runs on at the hard limit.
    RanAtHardLimit = "ran on at the hard limit of the state of charge",
    /// Execution: nothing that draws power runs on while nobody knows the charge.
    RanBlind = "ran on although nobody knew the charge any more",
    /// Execution: nothing optional runs on below the soft limit.
    RanBelowSoft = "is optional, and ran on below the soft limit",
    /// Execution: nothing optional runs on past its duration.
    RanPastDuration = "is optional, and ran on past its duration",
    /// Execution: an abort has its cause.
    AbortCause = "was aborted without its cause",
    /// Execution: an abort revokes, then makes safe.
    AbortSafed = "was aborted, but not revoked and made safe",
    /// Execution: only what is marked so is paused.
    Paused = "was paused although it is not pausable",
    /// Execution: an early start is in nobody's way.
    EarlyBeside = "started early in the way of what is planned",
    /// Execution: no sleep ends before it is worth it.
    SleptTooShort = "slept shorter than the minimum, with a wakeup as planned",
    /// Execution: a cleanup follows a failure or an abort.
    CleanupAfter = "cleaned up although nothing had failed or was aborted",
    /// Execution: at most one member of a group starts.
    RanGroup = "started although another member of its group had",
    /// Execution: a new plan leaves the commit window alone.
    Recommitted = "a new plan did not leave the commit window alone",
    /// Execution: at handover the next plan takes over, or it is said why not.
    TookOver = "the next plan did not take over as it should",
    /// Execution: the load is that of what was commanded.
    TrueLoad = "what is drawn is not what was commanded",
    /// Execution: the charge is what generation and loads make of it.
    TrueCharge = "the charge does not follow from what was drawn",
    /// Execution: the data on board are what was made and not sent.
    TrueData = "the data on board is not the sum of what was made and sent",
    /// Execution: a plan is made from what timelines have become.
    TimelinesTold = "a plan was made from other timelines than there were",
    /// Execution: what is recorded is in order of time.
    InOrder = "the record is not in order of time",
    /// Execution: every activity has one fate.
    Fate = "has no fate, or more than one",
}

/// A rule is broken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Which one.
    pub rule: Rule,
    /// By which activity, where one can be named.
    pub who: Option<ActivityId>,
    /// When first.
    pub at: Time,
    /// By how much, in the rule's unit; 0 where it has none.
    pub amount: i128,
    /// More about it: a zone, a timeline, what was expected.
    pub detail: String,
}

impl Violation {
    pub(crate) fn new(rule: Rule, who: Option<ActivityId>, at: i64) -> Self {
        Self { rule, who, at: Time::new(at), amount: 0, detail: String::new() }
    }

    pub(crate) fn by(self, amount: impl Into<i128>) -> Self {
        Self { amount: amount.into(), ..self }
    }

    pub(crate) fn detail(self, detail: impl Into<String>) -> Self {
        Self { detail: detail.into(), ..self }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at {}: ", self.at)?;
        if let Some(who) = self.who {
            write!(f, "{who}: ")?;
        }
        f.write_str(self.rule.words())?;
        if self.amount != 0 {
            write!(f, ", by {}{}", self.amount, unit(self.rule))?;
        }
        if !self.detail.is_empty() {
            write!(f, " ({})", self.detail)?;
        }
        Ok(())
    }
}

const fn unit(rule: Rule) -> &'static str {
    match rule {
        Rule::Peak | Rule::RanPeak | Rule::TrueLoad => " mW",
        Rule::Data | Rule::TrueData => " B",
        Rule::SoftMinimum
        | Rule::Handover
        | Rule::Full
        | Rule::RanAtHardLimit
        | Rule::TrueCharge => " uJ",
        Rule::Range
        | Rule::Cutoff
        | Rule::End
        | Rule::Duration
        | Rule::Expansion
        | Rule::Heating
        | Rule::Wakeup
        | Rule::Shutdown
        | Rule::MinAwake
        | Rule::MinSleep
        | Rule::RanPastCutoff
        | Rule::RanBlind
        | Rule::SleptTooShort
        | Rule::TookOver
        | Rule::RanPastDuration => " ms",
        _ => "",
    }
}
