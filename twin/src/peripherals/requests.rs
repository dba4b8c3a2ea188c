//! DMA requests of the peripherals, and the resulting transfers.

use super::Peripherals;
use super::dma::Transfer;
use super::map::DMA_BITS;
use super::rcc::{AHB1, Gate};
use super::timers::{TIM2, TIM5};
use crate::mmio::{Now, Width};

/// Memory that DMA reaches.
pub trait Ram {
    /// Copies from memory; `false` when there is none at this address.
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> bool;

    /// Copies into memory; `false` when there is none at this address.
    fn store(&mut self, address: u32, bytes: &[u8]) -> bool;

    /// Notes that DMA accesses the register of a peripheral at this address.
    fn moves(&mut self, register: u32) {
        let _ = register;
    }
}

/// Source of a DMA request: a timer with a set of channels, or an interface with its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Requester {
    Timer(usize, u32),
    I2cReceives(usize),
    I2cSends(usize),
}

/// Returns the source of requests for a stream of DMA1 (controller 0) or DMA2 on a channel (RM0090 tables 42 and 43).
const fn requester(controller: usize, stream: usize, channel: u32) -> Option<Requester> {
    use Requester::*;
    const CH1: u32 = 1;
    const CH2: u32 = 2;
    const CH3: u32 = 4;
    const CH4: u32 = 8;
    Some(match (controller, channel, stream) {
        (0, 1, 0 | 5) => I2cReceives(0),
        (0, 1, 6 | 7) => I2cSends(0),
        (0, 3, 1) => Timer(TIM2, CH3),
        (0, 3, 2) => I2cReceives(2),
        (0, 3, 4) => I2cSends(2),
        (0, 3, 5) => Timer(TIM2, CH1),
        (0, 3, 6) => Timer(TIM2, CH2 | CH4),
        (0, 3, 7) => Timer(TIM2, CH4),
        (0, 6, 0) => Timer(TIM5, CH3),
        (0, 6, 1 | 3) => Timer(TIM5, CH4),
        (0, 6, 2) => Timer(TIM5, CH1),
        (0, 6, 4) => Timer(TIM5, CH2),
        (0, 7, 2 | 3) => I2cReceives(1),
        (0, 7, 7) => I2cSends(1),
        _ => return None,
    })
}

impl Peripherals {
    /// Executes pending DMA requests. Returns whether there were any.
    pub fn transfer(&mut self, now: Now, ram: &mut dyn Ram) -> bool {
        // Limit of transfers: a stream that accesses another register than that of the requester would run for ever.
        const MOST: usize = 64;
        let mut any = false;
        for _ in 0..MOST {
            let Some((controller, transfer)) = self.next_transfer() else { break };
            any = true;
            let stream = transfer.stream;
            let asked = requester(controller, stream, self.dma[controller].channel(stream));
            // The transfer itself clears the request of a timer; the access to the data register clears that of an
            // interface.
            match asked {
                Some(Requester::Timer(timer, channels)) => {
                    let channels = self.timers.all[timer].requests & channels;
                    self.move_item(now, controller, transfer, ram);
                    self.timers.all[timer].requests &= !channels;
                }
                _ => {
                    let left = self.move_item(now, controller, transfer, ram);
                    if let (Some(Requester::I2cReceives(n)), Some(1)) = (asked, left) {
                        self.i2c.0[n].last_but_one_moved();
                    }
                }
            }
        }
        any
    }

    /// Moves one item. Returns how many are left; `None` after a bus error.
    fn move_item(
        &mut self,
        now: Now,
        controller: usize,
        transfer: Transfer,
        ram: &mut dyn Ram,
    ) -> Option<u32> {
        let Transfer { stream, peripheral, memory, bytes, from_memory } = transfer;
        let width = [Width::Byte, Width::Half, Width::Word][bytes.ilog2() as usize];
        let mut word = [0; 4];
        let item = &mut word[..bytes as usize];
        ram.moves(peripheral);
        let moved = if from_memory {
            ram.load(memory, item) && self.write(now, peripheral, width, u32::from_le_bytes(word)).is_ok()
        } else {
            self.read(now, peripheral, width).is_ok_and(|value| {
                item.copy_from_slice(&value.to_le_bytes()[..bytes as usize]);
                ram.store(memory, item)
            })
        };
        if moved {
            return Some(self.dma[controller].done(stream));
        }
        self.dma[controller].failed(stream);
        None
    }

    fn next_transfer(&self) -> Option<(usize, Transfer)> {
        (0..2).find_map(|controller| {
            let gate = Gate { bus: AHB1, bit: DMA_BITS[controller] };
            if !self.is_running(gate) {
                return None;
            }
            let asks =
                |stream, channel| requester(controller, stream, channel).is_some_and(|by| self.asks(by));
            self.dma[controller].next(asks).map(|transfer| (controller, transfer))
        })
    }

    fn asks(&self, requester: Requester) -> bool {
        match requester {
            Requester::Timer(timer, channels) => self.timers.all[timer].requests & channels != 0,
            Requester::I2cReceives(n) => self.i2c.0[n].asks_to_receive(),
            Requester::I2cSends(n) => self.i2c.0[n].asks_to_send(),
        }
    }
}
