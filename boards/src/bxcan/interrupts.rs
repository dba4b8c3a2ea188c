//! Interrupt handlers of a controller: read everything, clear what was read, wake the port.
//!
//! All of them have one priority and do not interrupt each other.

use core::marker::PhantomData;

use ecss_can::link::port::{MAILBOXES, Mailbox, PortEvent};
use ecss_can::link::{CobId, Frame};
use ecss_can::time::{Clock, Instant, Stamp};
use embassy_stm32::interrupt::typelevel::Handler;
use embassy_stm32::pac::can::Can;

use super::controller::Controller;
use crate::{TELLTALE, Uptime};

/// Handler of the transmit interrupt.
pub struct TransmitHandler<T>(PhantomData<T>);

/// Handler of the interrupt of receive FIFO 0.
pub struct ReceiveHandler<T>(PhantomData<T>);

/// Handler of the status change and error interrupt.
pub struct StatusHandler<T>(PhantomData<T>);

impl<T: Controller> Handler<T::TXInterrupt> for TransmitHandler<T> {
    unsafe fn on_interrupt() {
        TELLTALE.interrupts.transmit.count();
        let now = Uptime.now();
        let status = T::REGISTERS.tsr().read();
        let sent = (0..MAILBOXES).filter(|n| status.txok(*n)).count();
        let stamp = stamp(now, sent == 1 && T::REGISTERS.rfr(0).read().fmp() == 0);
        // Clearing RQCP clears the result bits of that mailbox too; those of a mailbox that ended since are kept.
        T::REGISTERS.tsr().write(|w| (0..MAILBOXES).for_each(|n| w.set_rqcp(n, status.rqcp(n))));
        for n in (0..MAILBOXES).filter(|n| status.rqcp(*n)) {
            let mailbox = Mailbox(n as u8);
            // With automatic retransmission a request ends by success or abort; ALST and TERR tell of the last attempt.
            T::events().finished(if status.txok(n) {
                PortEvent::Transmitted { mailbox, stamp }
            } else {
                PortEvent::Failed { mailbox }
            });
        }
        note_errors::<T>();
    }
}

impl<T: Controller> Handler<T::RX0Interrupt> for ReceiveHandler<T> {
    unsafe fn on_interrupt() {
        TELLTALE.interrupts.receive.count();
        let fifo = T::REGISTERS.rfr(0);
        loop {
            // Before the FIFO is looked at: if it holds one frame, all that ended until now have been reported.
            let now = Uptime.now();
            let status = fifo.read();
            if status.fovr() {
                fifo.write(|w| w.set_fovr(true));
                T::events().overrun();
            }
            if status.fmp() == 0 {
                break;
            }
            let frame = oldest(T::REGISTERS);
            fifo.write(|w| w.set_rfom(true));
            while fifo.read().rfom() {}
            match frame {
                Some(frame) => T::events().received(frame, stamp(now, status.fmp() == 1)),
                None => T::events().overrun(),
            }
        }
        note_errors::<T>();
    }
}

impl<T: Controller> Handler<T::SCEInterrupt> for StatusHandler<T> {
    unsafe fn on_interrupt() {
        TELLTALE.interrupts.error.count();
        // Written, not modified: MSR holds other flags that are cleared by writing 1.
        T::REGISTERS.msr().write(|w| w.set_erri(true));
        note_errors::<T>();
    }
}

/// The return to a better state raises no interrupt of its own; it comes with a success on the bus. That from bus-off
/// the port looks for.
fn note_errors<T: Controller>() {
    T::events().error_status(T::REGISTERS.esr().read());
}

/// Of a frame that was found at `now`, with or without later ones.
fn stamp(now: Instant, newest: bool) -> Stamp {
    if newest { Stamp::interrupt(now) } else { Stamp::late(now) }
}

/// The frame at the output of FIFO 0. The filters admit 11-bit data frames only.
fn oldest(registers: Can) -> Option<Frame> {
    let mailbox = registers.rx(0);
    let id = CobId::new(mailbox.rir().read().stid())?;
    let [a, b, c, d] = mailbox.rdlr().read().0.to_le_bytes();
    let [e, f, g, h] = mailbox.rdhr().read().0.to_le_bytes();
    Some(Frame::from_dlc(id, mailbox.rdtr().read().dlc(), [a, b, c, d, e, f, g, h]))
}
