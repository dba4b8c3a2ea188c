//! Accesses to the registers of a controller that its port and its interrupts share.

use ecss_can::link::port::Mailbox;
use ecss_can::types::{CobId, Frame};
use embassy_stm32::pac::can::Can;
use embassy_stm32::pac::can::regs::{Ier, Mcr};

use super::MAILBOXES;
use super::status::Enables;

/// Requests the transmission of a frame that waits in its mailbox.
pub(super) fn request(registers: Can, mailbox: Mailbox) {
    registers.tx(usize::from(mailbox.0).min(MAILBOXES - 1)).tir().modify(|w| w.set_txrq(true));
}

/// Clears ERRI. Written, not modified: MSR holds other flags that are cleared by writing 1.
pub(super) fn clear_errors(registers: Can) {
    registers.msr().write(|w| w.set_erri(true));
}

/// Enables interrupts. LECIE stays off: on a cut bus it would raise an interrupt at every attempt.
pub(super) fn enable_sources(registers: Can, errors: Enables) {
    registers.ier().write_value(sources(errors));
}

/// Returns the enabled interrupts.
pub(super) fn sources(errors: Enables) -> Ier {
    let mut sources = Ier(0);
    sources.set_tmeie(true);
    sources.set_fmpie(0, true);
    sources.set_fovie(0, true);
    sources.set_ewgie(errors.warning);
    sources.set_epvie(errors.passive);
    sources.set_bofie(errors.bus_off);
    sources.set_errie(true);
    sources
}

/// Returns the mode of a controller, in Init mode or not. All other bits are off: TTCM, ABOM, AWUM, NART, RFLM, TXFP, SLEEP, DBF.
pub(super) fn mode(is_init: bool) -> Mcr {
    let mut mode = Mcr(0);
    mode.set_inrq(is_init);
    mode
}

/// Returns the frame at the output of FIFO 0. The filters admit 11-bit data frames only.
pub(super) fn oldest(registers: Can) -> Option<Frame> {
    let mailbox = registers.rx(0);
    let id = CobId::new(mailbox.rir().read().stid())?;
    let [a, b, c, d] = mailbox.rdlr().read().0.to_le_bytes();
    let [e, f, g, h] = mailbox.rdhr().read().0.to_le_bytes();
    Some(Frame::from_dlc(id, mailbox.rdtr().read().dlc(), [a, b, c, d, e, f, g, h]))
}
