//! What flights of the images have in common: a spacecraft of real images, and what was seen on it.
//!
//! The flights themselves are `tests/flight/tests/flight`; those whose images take long to build are `tests/interop/tests/images`.

#![forbid(unsafe_code)]

mod program_faults;
pub mod rates;
mod spacecraft;

pub use program_faults::*;
pub use spacecraft::*;
