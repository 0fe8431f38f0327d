//! A process that works for so long, pauses not counted, with a child that
//! works beside it.

use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// How long the tree works; in the environment of the leader and of the child.
pub(crate) const SECONDS: &str = "FAREGATE_TEST_WORKS";
const IS_CHILD: &str = "FAREGATE_TEST_IS_CHILD";

/// Two steps that are further apart than this had a pause between them.
const PAUSE: Duration = Duration::from_secs(1);

pub(crate) fn work() {
    let Ok(seconds) = std::env::var(SECONDS) else { return };
    let child = std::env::var_os(IS_CHILD).is_none().then(beget);
    let length = Duration::from_secs_f64(seconds.parse().expect("seconds"));
    let (mut worked, mut before) = (Duration::ZERO, Instant::now());
    while worked < length {
        let now = Instant::now();
        let step = now - before;
        // Time in which it stood still is not worked.
        if step < PAUSE {
            worked += step;
        }
        before = now;
    }
    if let Some(mut child) = child {
        let _ = child.wait();
    }
}

fn beget() -> Child {
    let itself = std::env::current_exe().expect("its own file");
    Command::new(itself).args(std::env::args().skip(1)).env(IS_CHILD, "").spawn().expect("a child")
}
