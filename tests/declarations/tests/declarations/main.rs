//! Declarations that compile, and declarations that do not.

mod names;
mod refused;
