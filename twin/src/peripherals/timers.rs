//! The timers TIM1 to TIM14.
//!
//! RM0090 chapters 17 to 20, RM0390 chapters 16 to 19. TIM3 and TIM5 drive pins, and TIM5 captures. The others are counters with
//! compare and interrupts; their inputs and outputs reach no pin, and an output that is switched on is refused.

use super::Clocks;
use super::rcc::{APB1, APB2, Gate};
use super::timer::{Kind, Timer};

/// A timer of the part.
pub(super) struct Place {
    /// First address of its registers.
    base: u32,
    /// Gate of its clock.
    pub gate: Gate,
    /// NVIC inputs of update and compare (RM0090 table 61).
    irqs: [u16; 2],
    kind: Kind,
}

const fn place(base: u32, bus: u32, bit: u32, irqs: [u16; 2], kind: Kind) -> Place {
    Place { base, gate: Gate { bus, bit }, irqs, kind }
}

/// Returns a counter of 16 bits with this number of channels.
const fn counter(channels: u32) -> Kind {
    Kind { bits: 16, trigger: None, drives_pins: false, channels, is_advanced: false }
}

/// TIM1 and TIM8, with a repetition counter and a main output enable.
const ADVANCED: Kind = Kind { is_advanced: true, ..counter(4) };

/// Indices of these timers in [`TIMERS`].
pub(super) const TIM2: usize = 0;
pub(super) const TIM3: usize = 1;
pub(super) const TIM5: usize = 2;

/// Trigger inputs: ITR2 of TIM3 is TIM5 (RM0090 table 93, RM0390 the same). Outputs of TIM2 are not modelled.
pub(super) const TIMERS: [Place; 14] = [
    place(0x4000_0000, APB1, 0, [28, 28], Kind { bits: 32, ..counter(4) }),
    place(0x4000_0400, APB1, 1, [29, 29], Kind { trigger: Some(2), drives_pins: true, ..counter(4) }),
    place(0x4000_0C00, APB1, 3, [50, 50], Kind { bits: 32, drives_pins: true, ..counter(4) }),
    place(0x4001_0000, APB2, 0, [25, 27], ADVANCED),
    place(0x4000_0800, APB1, 2, [30, 30], counter(4)),
    place(0x4000_1000, APB1, 4, [54, 54], counter(0)),
    place(0x4000_1400, APB1, 5, [55, 55], counter(0)),
    place(0x4001_0400, APB2, 1, [44, 46], ADVANCED),
    place(0x4001_4000, APB2, 16, [24, 24], counter(2)),
    place(0x4001_4400, APB2, 17, [25, 25], counter(1)),
    place(0x4001_4800, APB2, 18, [26, 26], counter(1)),
    place(0x4000_1800, APB1, 6, [43, 43], counter(2)),
    place(0x4000_1C00, APB1, 7, [44, 44], counter(1)),
    place(0x4000_2000, APB1, 8, [45, 45], counter(1)),
];

/// The timer whose registers begin at `base`.
pub(super) fn at(base: u32) -> Option<usize> {
    TIMERS.iter().position(|place| place.base == base)
}

/// First addresses of the timers, in the order of [`TIMERS`].
pub(super) fn bases() -> impl Iterator<Item = u32> {
    TIMERS.iter().map(|place| place.base)
}

/// All timers, in the order of [`TIMERS`].
#[derive(Clone, Debug)]
pub struct Timers {
    pub all: [Timer; TIMERS.len()],
    /// A bit for each timer that the program has accessed since the reset. Until then a timer does not count.
    touched: u32,
}

impl Default for Timers {
    fn default() -> Self {
        Timers { all: std::array::from_fn(|n| Timer::new(TIMERS[n].kind, 1)), touched: 0 }
    }
}

impl Timers {
    /// Returns the timer whose registers the program accesses.
    pub fn touch(&mut self, n: usize) -> &mut Timer {
        self.touched |= 1 << n;
        &mut self.all[n]
    }

    /// Returns the indices of the timers that the program has accessed.
    fn touched(&self) -> impl Iterator<Item = usize> + use<> {
        let mut rest = self.touched;
        std::iter::from_fn(move || {
            let n = rest.trailing_zeros();
            rest &= rest.wrapping_sub(1);
            (n < u32::BITS).then_some(n as usize)
        })
    }

    /// Returns whether the program has accessed a timer since the reset.
    pub fn is_touched(&self, n: usize) -> bool {
        self.touched >> n & 1 == 1
    }

    /// Simulates the timers in use until `cycle`.
    pub fn catch_up(&mut self, cycle: u64) {
        for n in self.touched() {
            self.all[n].catch_up(cycle);
        }
    }

    /// A reset of the whole part.
    pub fn reset(&mut self) {
        self.all.iter_mut().for_each(Timer::reset);
        self.touched = 0;
    }

    /// A reset by RCC.
    pub fn reset_at(&mut self, bus: u32, bits: u32) {
        for (timer, place) in self.all.iter_mut().zip(&TIMERS) {
            if place.gate.bus == bus && bits >> place.gate.bit & 1 == 1 {
                timer.reset();
            }
        }
    }

    /// Stops the clocks of touched timers with such gates, or lets them run again.
    pub fn clock(&mut self, cycle: u64, on: bool, concerns: impl Fn(Gate) -> bool) {
        for n in self.touched().filter(|&n| concerns(TIMERS[n].gate)) {
            self.all[n].clock(cycle, on);
        }
    }

    /// The clock tree has changed at `cycle`.
    pub fn set_clocks(&mut self, cycle: u64, clocks: Clocks) {
        for (timer, place) in self.all.iter_mut().zip(&TIMERS) {
            // RM0090 7.2, figure 16: timers run at PCLK, or at twice PCLK when it is divided.
            let divider = match clocks.apb2_divider {
                _ if place.gate.bus == APB1 => clocks.timer1_divider,
                1 => 1,
                divider => divider / 2,
            };
            timer.set_divider(cycle, divider);
        }
    }

    /// Sets the lines of the NVIC as they are at `cycle`.
    pub fn irqs(&mut self, cycle: u64, mut set: impl FnMut(u16, bool)) {
        for n in self.touched() {
            for (irq, level) in TIMERS[n].irqs.into_iter().zip(self.all[n].irqs(cycle)) {
                set(irq, level);
            }
        }
    }

    /// Returns the next cycle at which a timer raises its line.
    pub fn next_event(&self, cycle: u64) -> Option<u64> {
        self.touched().filter_map(|n| self.all[n].next_event(cycle)).min()
    }
}
