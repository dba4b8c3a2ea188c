//! Driver over bxCAN of embassy-stm32.

use core::pin::pin;
use core::task::{Context, Poll, Waker};

use async_canopen::link::Stamp;
use async_canopen::link::adapter::{Accepted, Driver, Mode, Received, Refused};
use async_canopen::link::port::{Filter, LastError};
use async_canopen::runner::Clock;
use async_canopen::types::{Frame, Instant};
use embassy_stm32::can::filter::Mask16;
use embassy_stm32::can::{Can, Fifo, Mailbox};
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embedded_can::StandardId;

use crate::Uptime;
use crate::frame::{cause, from_driver, to_driver};

/// Mask that compares all 11 bits of an identifier.
const ALL_BITS: StandardId = StandardId::MAX;

/// Driver over bxCAN of embassy-stm32, for the controller that owns the filters: CAN1, or the only one.
pub struct Bxcan {
    can: Can<'static>,
    mode: Mode,
}

impl Bxcan {
    /// Takes a controller whose bit rate is set and that was not enabled. It stays off the bus until the node joins.
    pub fn new(can: Can<'static>) -> Self {
        Bxcan { can, mode: Mode::Off }
    }
}

/// Polls a future once and drops it. Futures of this driver hold no state that is lost then.
fn poll_once<F: Future>(future: F, context: &mut Context<'_>) -> Poll<F::Output> {
    pin!(future).poll(context)
}

fn mailbox(place: u8) -> Mailbox {
    match place {
        0 => Mailbox::Mailbox0,
        1 => Mailbox::Mailbox1,
        _ => Mailbox::Mailbox2,
    }
}

impl Driver for Bxcan {
    /// CAN1 has 14 banks after a reset, with two filters each.
    const FILTERS: usize = 28;

    fn transmit(&mut self, frame: &Frame, _context: &mut Context<'_>) -> Result<Accepted, Refused> {
        let own = to_driver(frame).ok_or(Refused::Error(LastError::None))?;
        // Refused while a frame with this COB-ID is in a mailbox. `poll_sent` of that frame has registered the task.
        let status = self.can.try_write(&own).map_err(|_| Refused::Full)?;
        let replaced = status.dequeued_frame().is_some();
        Ok(Accepted::Followed { place: status.mailbox() as u8, replaced })
    }

    fn poll_receive(&mut self, context: &mut Context<'_>) -> Poll<Received> {
        loop {
            let received = match poll_once(self.can.read(), context) {
                Poll::Ready(Ok(envelope)) => {
                    let Some(frame) = from_driver(&envelope.frame) else { continue };
                    Received::Frame { frame, stamp: Stamp::interrupt(self.now()) }
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

    fn poll_sent(&mut self, place: u8, context: &mut Context<'_>) -> Poll<()> {
        poll_once(self.can.flush(mailbox(place)), context)
    }

    fn abort(&mut self, place: u8) -> bool {
        // With interrupts on, the handler would clear the result of the mailbox before the driver reads it.
        CriticalSectionMutex::new(()).lock(|()| self.can.abort(mailbox(place)))
    }

    fn set_mode(&mut self, mode: Mode) {
        if core::mem::replace(&mut self.mode, mode) == mode {
            return;
        }
        // Both futures write their command at the first poll. The controller then executes it without the driver.
        let mut context = Context::from_waker(Waker::noop());
        if mode == Mode::Off {
            let _ = poll_once(self.can.sleep(), &mut context);
        } else {
            self.can.modify_config().set_silent(mode == Mode::Listening);
            let _ = poll_once(self.can.enable(), &mut context);
        }
    }

    fn set_filters(&mut self, filters: &[Filter]) {
        let of = |filter: &Filter| {
            let bits = |raw| StandardId::new(raw).unwrap_or(ALL_BITS);
            let mut own = Mask16::frames_with_std_id(bits(filter.id.raw()), bits(filter.mask));
            *own.data_frames_only()
        };
        let mut banks = self.can.modify_filters();
        banks.clear();
        for (bank, pair) in (0..banks.num_banks()).zip(filters.chunks(2)) {
            if let [first, .., last] | [first @ last] = pair {
                banks.enable_bank(bank, Fifo::Fifo0, [of(first), of(last)]);
            }
        }
    }
}
