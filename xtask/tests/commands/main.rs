//! The commands as people run them, and the documents of the repository.

mod bench;
mod boards;
mod book;
mod cli;
mod demo;
mod docs;
mod eds;
mod elsewhere;
mod endings;
mod examples;
mod flash;
mod licences;
mod mutants;
mod public_docs;
mod selftest;
mod twin;
mod typed;
