//! Pins that carry the serial interfaces, by alternate function (DS8626 table 9, DS10693 table 11; DS9405 and DS11189, tables of alternate functions).

use super::gpio::Gpio;
use super::interfaces::{Interfaces, Sent};
use super::{Peripherals, can_pins};
use crate::bxcan::Side;
use crate::devices::{I2cDevice, SpiDevice};
use crate::part::{Lines, Part};
use crate::pin::Pin;

/// A pin, its alternate function, and the lines that have it.
type Route = (Pin, u32, Lines);

const fn pin(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, Lines::ALL)
}

const fn f446(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, Lines::F446)
}

const fn f46x(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, Lines::F46X)
}

/// All but the F40x.
const fn later(port: char, number: u8, function: u32) -> Route {
    (Pin::new(port, number), function, Lines::ALL.without(Lines::F40X))
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

/// TX and RX of USART1 to USART6.
const USART: [[&[Route]; 2]; 6] = [
    [&[pin('A', 9, 7), pin('B', 6, 7)], &[pin('A', 10, 7), pin('B', 7, 7)]],
    [&[pin('A', 2, 7), pin('D', 5, 7)], &[pin('A', 3, 7), pin('D', 6, 7)]],
    [
        &[pin('B', 10, 7), pin('C', 10, 7), pin('D', 8, 7)],
        &[pin('B', 11, 7), f446('C', 5, 7), pin('C', 11, 7), pin('D', 9, 7)],
    ],
    [&[pin('A', 0, 8), pin('C', 10, 8)], &[pin('A', 1, 8), pin('C', 11, 8)]],
    [&[pin('C', 12, 8), f446('E', 8, 8)], &[pin('D', 2, 8), f446('E', 7, 8)]],
    [&[pin('C', 6, 8), pin('G', 14, 8)], &[pin('C', 7, 8), pin('G', 9, 8)]],
];

/// SCK and MOSI of SPI1 to SPI3.
const SPI: [[&[Route]; 2]; 3] = [
    [&[pin('A', 5, 5), pin('B', 3, 5)], &[pin('A', 7, 5), pin('B', 5, 5)]],
    [
        &[
            pin('B', 10, 5),
            pin('B', 13, 5),
            pin('I', 1, 5),
            later('D', 3, 5),
            f46x('A', 9, 5),
            f446('A', 9, 5),
            f446('C', 7, 5),
        ],
        &[pin('B', 15, 5), pin('C', 3, 5), pin('I', 3, 5), f46x('C', 1, 5), f446('C', 1, 7)],
    ],
    [
        &[pin('B', 3, 6), pin('C', 10, 6)],
        &[
            pin('B', 5, 6),
            pin('C', 12, 6),
            later('D', 6, 5),
            f446('D', 0, 6),
            f446('B', 0, 7),
            f446('B', 2, 7),
            f446('C', 1, 5),
        ],
    ],
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

    /// Whether SCL and SDA of I2C1 to I2C3 (0 to 2) reach pins, and whether both are pulled up inside the chip.
    fn i2c(&self, n: usize) -> (bool, bool) {
        let routed = I2C[n].iter().all(|routes| self.carriers(routes).next().is_some());
        let is_pulled_up = |routes: &[Route]| self.carriers(routes).any(|(gpio, n)| gpio.is_pulled_up(n));
        (routed, I2C[n].iter().all(|routes| is_pulled_up(routes)))
    }

    /// Whether TX and RX of USART1 to USART6 (0 to 5) reach pins.
    fn usart(&self, n: usize) -> [bool; 2] {
        USART[n].map(|routes| self.carriers(routes).next().is_some())
    }

    /// Whether SCK and MOSI of SPI1 to SPI3 (0 to 2) reach pins.
    fn spi(&self, n: usize) -> bool {
        SPI[n].iter().all(|routes| self.carriers(routes).next().is_some())
    }

    /// Level of a pin.
    fn level(&self, pin: Pin) -> bool {
        self.gpio[pin.port_index()].idr() >> pin.number & 1 == 1
    }
}

impl Peripherals {
    /// Follows the alternate functions of the pins: CAN, and the serial interfaces in use.
    pub(super) fn follow_pins(&mut self, cycle: u64) {
        let is_routed = |side| can_pins::are_routed(&self.gpio, self.pins.can(side));
        self.can_routed = [Side::Can1, Side::Can2].map(is_routed);
        let ports = Ports { part: self.part, gpio: &self.gpio };
        let Interfaces { i2c, usart, spi } = &mut self.interfaces;
        for (n, i2c) in i2c.iter_mut().enumerate().filter(|(_, i2c)| i2c.is_enabled()) {
            let (routed, pulled_up) = ports.i2c(n);
            i2c.set_pins(cycle, routed, pulled_up);
        }
        for (n, usart) in usart.iter_mut().enumerate().filter(|(_, usart)| usart.is_enabled()) {
            usart.set_pins(cycle, ports.usart(n));
        }
        for (n, spi) in spi.iter_mut().enumerate().filter(|(_, spi)| spi.has_devices()) {
            spi.set_pins(ports.spi(n), |pin| ports.level(pin));
        }
    }

    /// Wires a device to I2C1 to I2C3 (0 to 2).
    pub fn attach_i2c(&mut self, cycle: u64, n: usize, device: Box<dyn I2cDevice>) {
        self.interfaces.i2c[n].attach(device);
        self.follow_pins(cycle);
    }

    /// Unplugs all devices of I2C1 to I2C3 (0 to 2), with their pull-ups.
    pub fn detach_i2c(&mut self, n: usize) {
        self.interfaces.i2c[n].detach_all();
    }

    /// Wires a device to SPI1 to SPI3 (0 to 2); `select` is its chip select, active low.
    pub fn attach_spi(&mut self, cycle: u64, n: usize, device: Box<dyn SpiDevice>, select: Option<Pin>) {
        self.interfaces.spi[n].attach(device, select);
        self.follow_pins(cycle);
    }

    /// Bytes arrive on RX of USART1 to USART6 (0 to 5).
    pub fn put_serial(&mut self, cycle: u64, n: usize, baud: u32, bytes: &[u8]) {
        self.interfaces.usart[n].put(cycle, baud, bytes);
    }

    /// Words that left on TX since the last call.
    pub fn take_sent(&mut self) -> Vec<Sent> {
        self.interfaces.take_sent()
    }
}
