//! Pins that carry I2C, by alternate function (DS8626 table 9, DS10693 table 11; DS9405 and DS11189, tables of alternate functions).

use super::gpio::Gpio;
use super::{Peripherals, can_pins};
use crate::bxcan::Side;
use crate::devices::I2cDevice;
use crate::part::{Lines, Part};
use crate::pin::Pin;

/// A pin, its alternate function, and the lines of parts that have it.
type Route = (Pin, u32, Lines);

const fn pin(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, Lines::ALL)
}

const fn f446(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, Lines::F446)
}

/// SCL and SDA of I2C1 to I2C3.
const I2C: [[&[Route]; 2]; 3] = [
    [&[pin('B', 6, 4), pin('B', 8, 4)], &[pin('B', 7, 4), pin('B', 9, 4)]],
    [
        &[pin('B', 10, 4), pin('F', 1, 4), pin('H', 4, 4)],
        &[pin('B', 11, 4), pin('F', 0, 4), pin('H', 5, 4), f446('B', 3, 4), f446('C', 12, 4)],
    ],
    [&[pin('A', 8, 4), pin('H', 7, 4)], &[pin('C', 9, 4), pin('H', 8, 4), f446('B', 4, 4)]],
];

/// The ports of a part.
struct Ports<'a> {
    part: Part,
    gpio: &'a [Gpio],
}

impl Ports<'_> {
    /// Pins that carry one of these routes.
    fn carriers(&self, routes: &[Route]) -> impl Iterator<Item = (&Gpio, u32)> {
        let is_there = |pin, lines: Lines| lines.has(self.part.lines()) && self.part.has_pin(pin);
        routes.iter().filter_map(move |&(pin, function, lines)| {
            let (gpio, n) = (&self.gpio[pin.port_index()], u32::from(pin.number));
            (gpio.alternate_function(n) == Some(function) && is_there(pin, lines)).then_some((gpio, n))
        })
    }

    /// Returns whether SCL and SDA of I2C1 to I2C3 (0 to 2) reach pins, and whether both are pulled up inside the chip.
    fn i2c(&self, n: usize) -> (bool, bool) {
        let routed = I2C[n].iter().all(|routes| self.carriers(routes).next().is_some());
        let is_pulled_up = |routes: &[Route]| self.carriers(routes).any(|(gpio, n)| gpio.is_pulled_up(n));
        (routed, I2C[n].iter().all(|routes| is_pulled_up(routes)))
    }
}

impl Peripherals {
    /// Updates CAN, and I2C that is in use, after a change of the pins' alternate functions.
    pub(super) fn follow_pins(&mut self, cycle: u64) {
        let is_routed = |side| can_pins::are_routed(&self.gpio, self.pins.can(side));
        self.can_routed = [Side::Can1, Side::Can2].map(is_routed);
        let ports = Ports { part: self.part, gpio: &self.gpio };
        for (n, i2c) in self.i2c.0.iter_mut().enumerate().filter(|(_, i2c)| i2c.is_enabled()) {
            let (routed, pulled_up) = ports.i2c(n);
            i2c.set_pins(cycle, routed, pulled_up);
        }
    }

    /// Wires a device to I2C1 to I2C3 (0 to 2).
    pub fn attach_i2c(&mut self, cycle: u64, n: usize, device: Box<dyn I2cDevice>) {
        self.i2c.0[n].devices.push(device);
        self.follow_pins(cycle);
    }
}
