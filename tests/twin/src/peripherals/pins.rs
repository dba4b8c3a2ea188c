//! Pins that carry the serial interfaces, by alternate function (DS8626 table 9, DS10693 table 11; packages of 64 pins).

use super::Pin;
use super::gpio::Gpio;
use crate::model::Part;

/// A pin, its alternate function, and the one part that has it; `None` for both.
type Route = (Pin, u32, Option<Part>);

const fn pin(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, None)
}

const fn f405(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, Some(Part::Stm32f405))
}

const fn f446(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, Some(Part::Stm32f446))
}

/// SCL and SDA of I2C1 to I2C3.
const I2C: [[&[Route]; 2]; 3] = [
    [&[pin('B', 6, 4), pin('B', 8, 4)], &[pin('B', 7, 4), pin('B', 9, 4)]],
    [&[pin('B', 10, 4)], &[f405('B', 11, 4), f446('B', 3, 4), f446('C', 12, 4)]],
    [&[pin('A', 8, 4)], &[pin('C', 9, 4), f446('B', 4, 4)]],
];

/// The ports of a part.
pub(super) struct Ports<'a> {
    pub part: Part,
    pub gpio: &'a [Gpio],
}

impl Ports<'_> {
    /// Pins that carry one of these routes.
    fn carriers(&self, routes: &[Route]) -> impl Iterator<Item = (&Gpio, u32)> {
        let is_there = |only: Option<Part>| only.is_none_or(|part| part == self.part);
        routes.iter().filter_map(move |&(pin, function, only)| {
            let (gpio, n) = (&self.gpio[pin.port_index()], u32::from(pin.number));
            (is_there(only) && gpio.alternate_function(n) == Some(function)).then_some((gpio, n))
        })
    }

    /// Whether SCL and SDA of I2C1 to I2C3 (0 to 2) reach pins, and whether both are pulled up inside the chip.
    pub fn i2c(&self, n: usize) -> (bool, bool) {
        let routed = I2C[n].iter().all(|routes| self.carriers(routes).next().is_some());
        let is_pulled_up = |routes: &[Route]| self.carriers(routes).any(|(gpio, n)| gpio.is_pulled_up(n));
        (routed, I2C[n].iter().all(|routes| is_pulled_up(routes)))
    }
}
