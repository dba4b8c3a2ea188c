//! The bxCAN model against RM0090 chapter 32: expected values are the manual's.

mod bench;

mod abort;
mod bus_off;
mod errors;
mod filters;
mod modes;
mod receive;
mod sleep;
mod traffic;
mod transmit;
