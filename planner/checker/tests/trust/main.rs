//! Why a plan can be trusted: thousands of random worlds, planned, and checked
//! by lines that the planner has no part in.

mod begun;
mod brute;
mod executions;
mod expanding;
mod explained;
mod mutants;
mod planner;
mod properties;
mod replans;
mod unavoidable;
mod values;
mod worlds;
