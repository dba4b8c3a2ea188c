//! Platform of a node on these ports: port and clock.

use core::marker::PhantomData;

use async_canopen::link::adapter::{Adapter, Driver};
use async_canopen::runner::Clock;
use async_canopen::runner::Platform;
use async_canopen::types::Instant;
use embassy_time::Timer;

/// Board whose ports are adapters over the driver `D`.
pub struct Board<D>(PhantomData<D>);

impl<D: Driver + 'static> Platform for Board<D> {
    type Port = Adapter<D>;
    type Clock = Uptime;
}

/// Clock of embassy-time, in microseconds since power-on.
#[derive(Clone, Copy, Debug)]
pub struct Uptime;

impl Clock for Uptime {
    fn now(&self) -> Instant {
        Instant::from_micros(embassy_time::Instant::now().as_micros())
    }

    async fn at(&self, deadline: Instant) {
        Timer::at(embassy_time::Instant::from_micros(deadline.as_micros())).await;
    }
}
