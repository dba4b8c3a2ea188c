//! The twin flown by programs that are assembled by hand: no toolchain for the part is needed.

mod board;
mod capture;
mod flash;
mod guests;
mod programs;
mod spacecraft;
