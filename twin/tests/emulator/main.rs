//! The emulated board without firmware: programs assembled by hand, and the bxCAN model by its registers.

mod assembled;
mod bxcan;
