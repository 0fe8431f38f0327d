//! Bodies with real processes and threads. Time is real here, so nothing is
//! judged by how long it took: only what happened, and in which order.
#![cfg(target_os = "linux")]

mod bodies {
    pub(crate) mod bench;
    mod functions;
    mod leftovers;
    pub(crate) mod look;
    mod ports;
    mod processes;
    mod sequences;
    mod trees;
}
