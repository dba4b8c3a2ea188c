//! The applications of the images, for a board and for tests on the host.
//!
//! An image runs an `Application` on the LEDs of its board. A test runs the same code on a mock board with
//! [`Indicators`](crate::Indicators) of its own.

pub mod master;
pub mod minimal;
pub mod slave;
