//! Why a new plan was made, in words.

use faregate_planner::trace::Why;
use faregate_planner::words::Words;

/// In a few words, with names.
pub(crate) fn why(words: &Words<'_>, why: Why) -> String {
    let name = |id| words.activity(id);
    match why {
        Why::First => "for the first time".to_owned(),
        Why::Periodic => "it is time".to_owned(),
        Why::EndedEarly(id) => format!("{} ended early", name(id)),
        Why::Outcome(id) => format!("{} did not succeed", name(id)),
        Why::Overran(id) => format!("{} takes longer", name(id)),
        Why::StartedEarly(id) => format!("{} started early", name(id)),
        Why::Late(id) => format!("{} is late", name(id)),
        Why::NotStarted(id) => format!("{} will not start", name(id)),
        Why::ZoneCold => "a zone is not warm".to_owned(),
        Why::Windows => "the windows changed".to_owned(),
        Why::Tickets(id) => format!("tickets of {}", name(id)),
        Why::HandOver => "handed over".to_owned(),
    }
}
