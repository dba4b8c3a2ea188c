//! Interrupts of both CAN controllers.

use ecss_can_stm32f4::{ReceiveHandler, StatusHandler, TransmitHandler};
use embassy_stm32::{bind_interrupts, peripherals};

bind_interrupts!(
    /// Interrupts of both CAN controllers, for `Board::new`.
    pub struct Irqs {
        CAN1_TX => TransmitHandler<peripherals::CAN1>;
        CAN1_RX0 => ReceiveHandler<peripherals::CAN1>;
        CAN1_SCE => StatusHandler<peripherals::CAN1>;
        CAN2_TX => TransmitHandler<peripherals::CAN2>;
        CAN2_RX0 => ReceiveHandler<peripherals::CAN2>;
        CAN2_SCE => StatusHandler<peripherals::CAN2>;
    }
);
