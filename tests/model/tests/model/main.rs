//! Searches through all states of a small spacecraft.

mod search;
mod shift;
