//! What every gate strategy keeps, and what the priority-inheriting one keeps
//! beyond that: boosts, deaths, deadlocks.
#![expect(clippy::unwrap_used, reason = "what a test needs and does not get fails the test")]

#[path = "locks/sys.rs"]
mod sys;

use std::hint::black_box;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Instant;
use std::{env, fs, thread};

use faregate_tickets::clock::Duration;
use faregate_tickets::id::{GateId, TicketId};
use faregate_tickets::lock::{
    Exclusion, Fenced, Locked, Masked, Next, Owner, PiLocked, Shut, Strategy, Wait, Way,
};
use faregate_tickets::scope::Scope;
use faregate_tickets::standing::Standing;
use faregate_tickets::ticket::Seat;

type Pi = <PiLocked<sys::Kernel> as Strategy>::Lock<u64>;
type ParkingLot = <Locked<parking_lot::RawMutex, parking_lot::RawThreadId> as Strategy>::Lock<u64>;
type Fence = <Fenced<PiLocked<sys::Kernel>, Never> as Strategy>::Lock<u64>;
type Mask = <Masked as Strategy>::Lock<u64>;

/// Here everybody comes by the lock, so nobody is in flight beside it.
enum Never {}

impl Wait for Never {
    fn until(_: Duration, _: impl FnMut() -> bool) -> bool {
        unreachable!("no ticket has a short way")
    }
}

/// Makes a test of each claim about each lock.
macro_rules! claims {
    ($($strategy:ident: $lock:ty { $($claim:ident)* })*) => {$(
        mod $strategy {
            $(#[test] fn $claim() { super::$claim::<$lock>(); })*
        }
    )*};
}

claims! {
    pi_locked: super::Pi {
        one_thread_at_a_time_is_inside
        a_lock_entered_again_by_its_own_thread_refuses
        a_closure_that_unwinds_leaves_the_lock_usable
        trying_a_busy_lock_says_so
        a_wait_ends_at_its_timeout
        a_wait_ends_when_the_lock_is_left
    }
    locked: super::ParkingLot {
        one_thread_at_a_time_is_inside
        a_lock_entered_again_by_its_own_thread_refuses
        a_closure_that_unwinds_leaves_the_lock_usable
        trying_a_busy_lock_says_so
        a_wait_ends_at_its_timeout
        a_wait_ends_when_the_lock_is_left
    }
    fenced: super::Fence {
        one_thread_at_a_time_is_inside
        a_lock_entered_again_by_its_own_thread_refuses
        a_closure_that_unwinds_leaves_the_lock_usable
        trying_a_busy_lock_says_so
        a_wait_ends_at_its_timeout
        a_wait_ends_when_the_lock_is_left
    }
    masked: super::Mask {
        one_thread_at_a_time_is_inside
        a_lock_entered_again_by_its_own_thread_refuses
        a_closure_that_unwinds_leaves_the_lock_usable
        a_wait_ends_when_the_lock_is_left
    }
}

/// Longer than anything here takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

/// A lock that several threads can use.
trait Lock: Exclusion<u64> + Send + Sync + 'static {}
impl<L: Exclusion<u64> + Send + Sync + 'static> Lock for L {}

fn one_thread_at_a_time_is_inside<L: Lock>() {
    const ENTRIES: u64 = 5_000;
    let lock = L::new(0);
    // A read and a write, apart: two threads inside together lose a count.
    let count = |value: &mut u64| {
        let read = black_box(*value);
        thread::yield_now();
        *value = black_box(read + 1);
    };
    thread::scope(|threads| {
        for _ in 0..2 {
            threads.spawn(|| (0..ENTRIES).for_each(|_| lock.with(count).unwrap()));
            threads.spawn(|| {
                for _ in 0..ENTRIES {
                    lock.with_until(PATIENCE, |value, _| count(value)).unwrap();
                    while lock.try_with(count) == Err(Shut::Busy) {
                        thread::yield_now();
                    }
                }
            });
        }
    });
    assert_eq!(lock.with(|value| *value), Ok(2 * ENTRIES + 2 * 2 * ENTRIES));
}

fn a_lock_entered_again_by_its_own_thread_refuses<L: Lock>() {
    let lock = L::new(0);
    let again = || {
        assert_eq!(lock.with(|_| ()), Err(Shut::Reentered));
        assert_eq!(lock.try_with(|_| ()), Err(Shut::Reentered));
        assert_eq!(lock.with_until(PATIENCE, |_, _| ()), Err(Shut::Reentered));
    };
    assert_eq!(lock.with(|_| again()), Ok(()));
    assert_eq!(lock.try_with(|_| again()), Ok(()));
    assert_eq!(lock.with_until(PATIENCE, |_, _| again()), Ok(()));
    assert_eq!(lock.with(|_| ()), Ok(()), "and is left afterwards");
}

fn a_closure_that_unwinds_leaves_the_lock_usable<L: Lock>() {
    let lock = L::new(7);
    let unwind = || resume_unwind(Box::new("gone"));
    assert!(catch_unwind(AssertUnwindSafe(|| lock.with(|_| unwind()))).is_err());
    assert!(catch_unwind(AssertUnwindSafe(|| lock.try_with(|_| unwind()))).is_err());
    assert!(catch_unwind(AssertUnwindSafe(|| lock.with_until(PATIENCE, |_, _| unwind()))).is_err());
    assert_eq!(lock.try_with(|value| *value), Ok(7), "for this thread");
    let other = thread::spawn(move || lock.with_until(PATIENCE, |value, owner| (*value, owner)));
    assert_eq!(other.join().unwrap(), Ok((7, Owner::Sound)), "and for another");
}

fn trying_a_busy_lock_says_so<L: Lock>() {
    let lock = L::new(0);
    while_another_is_inside(&lock, || assert_eq!(lock.try_with(|_| ()), Err(Shut::Busy)));
    assert_eq!(lock.try_with(|_| ()), Ok(()));
}

fn a_wait_ends_at_its_timeout<L: Lock>() {
    let lock = L::new(0);
    while_another_is_inside(&lock, || {
        for timeout in [Duration::ZERO, Duration::from_millis(30), Duration::from_micros(1_000_001)]
        {
            let start = Instant::now();
            assert_eq!(lock.with_until(timeout, |_, _| ()), Err(Shut::TimedOut));
            assert!(Duration::from(start.elapsed()) >= timeout, "not after {timeout}");
        }
    });
    assert_eq!(lock.with_until(Duration::ZERO, |_, owner| owner), Ok(Owner::Sound));
}

fn a_wait_ends_when_the_lock_is_left<L: Lock>() {
    let lock = L::new(0);
    thread::scope(|threads| {
        let waiters = while_another_is_inside(&lock, || {
            let (forever, until) = mpsc::channel();
            let waiters = [
                threads.spawn({
                    let forever = forever.clone();
                    let lock = &lock;
                    move || {
                        forever.send(sys::tid()).unwrap();
                        lock.with(|_| Owner::Sound)
                    }
                }),
                threads.spawn(|| {
                    let forever = forever;
                    forever.send(sys::tid()).unwrap();
                    lock.with_until(Duration::MAX, |_, owner| owner)
                }),
            ];
            until.iter().take(2).for_each(wait_until_blocked);
            waiters
        });
        for waiter in waiters {
            assert_eq!(waiter.join().unwrap(), Ok(Owner::Sound));
        }
    });
}

#[test]
fn an_uncontended_section_asks_the_kernel_nothing() {
    without(sys::PI_OPERATIONS, libc::EPERM, || {
        let lock = Pi::new(0);
        assert_eq!(lock.with(|_| lock.with(|_| ())), Ok(Err(Shut::Reentered)));
        assert_eq!(lock.try_with(|_| ()), Ok(()));
        assert_eq!(lock.with_until(PATIENCE, |_, owner| owner), Ok(Owner::Sound));
    });
}

#[test]
fn trying_a_busy_lock_asks_the_kernel_nothing() {
    let lock: &'static Pi = Box::leak(Box::new(Pi::new(0)));
    while_another_is_inside(lock, || {
        without(sys::PI_OPERATIONS, libc::EPERM, || {
            assert_eq!(lock.try_with(|_| ()), Err(Shut::Busy))
        });
    });
}

#[test]
fn before_linux_5_14_a_wait_ends_at_its_timeout_too() {
    let lock: &'static Pi = Box::leak(Box::new(Pi::new(0)));
    while_another_is_inside(lock, || {
        without(&[libc::FUTEX_LOCK_PI2], libc::ENOSYS, || {
            let start = Instant::now();
            assert_eq!(lock.with_until(Duration::from_millis(50), |_, _| ()), Err(Shut::TimedOut));
            let waited = Duration::from(start.elapsed());
            // The wall clock may be slewed against the monotonic one.
            assert!(waited >= Duration::from_millis(45), "only {waited}");
        });
    });
}

#[test]
fn a_kernel_without_such_a_futex_is_known_at_start_up() {
    assert!(PiLocked::<sys::Kernel>::is_supported());
    without(sys::PI_OPERATIONS, libc::ENOSYS, || assert!(!PiLocked::<sys::Kernel>::is_supported()));
}

#[test]
fn a_death_inside_that_nobody_awaits_is_told_to_each_later_caller() {
    let lock: &'static Pi = Box::leak(Box::new(Pi::new(7)));
    let (dying, die) = doomed(lock);
    drop(die);
    wait_until_gone(dying);
    assert_eq!(lock.try_with(|_| ()), Err(Shut::Busy), "noticed by who waits");
    assert_is_shut_by_death(lock);
}

#[test]
fn a_death_inside_is_told_to_a_wait_without_any_time() {
    let lock: &'static Pi = Box::leak(Box::new(Pi::new(7)));
    let (dying, die) = doomed(lock);
    drop(die);
    wait_until_gone(dying);
    assert_eq!(lock.with_until(Duration::ZERO, |_, owner| owner), Ok(Owner::Died));
    assert_is_shut_by_death(lock);
}

#[test]
fn a_death_inside_is_told_to_all_who_were_waiting() {
    let lock: &'static Pi = Box::leak(Box::new(Pi::new(7)));
    let (_, die) = doomed(lock);
    let (agent, agent_tid) =
        spawn(move || lock.with_until(PATIENCE, |value, owner| (*value, owner)));
    let (holder, holder_tid) = spawn(move || lock.with(|_| ()));
    wait_until_blocked(agent_tid);
    wait_until_blocked(holder_tid);
    drop(die);
    assert_eq!(agent.join().unwrap(), Ok((7, Owner::Died)));
    assert_eq!(holder.join().unwrap(), Err(Shut::OwnerDied));
    assert_is_shut_by_death(lock);
}

/// Waits no time at all; a thread that would wait for long dies of it.
enum Mortal {}

impl Wait for Mortal {
    fn until(timeout: Duration, _: impl FnMut() -> bool) -> bool {
        if timeout == PATIENCE { sys::die() } else { false }
    }
}

#[test]
fn a_death_while_waiting_for_a_short_way_lets_nobody_in() {
    type Lock = <Fenced<PiLocked<sys::Kernel>, Mortal> as Strategy>::Lock<u64>;
    let lock: &'static Lock = Box::leak(Box::new(Exclusion::new(7)));
    let (standing, scope) =
        (Box::leak(Box::new(Standing::new())), Box::leak(Box::new(Scope::new())));
    let id = TicketId { seat: 0, serial: 1 };
    let seat = Seat { id, gate: GateId(0), standing, agent: scope, broker: scope };
    let way = lock.way(&seat, PATIENCE);
    let first = way.with(|| Ok::<(), ()>(()), |_: &mut u64, ()| ((), Next::Enter));
    assert_eq!(first, Ok(Ok(())));
    let inside = |_: &mut u64, ()| {
        let (_, dying) = spawn(|| lock.with_until(PATIENCE, |_, _| ()));
        wait_until_gone(dying);
        let entered = lock.with_until(Duration::ZERO, |_, owner| owner);
        assert_eq!(entered, Err(Shut::TimedOut), "entered while somebody was inside");
        ((), Next::Enter)
    };
    assert_eq!(way.with(|| Ok::<(), ()>(()), inside), Ok(Ok(())));
    let after = lock.with_until(Duration::ZERO, |value, owner| (*value, owner));
    assert_eq!(after, Ok((7, Owner::Died)), "the command is over");
}

#[test]
fn a_death_inside_is_told_while_its_heir_has_not_run_yet() {
    if !real_time_is_permitted() {
        return;
    }
    // The dying thread and this one stay off the CPU that is hogged below.
    sys::run_on_cpu(1);
    let lock: &'static Pi = Box::leak(Box::new(Pi::new(7)));
    let (dying, die) = doomed(lock);
    let (heir, heir_tid) = spawn(move || {
        sys::run_on_cpu(0);
        sys::run_at_fifo(LOW).unwrap();
        lock.with(|_| ())
    });
    wait_until_blocked(heir_tid);
    // With its CPU taken, the heir is chosen but cannot say so in the word.
    let late = while_cpu_0_is_hogged(move || {
        drop(die);
        wait_until_gone(dying);
        lock.with_until(Duration::from_millis(30), |_, owner| owner)
    });
    assert_eq!(heir.join().unwrap(), Err(Shut::OwnerDied));
    assert_eq!(late, Err(Shut::TimedOut), "the heir goes first");
    assert_is_shut_by_death(lock);
}

/// Runs `f` while nothing below `HIGH` runs on the first CPU.
fn while_cpu_0_is_hogged<R>(f: impl FnOnce() -> R) -> R {
    let (hogged, stop) = (AtomicBool::new(false), AtomicBool::new(false));
    thread::scope(|threads| {
        threads.spawn(|| {
            sys::run_on_cpu(0);
            sys::run_at_fifo(HIGH).unwrap();
            hogged.store(true, Ordering::Relaxed);
            let start = Instant::now();
            while !stop.load(Ordering::Relaxed) {
                assert!(Duration::from(start.elapsed()) < PATIENCE, "the hog was forgotten");
            }
        });
        poll(|| hogged.load(Ordering::Relaxed), "never hogged the CPU");
        let out = f();
        stop.store(true, Ordering::Relaxed);
        out
    })
}

#[test]
fn two_threads_that_would_wait_for_each_other_are_told() {
    let [first, second] = [(); 2].map(|()| &*Box::leak(Box::new(Pi::new(0))));
    let crossed = second.with(|_| {
        let (other, other_tid) = spawn(|| first.with(|_| second.with(|_| ())));
        wait_until_blocked(other_tid);
        (first.with(|_| ()), other)
    });
    let (crossed, other) = crossed.unwrap();
    assert_eq!(crossed, Err(Shut::Reentered));
    assert_eq!(other.join().unwrap(), Ok(Ok(())));
}

#[test]
fn who_is_inside_runs_at_the_priority_of_who_waits() {
    if !real_time_is_permitted() {
        return;
    }
    assert_eq!(priorities_of_a_holder::<Pi>(), [LOW, HIGH, LOW]);
}

/// The control: the harness above can see that there is no boost.
#[test]
fn parking_lot_lends_no_priority() {
    if !real_time_is_permitted() {
        return;
    }
    assert_eq!(priorities_of_a_holder::<ParkingLot>(), [LOW; 3]);
}

const LOW: i32 = 10;
const HIGH: i32 = 30;

/// The effective priority of a thread of low priority: inside, inside while one
/// of high priority waits, and outside again. All on one CPU.
fn priorities_of_a_holder<L: Lock>() -> [i32; 3] {
    let lock: &'static L = Box::leak(Box::new(L::new(0)));
    let (entered, when_entered) = mpsc::channel();
    let (leave, when_to_leave) = mpsc::channel::<()>();
    let (left, when_left) = mpsc::channel();
    let (end, when_to_end) = mpsc::channel::<()>();
    let (holder, holder_tid) = spawn(move || {
        sys::run_on_cpu(0);
        sys::run_at_fifo(LOW).unwrap();
        lock.with(|_| {
            entered.send(()).unwrap();
            when_to_leave.recv().unwrap_err();
        })
        .unwrap();
        left.send(()).unwrap();
        when_to_end.recv().unwrap_err();
    });
    when_entered.recv().unwrap();
    let before = effective_priority(holder_tid);
    let (waiter, waiter_tid) = spawn(move || {
        sys::run_on_cpu(0);
        sys::run_at_fifo(HIGH).unwrap();
        lock.with_until(PATIENCE, |_, _| ())
    });
    wait_until_blocked(waiter_tid);
    let while_waited_for = effective_priority(holder_tid);
    drop(leave);
    when_left.recv().unwrap();
    let after = effective_priority(holder_tid);
    drop(end);
    holder.join().unwrap();
    assert_eq!(waiter.join().unwrap(), Ok(()));
    [before, while_waited_for, after]
}

/// Field 18 of a thread's `stat` is its effective priority; a real-time
/// priority p reads -1 - p there.
fn effective_priority(tid: u32) -> i32 {
    let stat = fs::read_to_string(format!("/proc/self/task/{tid}/stat")).unwrap();
    let after_name = stat.rsplit_once(") ").unwrap().1;
    let field: i32 = after_name.split(' ').nth(18 - 3).unwrap().parse().unwrap();
    -1 - field
}

/// Whether threads may have real-time priorities here, and two CPUs. On the
/// build server a test is not skipped for want of them: it fails.
fn real_time_is_permitted() -> bool {
    let missing = match thread::spawn(|| sys::run_at_fifo(1)).join().unwrap() {
        Err(error) => format!("SCHED_FIFO is not permitted: {error}"),
        Ok(()) if thread::available_parallelism().unwrap().get() < 2 => {
            "there is one CPU only".into()
        }
        Ok(()) => return true,
    };
    assert!(env::var_os("CI").is_none(), "{missing}");
    eprintln!("SKIPPED: {missing}");
    false
}

fn assert_is_shut_by_death(lock: &Pi) {
    for _ in 0..2 {
        assert_eq!(lock.with(|_| ()), Err(Shut::OwnerDied));
        assert_eq!(lock.try_with(|_| ()), Err(Shut::OwnerDied));
        assert_eq!(lock.with_until(PATIENCE, |value, owner| (*value, owner)), Ok((7, Owner::Died)));
    }
}

/// A thread inside `lock` that dies there, without unwinding, when what is
/// returned beside its id is dropped.
fn doomed(lock: &'static Pi) -> (u32, mpsc::Sender<()>) {
    let (entered, when_entered) = mpsc::channel();
    let (die, when_to_die) = mpsc::channel::<()>();
    let (_, tid) = spawn(move || {
        lock.with(|_| {
            entered.send(()).unwrap();
            when_to_die.recv().unwrap_err();
            sys::die()
        })
    });
    when_entered.recv().unwrap();
    (tid, die)
}

/// Runs `f` while another thread is inside.
fn while_another_is_inside<L: Lock, R>(lock: &L, f: impl FnOnce() -> R) -> R {
    thread::scope(|threads| {
        let (entered, when_entered) = mpsc::channel();
        let (leave, when_to_leave) = mpsc::channel::<()>();
        threads.spawn(move || {
            lock.with(|_| {
                entered.send(()).unwrap();
                when_to_leave.recv().unwrap_err();
            })
        });
        when_entered.recv().unwrap();
        let out = f();
        drop(leave);
        out
    })
}

/// Runs `f` in a thread for which these futex operations fail with `errno`.
fn without(
    operations: &'static [libc::c_int],
    errno: libc::c_int,
    f: impl FnOnce() + Send + 'static,
) {
    let (thread, _) = spawn(move || {
        sys::refuse_futex(operations, errno);
        f();
    });
    thread.join().unwrap();
}

/// A thread, and its kernel id.
fn spawn<R: Send + 'static>(
    f: impl FnOnce() -> R + Send + 'static,
) -> (thread::JoinHandle<R>, u32) {
    let (tell, told) = mpsc::channel();
    let thread = thread::spawn(move || {
        tell.send(sys::tid()).unwrap();
        drop(tell);
        f()
    });
    (thread, told.recv().unwrap())
}

fn wait_until_blocked(tid: u32) {
    poll(|| blocks_on_a_futex(tid) == Some(true), "never waited");
}

fn wait_until_gone(tid: u32) {
    poll(|| blocks_on_a_futex(tid).is_none(), "never ended");
}

/// Whether the thread sleeps in a futex call; nothing if there is none.
fn blocks_on_a_futex(tid: u32) -> Option<bool> {
    let call = fs::read_to_string(format!("/proc/self/task/{tid}/syscall")).ok()?;
    Some(call.split(' ').next() == Some(&libc::SYS_futex.to_string()))
}

fn poll(happened: impl Fn() -> bool, otherwise: &str) {
    let start = Instant::now();
    while !happened() {
        assert!(Duration::from(start.elapsed()) < PATIENCE, "it {otherwise}");
        thread::yield_now();
    }
}
