//! The pins that carry CAN_RX and CAN_TX: DS8626 table 9, DS10693 table 11; DS9405 and DS11189, tables of alternate functions.

use super::gpio::Gpio;
use crate::bxcan::Side;
use crate::model::CanPins;
use crate::part::Part;
use crate::pin::Pin;

/// Alternate function of both controllers at all their pins.
const CAN_AF: u32 = 9;

/// CAN_RX of CAN1 and CAN2.
const RX: [&[Pin]; 2] = [
    &[Pin::new('B', 8), Pin::new('A', 11), Pin::new('D', 0), Pin::new('I', 9)],
    &[Pin::new('B', 12), Pin::new('B', 5)],
];
/// CAN_TX of CAN1 and CAN2.
const TX: [&[Pin]; 2] = [
    &[Pin::new('B', 9), Pin::new('A', 12), Pin::new('D', 1), Pin::new('H', 13)],
    &[Pin::new('B', 13), Pin::new('B', 6)],
];

/// Returns the pins that can carry CAN_RX, and those that can carry CAN_TX, in any part.
pub(crate) fn places(side: Side) -> [&'static [Pin]; 2] {
    [RX[side as usize], TX[side as usize]]
}

/// Returns whether both signals of a controller are on the pins of the board's transceiver.
pub(super) fn are_routed(gpio: &[Gpio], CanPins { rx, tx }: CanPins) -> bool {
    carries(gpio, rx) && carries(gpio, tx)
}

/// Returns the reason why they are not.
pub(super) fn missing(gpio: &[Gpio], part: Part, pins: CanPins, side: Side) -> Option<String> {
    let [rx, tx] = places(side);
    [(pins.rx, rx, "RX"), (pins.tx, tx, "TX")].into_iter().find_map(|(wired, places, name)| {
        if carries(gpio, wired) {
            return None;
        }
        let carrying = || places.iter().copied().filter(|&pin| carries(gpio, pin));
        Some(match (carrying().find(|pin| part.has_pin(*pin)), carrying().next()) {
            (Some(pin), _) => {
                format!("{pin} carries {side}_{name}, and the board has the transceiver at {wired}")
            }
            (None, Some(pin)) => {
                let package = part.package_pins();
                format!("{pin} carries {side}_{name}, and the package of {package} pins lacks it")
            }
            (None, None) => format!("no pin carries {side}_{name} (AF9)"),
        })
    })
}

fn carries(gpio: &[Gpio], pin: Pin) -> bool {
    gpio[pin.port_index()].alternate_function(u32::from(pin.number)) == Some(CAN_AF)
}
