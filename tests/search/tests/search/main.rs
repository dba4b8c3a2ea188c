//! The searches, as far as they go in a minute.

mod fuzz;
mod states;
