//! What each validity function adds to an invocation.

use faregate::prelude::*;
use faregate::runtime::host::HostStrategy;

use crate::peers;
use crate::subjects::{Free, Stand};
use crate::support::{Bench, Contest, Entrant, Failure, Target};

type OnHost = Stand<Free<HostStrategy>, 2>;

const LONG: Duration = Duration::from_secs(3_600);

/// Each function of the library, with limits that no run comes to.
fn library() -> Result<Vec<(&'static str, Function)>, Failure> {
    Ok(vec![
        ("window", Function::window(Instant::START, Instant::FAR_FUTURE)),
        ("time_limit", Function::time_limit(LONG)),
        ("lease", Function::lease(LONG)),
        ("invocations", Function::invocations(u32::MAX)),
        ("rate", Function::rate(u32::MAX, Duration::ZERO)),
        ("separation", Function::separation(Duration::ZERO)),
        ("duty_cycle", Function::duty_cycle(LONG, LONG.saturating_mul(2))?),
        ("energy", Function::energy(Microjoules::from_joules(1_000))),
        ("propellant", Function::propellant(Milligrams::new(1_000))),
        ("interlock", Function::interlock()),
    ])
}

/// A contest of its own, with the flag and the ticket without functions in it:
/// differences, too, are taken within the same rounds.
pub(crate) fn measure(bench: &mut Bench) -> Result<(), Failure> {
    let mut contest = bench.contest("validity functions");
    let flag = peers::acquire_flag(&mut contest);
    let none = with(&mut contest, "none", Validity::always())?;
    let mut entrants = Vec::new();
    for (name, function) in library()? {
        entrants.push((name, with(&mut contest, name, function.into())?));
    }
    let four = [
        Function::window(Instant::START, Instant::FAR_FUTURE),
        Function::lease(LONG),
        Function::invocations(u32::MAX),
        Function::separation(Duration::ZERO),
    ];
    let four =
        with(&mut contest, "window, lease, invocations, separation", Validity::all_of(&four)?)?;

    let times = contest.run();
    let (flag, none) = (times.of(flag).p5, times.of(none).p5);
    // Half a nanosecond, or 0.4 times the flag and the call, whichever is more.
    let limit = (0.4 * flag).max(0.5);
    for (name, entrant) in entrants {
        let added = (times.of(entrant).p5 - none).max(0.0);
        bench.figure(
            6,
            &format!("validity function {name}, added"),
            added,
            "ns",
            Target::AtMost(limit),
        );
    }
    let added = times.of(four).p5 - none;
    bench.figure(6, "four validity functions, added", added, "ns", Target::None);
    bench.peers(&times);
    Ok(())
}

fn with(contest: &mut Contest<'_>, name: &str, validity: Validity) -> Result<Entrant, Failure> {
    let ticket = OnHost::free()?.ticket(validity)?;
    ticket.invoke(peers::VALUE).map_err(|refused| format!("{name}: {refused}"))?;
    Ok(crate::admitted(contest, &format!("invoke with {name}"), ticket))
}
