//! The paths of invocation and revocation, in functions that the realtime
//! sanitizer watches: it ends the program at the first call of the allocator,
//! and of any function of the C library that can block.
//!
//! `ci/rtsan.sh` runs `paths`, which must come to its end, and then each
//! control, which must not. The sanitizer sees calls of the C library, not the
//! kernel: `rustix` reads the clock and rings bells past it. The one call that it
//! sees and may be there, `membarrier`, is named in `may-be-called`.
#![feature(sanitize)]

mod bench;
mod controls;

use clap::{Parser, Subcommand};
use faregate_agents::Revoked;
use faregate_runtime::host::{HostFenced, HostRestartable, HostStrategy, Supported};
use faregate_tickets::id::Priority;

use bench::{Bench, Outcome, Switch, Ticket};

#[derive(Parser)]
#[command(about = "Runs what must be real-time safe under the realtime sanitizer")]
struct Options {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Invocation, refusal, revocation, quiescence, requests, giving back.
    Paths,
    /// A control: it allocates.
    Allocates,
    /// A control: it frees.
    Frees,
    /// A control: it waits for a lock of the standard library.
    Locks,
    /// A control: it invokes a ticket whose gate somebody else is in.
    Contended,
}

fn main() -> Outcome<()> {
    match Options::parse().what {
        What::Paths => {
            paths::<HostStrategy>("the host's lock")?;
            paths::<HostFenced>("a fence")?;
            paths::<HostRestartable>("restartable stores")?;
        }
        What::Allocates => controls::allocate(),
        What::Frees => controls::free(Box::new(1)),
        What::Locks => controls::lock(),
        What::Contended => controls::contend()?,
    }
    println!("came to its end");
    Ok(())
}

fn paths<S: Supported>(name: &str) -> Outcome<()> {
    S::check()?;
    let bench = Bench::<S>::new()?;
    for _ in 0..1_000 {
        let ticket = request(&bench)?;
        serve(&bench);
        invoke(&ticket)?;
        for way in [bar, agent_safe_mode, broker_safe_mode, all_but_me] {
            quiesce(revoke(&bench, &ticket, way)?)?;
            refuse(&ticket)?;
            restore(&bench, &ticket)?;
            invoke(&ticket)?;
        }
        let emergency = preempt(&bench)?;
        refuse(&ticket)?;
        relinquish(emergency);
        serve(&bench);
        invoke(&ticket)?;
        relinquish(ticket);
        serve(&bench);
    }
    println!("behind {name}: nothing that allocates or can block was called");
    Ok(())
}

#[sanitize(realtime = "nonblocking")]
fn request<S: Supported>(bench: &Bench<S>) -> Outcome<Ticket<S>> {
    Ok(bench.broker.request(Priority::SCIENCE, &bench.lamp)?)
}

#[sanitize(realtime = "nonblocking")]
fn serve<S: Supported>(bench: &Bench<S>) {
    bench.broker.service();
}

/// By the lock, and then as a store where the strategy has such a way.
#[sanitize(realtime = "nonblocking")]
fn invoke<S: Supported>(ticket: &Ticket<S>) -> Outcome<()> {
    ticket.invoke(Switch::On)?;
    for level in 0..8 {
        ticket.invoke(Switch::Dim(level))?;
    }
    ticket.try_invoke(Switch::Off)?;
    ticket.renew()?;
    Ok(ticket.check()?)
}

#[sanitize(realtime = "nonblocking")]
fn refuse<S: Supported>(ticket: &Ticket<S>) -> Outcome<()> {
    let answers = [
        ticket.invoke(Switch::On).is_err(),
        ticket.try_invoke(Switch::Dim(1)).is_err(),
        ticket.renew().is_err(),
        ticket.check().is_err(),
    ];
    if answers == [true; 4] { Ok(()) } else { Err("a revoked ticket was admitted".into()) }
}

type Way<S> = fn(&Bench<S>, &Ticket<S>) -> Outcome<Revoked<'static>>;

#[sanitize(realtime = "nonblocking")]
fn revoke<S: Supported>(
    bench: &Bench<S>,
    ticket: &Ticket<S>,
    way: Way<S>,
) -> Outcome<Revoked<'static>> {
    way(bench, ticket)
}

fn bar<S: Supported>(bench: &Bench<S>, ticket: &Ticket<S>) -> Outcome<Revoked<'static>> {
    Ok(bench.broker.bar(&bench.supervisor, ticket.id())?)
}

fn agent_safe_mode<S: Supported>(bench: &Bench<S>, _: &Ticket<S>) -> Outcome<Revoked<'static>> {
    Ok(bench.broker.enter_safe_mode(&bench.of_agent, Priority::EMERGENCY)?)
}

fn broker_safe_mode<S: Supported>(bench: &Bench<S>, _: &Ticket<S>) -> Outcome<Revoked<'static>> {
    Ok(bench.broker.enter_safe_mode(&bench.supervisor, Priority::EMERGENCY)?)
}

fn all_but_me<S: Supported>(bench: &Bench<S>, _: &Ticket<S>) -> Outcome<Revoked<'static>> {
    let floor = Priority::EMERGENCY;
    let (exempt, revoked) = bench.broker.revoke_all_but_me(&bench.supervisor, &bench.own, floor)?;
    if exempt { Ok(revoked) } else { Err("the revoker's own ticket was revoked too".into()) }
}

#[sanitize(realtime = "nonblocking")]
fn quiesce(revoked: Revoked<'static>) -> Outcome<()> {
    revoked.quiesce().map(|_| ()).map_err(Into::into)
}

#[sanitize(realtime = "nonblocking")]
fn restore<S: Supported>(bench: &Bench<S>, ticket: &Ticket<S>) -> Outcome<()> {
    bench.broker.leave_safe_mode(&bench.of_agent)?;
    bench.broker.leave_safe_mode(&bench.supervisor)?;
    bench.broker.reinstate(&bench.supervisor, ticket.id())?;
    bench.broker.service();
    Ok(())
}

#[sanitize(realtime = "nonblocking")]
fn preempt<S: Supported>(bench: &Bench<S>) -> Outcome<Ticket<S>> {
    let emergency = bench.broker.request(Priority::EMERGENCY, &bench.lamp)?;
    bench.broker.service();
    emergency.invoke(Switch::Off)?;
    Ok(emergency)
}

#[sanitize(realtime = "nonblocking")]
fn relinquish<S: Supported>(ticket: Ticket<S>) {
    ticket.relinquish();
}
