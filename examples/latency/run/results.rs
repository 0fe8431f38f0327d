//! What came of all rows: the figures, and what no host excuses.

use serde::Serialize;

use super::measured::Measured;
use super::rights::Placement;
use super::rows::{Case, Expected};
use super::stage::HOG_WORKS;

/// A row that was played.
#[derive(Clone, Debug)]
pub(crate) struct Played {
    pub(crate) case: Case,
    pub(crate) who: &'static str,
    pub(crate) expected: Expected,
    pub(crate) target_us: Option<u32>,
    pub(crate) placement: Placement,
    pub(crate) measured: Measured,
}

impl Played {
    /// How figures and complaints call it.
    pub(crate) fn name(&self) -> String {
        format!("{}, {}, {}", self.case.name(), self.placement.name(), self.who)
    }

    /// Whether it never came to what it waited for.
    pub(crate) fn never(&self) -> bool {
        self.tells_caught()
            && self.measured.gave_up > 0
            && self.measured.gave_up == self.measured.caught
    }

    /// Whether it is known if the holder was inside.
    pub(crate) fn tells_caught(&self) -> bool {
        !matches!(self.case, Case::AnyInstant | Case::WakeUp)
    }

    /// Whether there is a way to be late after quiescence.
    pub(crate) fn tells_late(&self) -> bool {
        matches!(self.case, Case::Command | Case::AnyInstant | Case::HandOver)
    }

    /// Its 99th percentile; nothing where it never came to its end, or was
    /// played too seldom to tell.
    fn figure(&self) -> Option<Figure> {
        let value = self.measured.quantile_us(0.99).filter(|_| !self.never())?;
        let target = self.target_us.map(f64::from);
        let (row, met) = (target.map(|_| TARGET_ROW), target.map(|target| value <= target));
        Some(Figure { row, name: format!("{}, p99", self.name()), value, unit: "us", target, met })
    }

    /// Where commands came after quiescence, in what part of the rounds.
    fn wrong(&self) -> Option<Figure> {
        let wrong = 100.0 * self.measured.late as f64 / (self.measured.rounds() as f64).max(1.0);
        let name = format!("{}, rounds with a command after quiescence", self.name());
        let context = Figure { row: None, name, value: wrong, unit: "%", target: None, met: None };
        (self.measured.late > 0).then_some(context)
    }

    /// What is wrong with it, whatever the host is like.
    pub(crate) fn complaint(&self) -> Option<String> {
        let what = self.control().or_else(|| self.promise()).or_else(|| self.staging())?;
        Some(format!("{}: {what}", self.name()))
    }

    /// A control must fail. One that does not shows that nothing here shows
    /// anything.
    fn control(&self) -> Option<String> {
        let Measured { caught, hog_first, late, .. } = self.measured;
        let one_cpu = self.placement.is_one_cpu();
        let what = match self.expected {
            Expected::Late if late == 0 => "no command came after its revocation",
            Expected::Spinning if one_cpu && !self.never() => {
                "a thread that spins got past one that cannot run"
            }
            Expected::PeerLendingNone if one_cpu && hog_first < caught.div_ceil(2) => {
                "a holder that is lent no priority got past the hog"
            }
            _ => return None,
        };
        Some(format!("{what}: this control must fail, so the rows show nothing"))
    }

    /// What gates and locks promise.
    fn promise(&self) -> Option<String> {
        let Measured { gave_up, hog_first, late, .. } = self.measured;
        let rounds = self.measured.rounds();
        let lends = matches!(self.expected, Expected::Ours(_) | Expected::Peer);
        if late > 0 && self.expected != Expected::Late {
            return Some(format!("{late} commands came after quiescence"));
        }
        if lends && gave_up > 0 {
            return Some(format!("who waited gave up in {gave_up} of {rounds} rounds"));
        }
        // On two CPUs a host that keeps one of them may let the hog end.
        let inverted = lends && self.placement.is_one_cpu() && hog_first > 0;
        inverted.then(|| format!("the hog went first in {hog_first} of {rounds} rounds"))
    }

    /// The holder has to be where it is said to be.
    fn staging(&self) -> Option<String> {
        let (caught, rounds) = (self.measured.caught, self.measured.rounds());
        let missed = self.tells_caught() && caught < rounds.div_ceil(2);
        missed.then(|| format!("the holder was inside in only {caught} of {rounds} rounds"))
    }
}

/// Which of the project's targets this program shows, where it has one.
const TARGET_ROW: u8 = 9;

/// One number of a row. Those without a target are context.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Figure {
    row: Option<u8>,
    name: String,
    value: f64,
    unit: &'static str,
    target: Option<f64>,
    met: Option<bool>,
}

/// All numbers, for other programs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Fragment {
    name: &'static str,
    figures: Vec<Figure>,
    /// Rows that never came to their end.
    never: Vec<String>,
    skipped: Vec<String>,
}

impl Fragment {
    pub(crate) fn of(played: &[Played], skipped: &[String]) -> Self {
        let figures = played.iter().flat_map(|row| row.figure().into_iter().chain(row.wrong()));
        let mut figures: Vec<_> = figures.collect();
        // Those with a target first.
        figures.sort_by_key(|figure| figure.target.is_none());
        let never = played.iter().filter(|row| row.never()).map(Played::name).collect();
        Self { name: "latency", figures, never, skipped: skipped.to_vec() }
    }
}

/// The sentences under the tables.
pub(crate) fn remarks(played: &[Played]) -> Vec<String> {
    if played.is_empty() {
        return Vec::new();
    }
    let service = "\"service\": with the broker's service thread above all others; without, the requester does what is due.";
    let mut remarks = vec![
        service.into(),
        format!(
            "The hog works for {} ms, or until the measurement is over. In flight nothing says that it ends.",
            HOG_WORKS.as_millis()
        ),
    ];
    remarks.extend(played.iter().filter(|row| row.measured.gave_up > 0).map(|row| {
        let (gave_up, rounds) = (row.measured.gave_up, row.measured.rounds());
        format!("{}: who waited gave up in {gave_up} of {rounds} rounds.", row.name())
    }));
    remarks.extend(played.iter().filter(|row| row.measured.late > 0).map(|row| {
        let rounds = row.measured.rounds();
        format!("{}: wrong in {} of {rounds} rounds.", row.name(), row.measured.late)
    }));
    remarks.extend(played.iter().filter(|row| row.measured.called_back > 0).map(|row| {
        let Measured { called_back, called_back_max, .. } = &row.measured;
        let (rounds, max) = (row.measured.rounds(), called_back_max.as_nanos() as f64 / 1e3);
        let name = row.name();
        format!("{name}: in {called_back} of {rounds} rounds a store was called back; they took at most {max:.1} us.")
    }));
    remarks
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::run::stage::Answer;

    fn played(expected: Expected, late: u64, caught: bool, answer: Answer) -> Played {
        let mut measured = Measured::new().expect("the bounds are in order");
        (0..100).for_each(|_| measured.add(Duration::from_micros(70), caught, answer));
        measured.late = late;
        let placement = Placement { holder_cpu: 0, revoker_cpu: 0 };
        let (case, target_us) = (Case::Command, Some(60));
        Played { case, who: "x", expected, target_us, placement, measured }
    }

    #[test]
    fn a_command_after_quiescence_is_complained_of() {
        for expected in [Expected::Ours(None), Expected::Peer] {
            assert!(played(expected, 0, true, Answer::Done).complaint().is_none());
            let complaint = played(expected, 1, true, Answer::Done).complaint();
            assert!(complaint.is_some_and(|words| words.contains("after quiescence")));
        }
    }

    #[test]
    fn a_control_that_does_not_fail_is_complained_of() {
        assert!(played(Expected::Late, 0, true, Answer::Done).complaint().is_some());
        assert!(played(Expected::Late, 9, true, Answer::Done).complaint().is_none());
        let spun = |answer| played(Expected::Spinning, 0, true, answer).complaint();
        assert!(spun(Answer::Done).is_some());
        assert!(spun(Answer::GaveUp).is_none());
    }

    #[test]
    fn a_hog_that_goes_first_is_complained_of_where_priority_is_lent() {
        let complaint = |expected, hog_first, two_cpus: bool| {
            let mut row = played(expected, 0, true, Answer::Done);
            row.measured.hog_first = hog_first;
            row.placement.revoker_cpu = usize::from(two_cpus);
            row.complaint().is_some()
        };
        assert!(complaint(Expected::Ours(None), 1, false));
        assert!(complaint(Expected::Peer, 1, false));
        assert!(!complaint(Expected::Ours(None), 1, true));
        assert!(!complaint(Expected::OursLendingNone, 100, false));
        // The control is the other way round.
        assert!(complaint(Expected::PeerLendingNone, 0, false));
        assert!(!complaint(Expected::PeerLendingNone, 100, false));
    }

    #[test]
    fn a_holder_that_was_not_caught_inside_is_complained_of() {
        assert!(played(Expected::Peer, 0, false, Answer::Done).complaint().is_some());
    }

    #[test]
    fn a_target_is_met_or_missed_and_never_a_complaint() {
        let met = |row: &Played| row.figure().and_then(|figure| figure.met);
        let row = played(Expected::Ours(Some(60)), 0, true, Answer::Done);
        assert_eq!((met(&row), row.complaint()), (Some(false), None));
        let row = Played { target_us: Some(80), ..row };
        assert_eq!(met(&row), Some(true));
        let row = Played { target_us: None, ..row };
        assert!(row.figure().is_some());
        assert_eq!(met(&row), None);
    }

    #[test]
    fn who_gave_up_has_no_time_and_is_named() {
        let row = played(Expected::Spinning, 0, true, Answer::GaveUp);
        let (name, fragment) = (row.name(), Fragment::of(&[row], &[]));
        assert_eq!((fragment.figures.len(), fragment.never), (0, vec![name]));
    }

    #[test]
    fn what_is_wrong_is_a_figure() {
        let row = played(Expected::Late, 25, true, Answer::Done);
        let wrong = row.wrong().map(|figure| (figure.value, figure.unit));
        assert_eq!(wrong, Some((25.0, "%")));
    }
}
