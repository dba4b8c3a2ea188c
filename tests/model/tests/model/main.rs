//! Searches through all states of a small spacecraft.

mod outside;
mod search;
mod shift;
