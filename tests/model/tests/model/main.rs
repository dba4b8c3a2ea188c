//! A small spacecraft, and what random faults do to it.

mod outside;
mod random;
mod shift;
