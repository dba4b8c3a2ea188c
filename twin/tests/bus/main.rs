//! The simulated bus, bit by bit.

mod common;
mod confinement;
mod errors;
mod failures;
mod faults;
mod frames;
mod modes;
mod paths;
mod scripts;
mod timing;
mod waveform;
