//! The commands for users, as they run them.

mod boards;
mod campaign;
mod cli;
mod demo;
mod eds;
mod elsewhere;
mod endings;
mod schedule;
mod twin;
mod typed;

/// The program under test.
const TOOLS: second::programs::Program = second::programs::Program(env!("CARGO_BIN_EXE_tools"));
