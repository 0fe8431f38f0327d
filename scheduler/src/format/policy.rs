//! Words for policies: pre-emption, its signal, and what suits which body.

use faregate_tickets::clock::Duration;

use crate::format::diagnostic::Rule;
use crate::format::scalar;
use crate::format::wrong::{Wrong, shown};
use crate::manager::limits::GRACE;
use crate::task::{Body, CheckpointSignal, Preemption, Task};

/// The signals that can tell a process to save its work, by name.
pub(crate) const SIGNALS: [(&str, CheckpointSignal); 5] = [
    ("SIGUSR1", CheckpointSignal::User1),
    ("SIGUSR2", CheckpointSignal::User2),
    ("SIGTERM", CheckpointSignal::Terminate),
    ("SIGHUP", CheckpointSignal::HangUp),
    ("SIGINT", CheckpointSignal::Interrupt),
];

/// The words for pre-emption.
pub(crate) const WAYS: [&str; 4] = ["wait", "pause", "checkpoint", "kill"];

/// How a body is pre-empted where nothing is stated.
pub(crate) fn usual(body: &Body) -> Preemption {
    let any = const { crate::task::TaskId::new(1).unwrap() };
    Task::new(any, body.clone()).preemption
}

/// `wait`, `pause`, `checkpoint[:grace[:signal]]` or `kill[:grace]`, as a
/// column has it.
pub(crate) fn pre_emption(text: &str) -> Result<Preemption, Wrong> {
    let mut parts = text.split(':');
    let way = parts.next().unwrap_or_default();
    let grace = parts.next().map(scalar::seconds).transpose()?;
    let signal = parts.next().map(signal).transpose()?;
    if parts.next().is_some() {
        return Err(unknown(text));
    }
    combine(way, grace, signal)
}

/// The parts as one policy.
pub(crate) fn combine(
    way: &str,
    grace: Option<Duration>,
    signal: Option<CheckpointSignal>,
) -> Result<Preemption, Wrong> {
    let time = grace.unwrap_or(GRACE);
    match (way, grace, signal) {
        ("checkpoint", _, signal) => {
            Ok(Preemption::Checkpoint { grace: time, signal: signal.unwrap_or_default() })
        }
        ("kill", _, None) => Ok(Preemption::Kill { grace: time }),
        ("wait", None, None) => Ok(Preemption::Wait),
        ("pause", None, None) => Ok(Preemption::Pause),
        ("kill" | "wait" | "pause", ..) => {
            let what = if signal.is_some() { "a signal" } else { "a grace" };
            Err(Wrong::new(Rule::Preemption, format!("{way} has no use for {what}")))
        }
        _ => Err(unknown(way)),
    }
}

pub(crate) fn signal(name: &str) -> Result<CheckpointSignal, Wrong> {
    let found = SIGNALS.iter().find(|(known, _)| *known == name);
    found.map(|(_, signal)| *signal).ok_or_else(|| {
        Wrong::new(Rule::Unknown, format!("{} is no signal for this", shown(name)))
            .expected(SIGNALS.map(|(name, _)| name).join(", "))
    })
}

fn unknown(text: &str) -> Wrong {
    Wrong::new(Rule::Unknown, format!("{} is no way to pre-empt a task", shown(text)))
        .expected("wait, pause, checkpoint or kill")
        .help("with a grace in seconds: checkpoint:10, kill:2.5; with a signal: checkpoint:10:SIGUSR2")
}

/// The policy as a column has it.
pub(crate) fn column(preemption: Preemption, seconds: impl Fn(Duration) -> String) -> String {
    match preemption {
        Preemption::Wait => "wait".to_owned(),
        Preemption::Pause => "pause".to_owned(),
        Preemption::Kill { grace } => format!("kill:{}", seconds(grace)),
        Preemption::Checkpoint { grace, signal } if signal == CheckpointSignal::default() => {
            format!("checkpoint:{}", seconds(grace))
        }
        Preemption::Checkpoint { grace, signal } => {
            format!("checkpoint:{}:{}", seconds(grace), name(signal))
        }
    }
}

/// The name of a signal.
pub(crate) fn name(signal: CheckpointSignal) -> &'static str {
    SIGNALS.iter().find(|(_, known)| *known == signal).map_or("SIGUSR1", |(name, _)| name)
}

/// Whether a body can be pre-empted so.
pub(crate) fn suits(body: &Body, preemption: Preemption) -> Result<(), Wrong> {
    let (what, ways) = match body {
        Body::Function { .. } => ("a function", "wait or checkpoint"),
        Body::BuiltIn(_) => ("a function of the manager", "wait"),
        Body::Process { .. } | Body::Sequence(_) | Body::Hold => return Ok(()),
    };
    let good = match preemption {
        Preemption::Wait => true,
        Preemption::Checkpoint { .. } => matches!(body, Body::Function { .. }),
        Preemption::Pause | Preemption::Kill { .. } => false,
    };
    if good {
        return Ok(());
    }
    let message = format!("{what} cannot be stopped from outside");
    Err(Wrong::new(Rule::Preemption, message).expected(ways))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_holds_a_grace_and_a_signal() {
        let kill = Preemption::Kill { grace: Duration::from_millis(2_500) };
        assert_eq!(pre_emption("kill:2.5"), Ok(kill));
        assert_eq!(pre_emption("kill"), Ok(Preemption::Kill { grace: GRACE }));
        let told = Preemption::Checkpoint {
            grace: Duration::from_secs(10),
            signal: CheckpointSignal::User2,
        };
        assert_eq!(pre_emption("checkpoint:10:SIGUSR2"), Ok(told));
        for bad in ["", "stop", "pause:3", "kill:2:SIGUSR1", "checkpoint:1:SIGUSR1:2", "kill:x"] {
            assert!(pre_emption(bad).is_err(), "{bad}");
        }
    }
}
