//! A small spacecraft under random faults.

mod outside;
mod random;
mod shift;
