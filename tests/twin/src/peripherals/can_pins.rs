//! The pins that carry CAN_RX and CAN_TX: DS8626 table 9 (F405), DS10693 table 11 (F446).

use super::gpio::{Gpio, Pin};
use crate::bxcan::Side;

/// Alternate function of both controllers at all their pins.
const CAN_AF: u32 = 9;

/// A pin, and the smallest package that has it.
type Place = (Pin, u32);

/// CAN_RX of CAN1 and CAN2.
const RX: [&[Place]; 2] = [
    &[(Pin::new('B', 8), 64), (Pin::new('A', 11), 64), (Pin::new('D', 0), 100), (Pin::new('I', 9), 176)],
    &[(Pin::new('B', 12), 64), (Pin::new('B', 5), 64)],
];
/// CAN_TX of CAN1 and CAN2.
const TX: [&[Place]; 2] = [
    &[(Pin::new('B', 9), 64), (Pin::new('A', 12), 64), (Pin::new('D', 1), 100), (Pin::new('H', 13), 176)],
    &[(Pin::new('B', 13), 64), (Pin::new('B', 6), 64)],
];

/// Both signals of a controller are on pins of a package of `package_pins` pins.
pub(super) fn are_routed(gpio: &[Gpio], package_pins: u32, side: Side) -> bool {
    [RX, TX].iter().all(|signal| {
        signal[side as usize].iter().any(|&(pin, from)| from <= package_pins && carries(gpio, pin))
    })
}

/// Why they are not.
pub(super) fn missing(gpio: &[Gpio], package_pins: u32, side: Side) -> Option<String> {
    [(RX, "RX"), (TX, "TX")].iter().find_map(|(signal, name)| {
        let carrying = || signal[side as usize].iter().filter(|(pin, _)| carries(gpio, *pin));
        if carrying().any(|&(_, from)| from <= package_pins) {
            return None;
        }
        Some(match carrying().next() {
            Some((pin, _)) => {
                format!("{pin} carries {side}_{name}, and the package of {package_pins} pins lacks it")
            }
            None => format!("no pin carries {side}_{name} (AF9)"),
        })
    })
}

fn carries(gpio: &[Gpio], pin: Pin) -> bool {
    gpio[pin.port_index()].alternate_function(u32::from(pin.number)) == Some(CAN_AF)
}
