//! Computed response times against published ones and against a simulated bus.

mod published;
mod simulated;
