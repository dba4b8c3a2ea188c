//! The twin with programs that are assembled by hand: no toolchain for the part is needed.

mod accelerator;
mod board;
mod capture;
mod cycles;
mod debug;
mod flash;
mod guests;
mod parts;
mod patches;
mod programs;
mod pulse;
mod spacecraft;
mod spin;
mod upset;
mod wiring;
