//! Latency under load: how long a revocation takes until quiescent, how long an
//! emergency waits for its ticket, and how long a valid command waits for a
//! refused one, while the thread in the way has been pre-empted.
//!
//! Three threads under `SCHED_FIFO` in locked memory: a holder of low priority,
//! a hog of medium priority with 3 ms of work, and a revoker of high priority.
//! The holder is pre-empted exactly *inside* its command, which wakes who
//! pre-empts it. A lock that inherits priorities gets the holder out at once;
//! any other waits for the hog, and on a flight computer the hog need not end.
//! Our gates stand beside the plain locks, the paper's bare flag (fast, and
//! wrong: its commands come after their revocation), and a wake-up loop like
//! `cyclictest`'s from the same run, which is what the host itself makes of
//! real time.
//!
//! Each round begins when the revoker knows that the holder is inside, and ends
//! when it knows that the holder is out. Times are shown, not judged: a shared
//! or virtual machine has outliers of its own. What is judged is what no host
//! excuses: a command after quiescence.
//!
//! ```sh
//! cargo run --release --example latency
//! cargo run --release --example latency -- --quick --svg latency.svg
//! ```
//!
//! It needs the right to real-time priorities (root, or CAP_SYS_NICE) and two
//! CPUs; what it has not got it names, with the rows that are missing for it.

use std::process::ExitCode;

#[cfg(target_os = "linux")]
mod run;

#[cfg(target_os = "linux")]
fn main() -> ExitCode {
    run::main()
}

#[cfg(not(target_os = "linux"))]
fn main() -> ExitCode {
    eprintln!("error: this example measures Linux's SCHED_FIFO; run it on Linux");
    ExitCode::FAILURE
}
