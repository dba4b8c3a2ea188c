//! Pins of a controller.

use embassy_stm32::Peri;
use embassy_stm32::can::{RxPin, TxPin};

use super::Controller;
use crate::alternate::AlternatePin;

/// A CAN controller with its two pins.
pub struct CanLines<T: Controller> {
    _controller: Peri<'static, T>,
    pub(crate) rx: AlternatePin,
    pub(crate) tx: AlternatePin,
}

impl<T: Controller> CanLines<T> {
    /// Takes the RX and TX pins of the controller. Other pins do not compile.
    pub fn new(
        controller: Peri<'static, T>,
        rx: Peri<'static, impl RxPin<T>>,
        tx: Peri<'static, impl TxPin<T>>,
    ) -> CanLines<T> {
        let (rx, tx) = (AlternatePin(rx.af_num(), rx.into()), AlternatePin(tx.af_num(), tx.into()));
        CanLines { _controller: controller, rx, tx }
    }
}
