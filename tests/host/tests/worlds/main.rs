//! Masters and slaves on two simulated buses: what the standard wants, seen from outside.

mod determinism;
mod disturbed;
mod failover;
mod messages;
mod recovery;
mod scripts;
mod start_up;
mod support;
mod time;
mod toggling;
