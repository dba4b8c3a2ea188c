//! Interrupt handlers of a controller: read everything, clear what was read, wake the port.
//!
//! All of them have one priority and do not interrupt each other.

use core::marker::PhantomData;

use ecss_can::link::Stamp;
use ecss_can::link::port::Mailbox;
use ecss_can::time::Clock;
use ecss_can::types::{CobId, Frame};
use embassy_stm32::interrupt::typelevel::{Binding, Handler};
use embassy_stm32::pac::can::Can;

use super::MAILBOXES;
use super::controller::Controller;
use super::events::EventQueue;
use super::results::Results;
use super::status::{Enables, Status};
use super::waiting::Waiting;
use crate::{DIAGNOSTICS, Uptime};

/// Interrupts of a controller, bound to the handlers of this driver.
pub trait ControllerInterrupts<T: Controller>:
    Binding<T::TXInterrupt, TransmitHandler<T>>
    + Binding<T::RX0Interrupt, ReceiveHandler<T>>
    + Binding<T::SCEInterrupt, StatusHandler<T>>
{
}

impl<T: Controller, I> ControllerInterrupts<T> for I where
    I: Binding<T::TXInterrupt, TransmitHandler<T>>
        + Binding<T::RX0Interrupt, ReceiveHandler<T>>
        + Binding<T::SCEInterrupt, StatusHandler<T>>
{
}

/// Handler of the transmit interrupt.
pub struct TransmitHandler<T>(PhantomData<T>);

/// Handler of the interrupt of receive FIFO 0.
pub struct ReceiveHandler<T>(PhantomData<T>);

/// Handler of the status change and error interrupt.
pub struct StatusHandler<T>(PhantomData<T>);

impl<T: Controller> Handler<T::TXInterrupt> for TransmitHandler<T> {
    unsafe fn on_interrupt() {
        transmitted(T::REGISTERS, T::events());
    }
}

impl<T: Controller> Handler<T::RX0Interrupt> for ReceiveHandler<T> {
    unsafe fn on_interrupt() {
        received(T::REGISTERS, T::events());
    }
}

impl<T: Controller> Handler<T::SCEInterrupt> for StatusHandler<T> {
    unsafe fn on_interrupt() {
        status_changed(T::REGISTERS, T::events());
    }
}

#[inline(never)] // once for both controllers
fn transmitted(registers: Can, events: &EventQueue) {
    DIAGNOSTICS.interrupts.transmit.count();
    let stamp = Stamp::interrupt(Uptime.now());
    events.update(|waiting| {
        let results = Results(registers.tsr().read().0);
        // First of all, so that it goes out right after the intermission.
        if let Some(next) = events.ended(|mailbox| results.ended(mailbox)) {
            request(registers, next);
        }
        registers.tsr().write(|w| w.0 = results.clearing());
        for mailbox in (0..MAILBOXES).filter(|mailbox| results.ended(*mailbox)) {
            waiting.finished(results.event(mailbox, stamp));
        }
        note_errors(registers, waiting);
    });
}

/// Requests the transmission of a frame that waits in its mailbox.
pub(super) fn request(registers: Can, mailbox: Mailbox) {
    registers.tx(usize::from(mailbox.0).min(MAILBOXES - 1)).tir().modify(|w| w.set_txrq(true));
}

#[inline(never)] // once for both controllers
fn received(registers: Can, events: &EventQueue) {
    DIAGNOSTICS.interrupts.receive.count();
    events.update(|waiting| {
        let fifo = registers.rfr(0);
        let mut status = fifo.read();
        loop {
            if status.fovr() {
                fifo.write(|w| w.set_fovr(true));
                waiting.lose();
            }
            if status.fmp() == 0 {
                break;
            }
            let stamp = Stamp::interrupt(Uptime.now());
            match oldest(registers) {
                Some(frame) => waiting.received(frame, stamp),
                None => waiting.lose(),
            }
            fifo.write(|w| w.set_rfom(true));
            loop {
                status = fifo.read();
                if !status.rfom() {
                    break;
                }
            }
        }
        note_errors(registers, waiting);
    });
}

#[inline(never)] // once for both controllers
fn status_changed(registers: Can, events: &EventQueue) {
    DIAGNOSTICS.interrupts.error.count();
    clear_errors(registers);
    let mut status = Status(registers.esr().read().0);
    let mut repeated = registers.msr().read().erri();
    if repeated {
        let again = Status(registers.esr().read().0);
        clear_errors(registers);
        // Another flag has risen in between: no repetition.
        repeated = again.flags() == status.flags();
        status = again;
    }
    events.update(|waiting| enable_sources(registers, waiting.errors.on_interrupt(status, repeated)));
}

/// Written, not modified: MSR holds other flags that are cleared by writing 1.
fn clear_errors(registers: Can) {
    registers.msr().write(|w| w.set_erri(true));
}

/// Follows the error register where it changes without an interrupt of its own: a better state comes with a success on
/// the bus; that after bus-off the port looks for. Not to be interrupted by the handlers above.
pub(super) fn note_errors(registers: Can, waiting: &mut Waiting) {
    let status = Status(registers.esr().read().0);
    // A flag that is new is left to the error interrupt, which would take it for another one. ESR is read first, so that
    // no flag comes between.
    if waiting.errors.is_news(status) && !registers.msr().read().erri() {
        enable_sources(registers, waiting.errors.note(status));
    }
}

/// Not LECIE: on a cut bus it would fire with every attempt.
pub(super) fn enable_sources(registers: Can, errors: Enables) {
    registers.ier().write(|w| {
        w.set_tmeie(true);
        w.set_fmpie(0, true);
        w.set_fovie(0, true);
        w.set_ewgie(errors.warning);
        w.set_epvie(errors.passive);
        w.set_bofie(errors.bus_off);
        w.set_errie(true);
    });
}

/// The frame at the output of FIFO 0. The filters admit 11-bit data frames only.
fn oldest(registers: Can) -> Option<Frame> {
    let mailbox = registers.rx(0);
    let id = CobId::new(mailbox.rir().read().stid())?;
    let [a, b, c, d] = mailbox.rdlr().read().0.to_le_bytes();
    let [e, f, g, h] = mailbox.rdhr().read().0.to_le_bytes();
    Some(Frame::from_dlc(id, mailbox.rdtr().read().dlc(), [a, b, c, d, e, f, g, h]))
}
