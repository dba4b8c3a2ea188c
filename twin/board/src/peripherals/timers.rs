//! The timers beside TIM2, TIM3 and TIM5: TIM1, TIM4, TIM6 to TIM14.
//!
//! RM0090 chapters 17 to 20, RM0390 chapters 16 to 19. They are counters with compare and interrupts; their inputs and
//! outputs reach no pin, and an output that is switched on is refused.

use super::rcc::{APB1, APB2, Gate};
use super::timer::{Kind, Timer};
use super::{Clocks, TIM2};

/// One of them.
pub(super) struct Place {
    /// First address.
    base: u32,
    /// Its clock.
    pub gate: Gate,
    /// NVIC inputs of update and compare (RM0090 table 61).
    irqs: [u16; 2],
    /// Channels it has.
    channels: u32,
}

const fn place(base: u32, bus: u32, bit: u32, irqs: [u16; 2], channels: u32) -> Place {
    Place { base, gate: Gate { bus, bit }, irqs, channels }
}

pub(super) const TIMERS: [Place; 11] = [
    place(0x4001_0000, APB2, 0, [25, 27], 4),
    place(0x4000_0800, APB1, 2, [30, 30], 4),
    place(0x4000_1000, APB1, 4, [54, 54], 0),
    place(0x4000_1400, APB1, 5, [55, 55], 0),
    place(0x4001_0400, APB2, 1, [44, 46], 4),
    place(0x4001_4000, APB2, 16, [24, 24], 2),
    place(0x4001_4400, APB2, 17, [25, 25], 1),
    place(0x4001_4800, APB2, 18, [26, 26], 1),
    place(0x4000_1800, APB1, 6, [43, 43], 2),
    place(0x4000_1C00, APB1, 7, [44, 44], 1),
    place(0x4000_2000, APB1, 8, [45, 45], 1),
];
/// TIM1 and TIM8, with a repetition counter and a main output enable.
const ADVANCED: [u32; 2] = [0x4001_0000, 0x4001_0400];

/// The timer whose registers begin at `base`.
pub(super) fn at(base: u32) -> Option<usize> {
    TIMERS.iter().position(|place| place.base == base)
}

/// All of them.
#[derive(Clone, Debug)]
pub struct Timers {
    all: [Timer; 11],
    /// Whether the program has touched any since the reset: until then all stand still.
    are_touched: bool,
}

impl Default for Timers {
    fn default() -> Self {
        let all = std::array::from_fn(|n| {
            let Place { base, channels, .. } = TIMERS[n];
            Timer::new(Kind { bits: 16, channels, is_advanced: ADVANCED.contains(&base), ..TIM2 }, 1)
        });
        Timers { all, are_touched: false }
    }
}

impl Timers {
    /// One of [`TIMERS`].
    pub fn get(&mut self, n: usize) -> &mut Timer {
        self.are_touched = true;
        &mut self.all[n]
    }

    /// A reset of the whole part.
    pub fn reset(&mut self) {
        self.all.iter_mut().for_each(Timer::reset);
        self.are_touched = false;
    }

    /// A reset by RCC.
    pub fn reset_at(&mut self, bus: u32, bits: u32) {
        for (timer, place) in self.all.iter_mut().zip(&TIMERS) {
            if place.gate.bus == bus && bits >> place.gate.bit & 1 == 1 {
                timer.reset();
            }
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
        if !self.are_touched {
            return;
        }
        for (timer, place) in self.all.iter_mut().zip(&TIMERS) {
            for (irq, level) in place.irqs.into_iter().zip(timer.irqs(cycle)) {
                set(irq, level);
            }
        }
    }

    /// The cycle at which one next raises its line.
    pub fn next_event(&self, cycle: u64) -> Option<u64> {
        if !self.are_touched {
            return None;
        }
        self.all.iter().filter_map(|timer| timer.next_event(cycle)).min()
    }
}
