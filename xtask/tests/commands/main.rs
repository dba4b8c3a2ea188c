//! The commands of `xtask`, run as users run them, and the documents of the repository.

mod bench;
mod boards;
mod book;
mod cli;
mod docs;
mod elsewhere;
mod endings;
mod examples;
mod licences;
mod mutants;
mod patches;
mod release;
mod selftest;
mod statements;
mod walks;

/// The program under test.
const XTASK: second::programs::Program = second::programs::Program(env!("CARGO_BIN_EXE_xtask"));
