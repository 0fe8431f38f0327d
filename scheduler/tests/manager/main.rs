//! What the manager promises, rule by rule, and against a simple model.

mod cases;
mod cost;
mod demands;
mod dependencies;
mod journal;
mod model;
mod outcomes;
mod preemption;
mod protocol;
mod routine;
mod shortage;
mod telecommands;
mod windows;
mod world;
