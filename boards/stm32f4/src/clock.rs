//! Uptime as the protocol's clock.

use ecss_can::runner::Clock;
use ecss_can::types::Instant;
use embassy_time::Timer;

use crate::supervisor;

/// Microseconds since power-on, counted by a hardware timer.
#[derive(Clone, Copy, Debug)]
pub struct Uptime;

impl Clock for Uptime {
    #[inline(always)] // what it calls returns a number in registers, this an instant in memory
    fn now(&self) -> Instant {
        Instant::from_micros(embassy_time::Instant::now().as_micros())
    }

    // Not an `async fn`: its future would store the deadline twice.
    fn at(&self, deadline: Instant) -> impl Future<Output = ()> {
        Timer::at(embassy_time::Instant::from_micros(deadline.as_micros()))
    }

    fn on_schedule(&self) {
        supervisor::on_schedule();
    }
}
