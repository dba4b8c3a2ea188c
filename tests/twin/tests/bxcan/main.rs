//! The bxCAN model against RM0090 chapter 32: expected values are the manual's.

mod bench;

mod errors;
mod filters;
mod modes;
mod receive;
mod transmit;
