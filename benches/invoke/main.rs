//! What an invocation costs: a ticket of each strategy, and of each way to be
//! refused, beside what else could guard the same call. Rows 1 to 6.

#[path = "../support/mod.rs"]
mod support;

mod functions;
mod peers;
mod refusals;
mod register;
mod subjects;

use std::hint::black_box;
use std::process::ExitCode;

use faregate::prelude::*;
use faregate::runtime::host::{Host, HostFenced, HostStrategy};
use faregate::runtime::lanes::{Recorder, RingLane};
use faregate::tickets::Platform;
use faregate::tickets::lock::{Locked, Strategy};

use peers::{VALUE, repeat};
use register::ONE_STORE;
use subjects::{Clocked, Free, Pass, Stand};
use support::{Bench, Contest, Entrant, Failure, Target};

type ParkingLot = Locked<parking_lot::RawMutex, parking_lot::RawThreadId>;

fn main() -> ExitCode {
    support::run("invoke", |bench| {
        invocations(bench)?;
        functions::measure(bench)
    })
}

fn invocations(bench: &mut Bench) -> Result<(), Failure> {
    let mut contest = bench.contest("invocation");
    let peers = peers::enter(&mut contest);
    let host = invoke::<HostStrategy, 0>(&mut contest, "PiLocked")?;
    let plain = invoke::<ParkingLot, 0>(&mut contest, "Locked<parking_lot>")?;
    let fenced = invoke::<HostFenced, 0>(&mut contest, "Fenced")?;
    let restartable = one_store(&mut contest)?;
    let look = look_alone(&mut contest)?;
    with_the_hosts_clock(&mut contest)?;
    with_the_flight_recorder(&mut contest)?;
    let refusals = refusals::enter(&mut contest)?;

    let times = contest.run();
    let at_most = Target::AtMost;
    let name = "Fenced invoke / acquire flag + call";
    bench.ratio(1, name, &times, (fenced, peers.flag), at_most(1.6));
    let name = "the bare one-fence protocol / acquire flag + call";
    bench.ratio(1, name, &times, (peers.one_fence, peers.flag), Target::None);
    let name = "Fenced invoke / the bare one-fence protocol";
    bench.ratio(2, name, &times, (fenced, peers.one_fence), at_most(1.10));
    let added = |ticket, bare| times.of(ticket).p5 - times.of(bare).p5;
    let name = "what a ticket adds to the bare one-fence protocol";
    bench.figure(2, name, added(fenced, peers.one_fence), "ns", Target::None);
    let name = "what a ticket adds to the bare lock";
    bench.figure(3, name, added(host, peers.host_lock), "ns", Target::None);
    if let Some(restartable) = restartable {
        let name = "Restartable invoke / bare store";
        bench.ratio(4, name, &times, (restartable, peers.bare_store), at_most(1.6));
        let name = "Restartable invoke / acquire flag + call";
        bench.ratio(4, name, &times, (restartable, peers.flag), Target::None);
    }
    let bare = "the bare lock around the same call";
    bench.ratio(
        3,
        &format!("PiLocked invoke / {bare}"),
        &times,
        (host, peers.host_lock),
        at_most(1.10),
    );
    let name = format!("Locked<parking_lot> invoke / {bare}");
    bench.ratio(3, &name, &times, (plain, peers.parking_lot), Target::None);
    let name = "the look alone / acquire flag + call";
    bench.ratio(5, name, &times, (look, peers.flag), Target::None);
    for (name, refusal) in refusals {
        let name = format!("refused, {name} / acquire flag + call");
        bench.ratio(5, &name, &times, (refusal, peers.flag), at_most(0.5));
    }
    bench.peers(&times);
    Ok(())
}

/// A gate behind this strategy, with a free clock and no recorder.
fn invoke<S: Strategy, const SITE: u8>(
    contest: &mut Contest<'_>,
    name: &str,
) -> Result<Entrant, Failure> {
    let ticket = Stand::<Free<S>, SITE>::free()?.ticket(Validity::always())?;
    Ok(admitted(contest, &format!("{name} invoke"), ticket))
}

/// Whether a ticket is valid, and nothing else: an admitted command asks it
/// twice, a refused one once.
fn look_alone(contest: &mut Contest<'_>) -> Result<Entrant, Failure> {
    let ticket = Stand::<Free<HostStrategy>, 4>::free()?.ticket(Validity::always())?;
    Ok(repeat(contest, "the look alone", move |_| ticket.check().is_ok()))
}

/// A gate that does the command's one store itself; none where the system has
/// no restartable sequences.
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
fn one_store(contest: &mut Contest<'_>) -> Result<Option<Entrant>, Failure> {
    use faregate::runtime::host::{HostRestartable, Supported};
    if let Err(missing) = HostRestartable::check() {
        eprintln!("Restartable is not measured: {missing}");
        return Ok(None);
    }
    invoke::<HostRestartable, ONE_STORE>(contest, "Restartable").map(Some)
}

#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
fn one_store(_: &mut Contest<'_>) -> Result<Option<Entrant>, Failure> {
    eprintln!("Restartable is not measured: it is for Linux on x86-64 and aarch64");
    Ok(None)
}

fn admitted<P: Platform, const SITE: u8>(
    contest: &mut Contest<'_>,
    name: &str,
    ticket: Pass<P, SITE>,
) -> Entrant {
    contest.enter(name, move |n| {
        let value = black_box(VALUE);
        for _ in 0..n {
            black_box(ticket.invoke(value).is_ok());
        }
        // A refusal costs less: what was refused in between would look fast.
        assert_eq!(ticket.check(), Ok(()), "refused while it was measured");
    })
}

fn with_the_hosts_clock(contest: &mut Contest<'_>) -> Result<Entrant, Failure> {
    use faregate::runtime::clock::MonotonicClock;
    use faregate::tickets::recorder::NoLane;
    let clock = MonotonicClock::new();
    let stand = Stand::<Clocked<HostStrategy>, 0>::new(clock, clock, NoLane, NoLane)?;
    let name = "PiLocked invoke, the host's clock";
    Ok(admitted(contest, name, stand.ticket(Validity::always())?))
}

/// What a program gets from `faregate-runtime`. The lane is drained between
/// samples: a full one only counts what it loses, which is cheaper.
fn with_the_flight_recorder(contest: &mut Contest<'_>) -> Result<Entrant, Failure> {
    use faregate::runtime::clock::MonotonicClock;
    const CAPACITY: usize = 1 << 14;
    let clock = MonotonicClock::new();
    let mut recorder = Recorder::new();
    let mut lane = |name: &str| -> RingLane { recorder.lane(name, CAPACITY) };
    let stand = Stand::<Host, 0>::new(clock, clock, lane("broker"), lane("register"))?;
    let ticket = stand.ticket(Validity::always())?;
    let name = "PiLocked invoke, the host's clock and recorder";
    Ok(contest.enter_timed(name, move |n| {
        recorder.drain();
        let start = std::time::Instant::now();
        let value = black_box(VALUE);
        for _ in 0..n {
            black_box(ticket.invoke(value).is_ok());
        }
        let took = start.elapsed();
        assert_eq!(ticket.check(), Ok(()), "refused while it was measured");
        took
    }))
}
