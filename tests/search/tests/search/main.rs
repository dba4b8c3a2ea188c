//! Searches that take up to a minute.

mod fuzz;
mod states;
