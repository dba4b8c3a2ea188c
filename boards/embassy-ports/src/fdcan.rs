//! Driver over FDCAN of embassy-stm32, for frames of classical CAN.

use core::pin::pin;
use core::task::{Context, Poll};

use async_canopen::link::Stamp;
use async_canopen::link::adapter::{Accepted, Driver, Mode, Received, Refused};
use async_canopen::link::port::{ErrorState, Filter, Health, LastError};
use async_canopen::runner::Clock;
use async_canopen::types::{Frame, Instant};
use embassy_stm32::can::config::{GlobalFilter, TxBufferMode};
use embassy_stm32::can::enums::BusErrorMode;
use embassy_stm32::can::filter::{Action, FilterType, StandardFilter};
use embassy_stm32::can::{Can, CanConfigurator, OperatingMode, Properties};

use crate::Uptime;
use crate::frame::{cause, from_driver, to_driver};

/// Number of acceptance filters of a controller.
const FILTERS: usize = 28;

/// Driver over FDCAN of embassy-stm32, for frames of classical CAN.
pub struct Fdcan {
    state: State,
}

enum State {
    /// Not started, off the bus. `None` only during the start.
    Configured(Option<CanConfigurator<'static>>),
    /// Started by the first `join`, on the bus.
    Started(Can<'static>),
}

impl Fdcan {
    /// Takes a controller whose bit rate is set. It stays off the bus until the node joins.
    pub fn new(mut can: CanConfigurator<'static>) -> Self {
        // FIFO: the priority queue aborts the wrong frame when it is full.
        let config = can.config().set_tx_buffer_mode(TxBufferMode::Fifo);
        can.set_config(config.set_global_filter(GlobalFilter::reject_all()));
        Fdcan { state: State::Configured(Some(can)) }
    }

    fn properties(&self) -> Option<&Properties> {
        match &self.state {
            State::Configured(can) => can.as_ref().map(CanConfigurator::properties),
            State::Started(can) => Some(can.properties()),
        }
    }

    fn started(&mut self) -> Option<&mut Can<'static>> {
        match &mut self.state {
            State::Configured(_) => None,
            State::Started(can) => Some(can),
        }
    }
}

impl Driver for Fdcan {
    const FILTERS: usize = FILTERS;

    fn transmit(&mut self, frame: &Frame, context: &mut Context<'_>) -> Result<Accepted, Refused> {
        let can = self.started().ok_or(Refused::Full)?;
        let own = to_driver(frame).ok_or(Refused::Error(LastError::None))?;
        // A future that is pending has written nothing, so it can be dropped.
        match pin!(can.write(&own)).poll(context) {
            Poll::Ready(replaced) => {
                Ok(Accepted::Unfollowed { replaced: replaced.as_ref().and_then(from_driver) })
            }
            Poll::Pending => Err(Refused::Full),
        }
    }

    fn poll_receive(&mut self, context: &mut Context<'_>) -> Poll<Received> {
        let Some(can) = self.started() else { return Poll::Pending };
        loop {
            let received = match pin!(can.read()).poll(context) {
                Poll::Ready(Ok(envelope)) => {
                    let Some(frame) = from_driver(&envelope.frame) else { continue };
                    // The driver's own stamp is wrong: it assumes another frequency of its timer.
                    Received::Frame { frame, stamp: Stamp::interrupt(Uptime.now()) }
                }
                Poll::Ready(Err(error)) => Received::Error(cause(&error)),
                Poll::Pending => return Poll::Pending,
            };
            return Poll::Ready(received);
        }
    }

    fn now(&self) -> Instant {
        Uptime.now()
    }

    fn health(&self) -> Option<Health> {
        let State::Started(can) = &self.state else { return None };
        let properties = can.properties();
        let state = match properties.bus_error_mode() {
            BusErrorMode::ErrorActive => ErrorState::Active,
            BusErrorMode::ErrorPassive => ErrorState::Passive,
            BusErrorMode::BusOff => ErrorState::BusOff,
        };
        let (tec, rec) = (properties.tx_error_count(), properties.rx_error_count());
        Some(Health { state, tec, rec, last_error: LastError::None })
    }

    fn set_mode(&mut self, mode: Mode) {
        if let State::Configured(can) = &mut self.state
            && mode != Mode::Off
            && let Some(can) = can.take()
        {
            self.state = State::Started(can.start(OperatingMode::NormalOperationMode));
        }
    }

    fn set_filters(&mut self, filters: &[Filter]) {
        let mut own = [StandardFilter::disable(); FILTERS];
        for (own, filter) in own.iter_mut().zip(filters) {
            let (filter, mask) = (filter.id.raw(), filter.mask);
            *own =
                StandardFilter { filter: FilterType::BitMask { filter, mask }, action: Action::StoreInFifo0 };
        }
        if let Some(properties) = self.properties() {
            properties.set_standard_filters(&own);
        }
    }
}
