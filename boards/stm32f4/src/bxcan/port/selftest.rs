//! Checks of a controller, its transceiver and its capture wire that need no other node.
//!
//! Both send one frame without retransmission and poll for its result. The interrupts of the controller are off from
//! the first check on, so that no handler takes the result.

use thiserror::Error;

use ecss_can::link::port::{CanPort, Filter, LastError};
use ecss_can::types::CobId;
use embassy_stm32::pac::can::vals::Silm;

use super::{Port, controller};
use crate::capture::Edges;

/// Reads of a register before a step fails. They take at least 10 ms; a frame takes 0.5 ms at 125 kbit/s.
const LOOKS: usize = 200_000;
/// Identifier of alternating bits: it has 7 falling edges up to RTR, and no node of a spacecraft uses it.
const IDENTIFIER: CobId = match CobId::new(0x555) {
    Some(id) => id,
    None => panic!("11 bits"),
};
const EDGES_OF_IDENTIFIER: usize = 7;
const DATA: [u32; 2] = [0x5500_FFAA, 0x0123_4567];
const LENGTH: u8 = 8;

/// Fault of a controller found in silent loopback.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ControllerFault {
    /// It did not enter Init mode.
    #[error("the controller did not enter Init mode")]
    Init,
    /// It did not leave Init mode: with CAN_RX as input, the bus is dominant all the time.
    #[error("the controller did not leave Init mode")]
    Start,
    /// The frame did not leave its mailbox.
    #[error("the frame did not leave its mailbox")]
    Transmit,
    /// The frame left with this error.
    #[error("the frame left with this error: {0:?}")]
    Error(LastError),
    /// The frame did not arrive in the FIFO.
    #[error("the frame did not arrive in the FIFO")]
    Receive,
    /// Another frame arrived: its identifier and its first four bytes.
    #[error("another frame arrived: identifier {0:03X}h, first bytes {1:08X}h")]
    Content(u16, u32),
}

/// Fault between a controller and its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LineFault {
    /// CAN_RX never shows 11 recessive bits in a row.
    #[error("CAN_RX never shows 11 recessive bits in a row")]
    Dominant,
    /// CAN_RX stays recessive while CAN_TX is dominant.
    #[error("CAN_RX stays recessive while CAN_TX is dominant")]
    NoEcho,
    /// The controller failed in another way.
    #[error("{0}")]
    Controller(ControllerFault),
}

/// Fault of a capture wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CaptureFault {
    /// The timer captured too few falling edges at its input; holds their number.
    #[error("the timer saw {0} falling edges at its input, which is too few")]
    TooFew(u8),
    /// The edges arrived at the input of the other bus.
    #[error("the edges came to the input of the other bus")]
    Swapped,
}

impl Port<Edges> {
    /// Sends a frame in silent loopback: nothing reaches the pins. The port must not have joined its bus.
    ///
    /// # Errors
    /// [`ControllerFault`].
    pub fn check_controller(&mut self) -> Result<(), ControllerFault> {
        self.set_filters(&[Filter::exact(IDENTIFIER)]);
        let sent = self.attempt(true).and_then(|is_sent| {
            if is_sent { self.take_echo() } else { Err(ControllerFault::Error(self.health().last_error)) }
        });
        self.end_attempt();
        sent
    }

    /// Sends a frame once on the bus. It needs no other node: even without an acknowledgement the controller reads all
    /// bits of the frame back. Returns the result at the capture inputs of this port and of `other`. The port must not
    /// have joined its bus.
    ///
    /// # Errors
    /// [`LineFault`].
    pub fn check_line(&mut self, other: &Port<Edges>) -> Result<Result<(), CaptureFault>, LineFault> {
        let before = [self.stamps.next(), other.stamps.next()];
        let sent = self.attempt(false);
        let last_error = self.health().last_error;
        self.end_attempt();
        match (sent, last_error) {
            // Another node acknowledged it.
            (Ok(true), _) | (Ok(false), LastError::Ack) => {}
            (Ok(false), LastError::BitDominant) => return Err(LineFault::NoEcho),
            (Ok(false), error) => return Err(LineFault::Controller(ControllerFault::Error(error))),
            (Err(ControllerFault::Start), _) => return Err(LineFault::Dominant),
            (Err(fault), _) => return Err(LineFault::Controller(fault)),
        }
        let [own, others] = [self.stamps.since(before[0]), other.stamps.since(before[1])];
        Ok(match (own, others) {
            (EDGES_OF_IDENTIFIER.., _) => Ok(()),
            (_, EDGES_OF_IDENTIFIER..) => Err(CaptureFault::Swapped),
            _ => Err(CaptureFault::TooFew(own as u8)),
        })
    }

    /// Enters the bus from Init mode and sends the frame once. Returns whether it was acknowledged; in loopback it
    /// needs no acknowledgement.
    fn attempt(&self, is_loopback: bool) -> Result<bool, ControllerFault> {
        let registers = self.registers;
        registers.ier().write(|w| w.0 = 0);
        reaches(|| registers.msr().read().inak()).ok_or(ControllerFault::Init)?;
        registers.btr().modify(|w| {
            w.set_lbkm(is_loopback);
            w.set_silm(if is_loopback { Silm::SILENT } else { Silm::NORMAL });
        });
        registers.tsr().write(|w| w.set_rqcp(0, true));
        // Clears INRQ and sets NART: no retransmission.
        registers.mcr().write(|w| w.set_nart(true));
        reaches(|| !registers.msr().read().inak()).ok_or(ControllerFault::Start)?;
        let mailbox = registers.tx(0);
        mailbox.tdtr().write(|w| w.set_dlc(LENGTH));
        mailbox.tdlr().write(|w| w.0 = DATA[0]);
        mailbox.tdhr().write(|w| w.0 = DATA[1]);
        mailbox.tir().write(|w| {
            w.set_stid(IDENTIFIER.raw());
            w.set_txrq(true);
        });
        reaches(|| registers.tsr().read().rqcp(0)).ok_or(ControllerFault::Transmit)?;
        Ok(registers.tsr().read().txok(0))
    }

    /// Takes the frame that loopback received.
    fn take_echo(&self) -> Result<(), ControllerFault> {
        let registers = self.registers;
        reaches(|| registers.rfr(0).read().fmp() > 0).ok_or(ControllerFault::Receive)?;
        let mailbox = registers.rx(0);
        let (id, length) = (mailbox.rir().read().stid(), mailbox.rdtr().read().dlc());
        let data = [mailbox.rdlr().read().0, mailbox.rdhr().read().0];
        registers.rfr(0).write(|w| w.set_rfom(true));
        let is_same = (id, length, data) == (IDENTIFIER.raw(), LENGTH, DATA);
        if is_same { Ok(()) } else { Err(ControllerFault::Content(id, data[0])) }
    }

    /// Goes back into Init mode with the settings of the port.
    fn end_attempt(&self) {
        self.registers.mcr().write(|w| w.set_inrq(true));
        if reaches(|| self.registers.msr().read().inak()).is_some() {
            controller::configure(self.registers, &self.timing, false);
        }
    }
}

/// Polls until `condition` holds. Returns `None` if it takes too long.
fn reaches(condition: impl Fn() -> bool) -> Option<()> {
    (0..LOOKS).any(|_| condition()).then_some(())
}
