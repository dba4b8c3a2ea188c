//! Packages that build for the boards, and packages that must not.

mod images;
mod mistakes;
mod pins;
mod scratch;
mod shipped;
