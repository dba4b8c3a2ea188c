//! Log, panics, and the interrupts of the CAN controllers.

use boards::{ReceiveHandler, StatusHandler, TransmitHandler};
use defmt_rtt as _;
use embassy_stm32::{bind_interrupts, peripherals};
use panic_probe as _;

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

/// Ends a panic of `defmt`, whose message is in the log already.
#[defmt::panic_handler]
fn logged() -> ! {
    cortex_m::interrupt::disable();
    panic_probe::hard_fault()
}
