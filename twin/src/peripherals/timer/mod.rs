//! Timers that count up, compare, capture, drive pins and start each other.
//!
//! RM0090 chapter 18. Modelled: prescaler and auto-reload with their buffers, URS, UDIS, UG, one-pulse mode, update and
//! compare flags, all output modes, input capture with polarity, prescaler and overcapture, interrupts, DMA requests of
//! the channels; OCxREF and UG as trigger output, trigger mode as slave mode. A capture takes the count at the cycle of
//! the edge. The delay of the input synchroniser, two timer clocks for every edge, is left out. Not modelled, and
//! refused: counting down or centre-aligned, other slave modes and trigger outputs, TI1 as XOR, TRC, the input filter
//! (ICxF), OCxFE and OCxCE, DMA requests by update and trigger. The preload of compare values (OCxPE) is stored without
//! effect.
//!
//! Flags, outputs and counter are computed from the cycle count when they are read; nothing is stepped.

mod counter;
mod output;
#[cfg(test)]
mod tests;
mod upset;

use counter::Counter;

use crate::mmio::{Refusal, Width};

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const DIER: u32 = 0x0C;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const CCMR1: u32 = 0x18;
const CCMR2: u32 = 0x1C;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2C;
const RCR: u32 = 0x30;
pub(super) const CCR1: u32 = 0x34;
pub(super) const CCR4: u32 = 0x40;
const BDTR: u32 = 0x44;

const CEN: u32 = 1 << 0;
const UDIS: u32 = 1 << 1;
const URS: u32 = 1 << 2;
const OPM: u32 = 1 << 3;
const ARPE: u32 = 1 << 7;
const UIF: u32 = 1 << 0;
/// UIF and CC1IF..CC4IF; the enables in DIER and the events in EGR have the same places.
const FLAGS: u32 = 0x1F;
/// Trigger flag, in SR.
const TIF: u32 = 1 << 6;
/// MMS in CR2.
const MMS: u32 = 0b111 << 4;
/// TS and SMS in SMCR; trigger mode.
const TS: u32 = 0b111 << 4;
const SMS: u32 = 0b111;
const TRIGGER_MODE: u32 = 0b110;
/// Timer clocks from a trigger to the beginning of count 0, after which a compare value of 1 drives its output one clock
/// later: five in all (RM0090 18.4.7, OC1FE).
const TRIGGER_CLOCKS: u64 = 4;
/// CC1DE in DIER and CC1OF in SR.
const CC1DE: u32 = 9;
const CC1OF: u32 = 9;
const CHANNEL_REQUESTS: u32 = 0xF << CC1DE;

/// Properties that differ between timers.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Bits of the counter.
    pub bits: u32,
    /// Trigger input (TS) at which another modelled timer's TRGO arrives.
    pub trigger: Option<u32>,
    /// Outputs reach pins.
    pub drives_pins: bool,
    /// Channels, 0 to 4.
    pub channels: u32,
    /// TIM1 and TIM8: RCR and BDTR.
    pub is_advanced: bool,
}

/// A timer.
#[derive(Clone, Debug)]
pub struct Timer {
    kind: Kind,
    cr1: u32,
    cr2: u32,
    smcr: u32,
    dier: u32,
    sr: u32,
    ccmr: [u32; 2],
    ccer: u32,
    ccr: [u32; 4],
    bdtr: u32,
    counter: Counter,
    /// Flags are up to date until this cycle.
    seen: u64,
    /// Cycle before which counting changes nothing; 0 if unknown.
    calm_until: u64,
    /// Channels 0..=3 whose DMA request waits to be served.
    pub requests: u32,
    /// Edges since the last capture, for the prescaler.
    edges: [u32; 4],
    /// Cycle of the last change to the capture settings; edges before it do not apply.
    set_up_at: u64,
    /// OC1REF to OC4REF.
    references: u32,
    /// Cycle at which the counter starts after a trigger.
    starts_at: Option<u64>,
    /// Cycles at which the trigger output rose, until they are taken.
    pub rises: Vec<u64>,
    /// Changes of outputs until they are taken: cycle, channel, level; `None` for an output that is off.
    pub changes: Vec<(u64, u32, Option<bool>)>,
}

impl Timer {
    /// After a reset, `divider` HCLK cycles per timer clock.
    pub fn new(kind: Kind, divider: u64) -> Self {
        Timer {
            kind,
            cr1: 0,
            cr2: 0,
            smcr: 0,
            dier: 0,
            sr: 0,
            ccmr: [0; 2],
            ccer: 0,
            ccr: [0; 4],
            bdtr: 0,
            counter: Counter::new(divider, u32::MAX >> (32 - kind.bits)),
            seen: 0,
            calm_until: 0,
            requests: 0,
            edges: [0; 4],
            set_up_at: 0,
            references: 0,
            starts_at: None,
            rises: Vec::new(),
            changes: Vec::new(),
        }
    }

    /// Resets the timer, by RCC or a system reset. Its clock does not change.
    pub fn reset(&mut self) {
        let lost = (0..4).filter(|n| self.output(*n).is_some()).map(|n| (self.seen, n, None)).collect();
        *self = Timer { changes: lost, ..Timer::new(self.kind, self.counter.divider) };
    }

    /// CCxS of channel 0..=3: 0 output, 1 its own input, 2 its neighbour's.
    fn selection(&self, channel: u32) -> u32 {
        self.ccmr[channel as usize / 2] >> (8 * (channel % 2)) & 0b11
    }

    fn is_input(&self, channel: u32) -> bool {
        self.selection(channel) != 0
    }

    /// CCxE, CCxP, CCxNP as bits 0, 1, 3.
    fn polarity(&self, channel: u32) -> u32 {
        self.ccer >> (4 * channel) & 0b1011
    }

    /// Returns flag bit and counter value of the events of counting. The update event is the return to zero.
    fn matches(&self) -> impl Iterator<Item = (u32, u32)> + use<'_> {
        let channels =
            (0..self.kind.channels).filter(|&n| !self.is_input(n)).map(|n| (n + 1, self.ccr[n as usize]));
        std::iter::once((0, 0)).chain(channels)
    }

    /// Returns whether a match of this flag bit requests DMA.
    fn asks_dma(&self, bit: u32) -> bool {
        bit > 0 && self.dier >> (CC1DE + bit - 1) & 1 == 1
    }

    /// Simulates the timer until `cycle`.
    pub fn catch_up(&mut self, cycle: u64) {
        if cycle < self.calm_until {
            self.seen = self.seen.max(cycle);
            return;
        }
        if let Some(start) = self.starts_at.take_if(|start| *start <= cycle) {
            self.pass(start);
            self.counter.run(start, true);
            self.set_up_at = start;
        }
        // One pulse: the update event stops the counter.
        if self.cr1 & (OPM | UDIS) == OPM
            && let Some(end) = self.counter.reaches(0, self.seen)
            && end <= cycle
        {
            self.pass(end);
            self.stop(end);
        }
        self.pass(cycle);
        self.calm_until = self.next_change_of_state().unwrap_or(u64::MAX);
    }

    /// Returns the next cycle at which counting sets a flag or changes an output, enabled or not.
    fn next_change_of_state(&self) -> Option<u64> {
        let matches = self.matches().filter_map(|(_, value)| self.counter.reaches(value, self.seen));
        let output = self.next_change(self.seen).map(|(at, ..)| at);
        matches.chain(output).chain(self.starts_at).min()
    }

    /// Counts until `cycle`.
    fn pass(&mut self, cycle: u64) {
        // A buffered prescaler or reload takes effect at the update event.
        while self.counter.is_stale() && self.cr1 & UDIS == 0 {
            match self.counter.reaches(0, self.seen) {
                Some(update) if update <= cycle => {
                    self.set_flags(update);
                    self.counter.update(update);
                }
                _ => break,
            }
        }
        self.set_flags(cycle);
    }

    /// Sets flags and outputs for the events until `cycle`.
    fn set_flags(&mut self, cycle: u64) {
        if cycle <= self.seen {
            return;
        }
        if !self.counter.running {
            self.seen = cycle;
            return;
        }
        let (mut flags, mut requests) = (0, 0);
        for (bit, value) in self.matches() {
            let asks_dma = self.asks_dma(bit);
            let idle = self.sr >> bit & 1 == 1 && !asks_dma;
            let update_disabled = bit == 0 && self.cr1 & UDIS != 0;
            if !idle
                && !update_disabled
                && self.counter.reaches(value, self.seen).is_some_and(|at| at <= cycle)
            {
                flags |= 1 << bit;
                requests |= u32::from(asks_dma) << bit >> 1;
            }
        }
        self.sr |= flags;
        self.requests |= requests;
        self.set_outputs(cycle);
        self.seen = cycle;
    }

    fn stop(&mut self, cycle: u64) {
        self.counter.run(cycle, false);
        self.cr1 &= !CEN;
        self.starts_at = None;
        self.set_up_at = cycle;
    }

    /// Sets the divider after a change of the clock tree: `divider` HCLK cycles per timer clock from `cycle` on.
    pub fn set_divider(&mut self, cycle: u64, divider: u64) {
        if divider != self.counter.divider {
            self.catch_up(cycle);
            self.counter.set_divider(cycle, divider);
            self.calm_until = 0;
        }
    }

    /// Interrupt lines of update and compare at `cycle`, which are one line of most timers.
    pub fn irqs(&mut self, cycle: u64) -> [bool; 2] {
        if self.dier & (FLAGS | CHANNEL_REQUESTS) == 0 {
            return [false; 2];
        }
        self.catch_up(cycle);
        let raised = self.sr & self.dier & FLAGS;
        [raised & UIF != 0, raised & !UIF != 0]
    }

    /// Returns whether the timer has this register.
    fn has(&self, offset: u32) -> bool {
        let channels = self.kind.channels;
        match offset {
            CR1 | DIER | SR | EGR | CNT | PSC | ARR => true,
            CR2 => !matches!(channels, 1 | 2),
            SMCR => channels >= 2,
            CCMR1 | CCER => channels >= 1,
            CCMR2 => channels == 4,
            CCR1..=CCR4 => (offset - CCR1) / 4 < channels,
            RCR | BDTR => self.kind.is_advanced,
            _ => false,
        }
    }

    /// The cycle at which counting next raises the interrupt line or a DMA request, or changes an output.
    pub fn next_event(&self, cycle: u64) -> Option<u64> {
        let output = self.next_change(cycle).map(|(at, ..)| at).into_iter().chain(self.starts_at).min();
        if self.dier & (FLAGS | CHANNEL_REQUESTS) == 0 {
            return output;
        }
        self.matches()
            .filter(|&(bit, _)| (self.dier & !self.sr) >> bit & 1 == 1 || self.asks_dma(bit))
            .filter_map(|(_, value)| self.counter.reaches(value, cycle))
            .chain(output)
            .min()
    }

    /// Returns whether a channel captures edges of input 0..=3.
    pub fn captures(&self, input: u32) -> bool {
        let takes = |channel: u32| match self.selection(channel) {
            1 => channel == input,
            2 => channel ^ 1 == input,
            _ => false,
        };
        (0..4).any(|channel| takes(channel) && self.polarity(channel) & 1 == 1)
    }

    /// The count at `cycle`, which may lie in the past, with the part of the next one that has passed.
    pub fn exact_count(&self, cycle: u64) -> f64 {
        self.counter.exact(cycle)
    }

    /// Handles an edge on input 0..=3 (TI1 to TI4) at `cycle`, which may be before the present of the program. Returns
    /// whether a capture raised the interrupt line or a DMA request.
    pub fn edge(&mut self, input: u32, cycle: u64, rising: bool) -> bool {
        if cycle < self.set_up_at {
            return false;
        }
        let mut told = false;
        for channel in 0..4 {
            let source = match self.selection(channel) {
                1 => channel,
                2 => channel ^ 1,
                _ => continue,
            };
            let wanted = match self.polarity(channel) {
                0b0001 => rising,
                0b0011 => !rising,
                0b1011 => true,
                _ => false,
            };
            if source != input || !wanted {
                continue;
            }
            let prescaler = self.ccmr[channel as usize / 2] >> (8 * (channel % 2) + 2) & 0b11;
            self.edges[channel as usize] += 1;
            if self.edges[channel as usize] >> prescaler != 0 {
                self.edges[channel as usize] = 0;
                self.catch_up(cycle);
                self.capture(channel, self.counter.count(cycle));
                told |= self.dier & (1 << (channel + 1) | 1 << (CC1DE + channel)) != 0;
            }
        }
        told
    }

    fn capture(&mut self, channel: u32, count: u32) {
        if self.sr >> (channel + 1) & 1 == 1 {
            self.sr |= 1 << (CC1OF + channel);
        }
        self.sr |= 1 << (channel + 1);
        self.ccr[channel as usize] = count;
        self.requests |= (self.dier >> (CC1DE + channel) & 1) << channel;
    }

    /// A load.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what does not exist.
    pub fn read(&mut self, cycle: u64, offset: u32) -> Result<u32, Refusal> {
        if !self.has(offset) {
            return Err(Refusal::Unmodelled);
        }
        self.catch_up(cycle);
        Ok(match offset {
            CR1 => self.cr1,
            CR2 => self.cr2,
            SMCR => self.smcr,
            DIER => self.dier,
            SR => self.sr,
            EGR => 0,
            CCMR1 => self.ccmr[0],
            CCMR2 => self.ccmr[1],
            CCER => self.ccer,
            CNT => self.counter.count(cycle),
            PSC => self.counter.psc,
            ARR => self.counter.arr,
            BDTR => self.bdtr,
            RCR => 0,
            CCR1..=CCR4 => {
                let channel = (offset - CCR1) / 4;
                if self.is_input(channel) {
                    self.sr &= !(1 << (channel + 1));
                }
                self.ccr[channel as usize]
            }
            _ => return Err(Refusal::Unmodelled),
        })
    }

    /// A store.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what is not modelled, [`Refusal::Width`] for a byte and for half a 32-bit register
    /// (RM0090 18.4).
    pub fn write(&mut self, cycle: u64, offset: u32, width: Width, value: u32) -> Result<(), Refusal> {
        let is_long = matches!(offset, CNT | ARR | CCR1..=CCR4) && self.kind.bits == 32;
        if !self.has(offset) {
            return Err(Refusal::Unmodelled);
        }
        if width == Width::Byte || is_long && width != Width::Word {
            return Err(Refusal::Width);
        }
        let value = if is_long { value } else { value & 0xFFFF };
        self.catch_up(cycle);
        self.calm_until = 0;
        match offset {
            // DIR and CMS change how it counts.
            CR1 if value & 0x70 != 0 => return Err(Refusal::Unmodelled),
            CR1 => {
                if (self.cr1 ^ value) & CEN != 0 {
                    self.counter.run(cycle, value & CEN != 0);
                    self.starts_at = None;
                    self.set_up_at = cycle;
                }
                self.cr1 = value;
            }
            CR2 => return self.set_trigger_output(cycle, value),
            SMCR => {
                let is_connected = self.kind.trigger == Some((value & TS) >> 4);
                let is_known = match value & SMS {
                    0 => true,
                    mode => mode == TRIGGER_MODE && is_connected,
                };
                if value & !(TS | SMS) != 0 || !is_known {
                    return Err(Refusal::Unmodelled);
                }
                self.smcr = value;
            }
            // UDE, COMDE and TDE are other DMA requests, TIE comes from slave modes.
            DIER if value & !(FLAGS | CHANNEL_REQUESTS) != 0 => return Err(Refusal::Unmodelled),
            DIER => {
                self.dier = value;
                self.requests &= value >> CC1DE;
            }
            // Flags clear by writing 0; writing 1 keeps them.
            SR => self.sr &= value,
            EGR => self.generate(cycle, value),
            CCMR1 | CCMR2 => return self.set_mode(cycle, offset, value),
            CCER => return self.set_enables(cycle, value),
            CNT => {
                self.counter.set_count(cycle, value);
                self.set_up_at = cycle;
                self.follow_modes(cycle);
            }
            PSC => self.counter.psc = value & 0xFFFF,
            ARR => self.counter.set_reload(cycle, value, self.cr1 & ARPE != 0),
            // Every overflow is an update; no output, no break.
            RCR if value != 0 => return Err(Refusal::Unmodelled),
            RCR => {}
            BDTR => self.bdtr = value,
            // In input mode a capture register is read-only.
            CCR1..=CCR4 if self.is_input((offset - CCR1) / 4) => {}
            CCR1..=CCR4 => {
                self.ccr[(offset - CCR1) as usize / 4] = value;
                self.follow_modes(cycle);
            }
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    /// CCMR1 and CCMR2. CCxS changes only while its channel is off (RM0090 18.4.7).
    fn set_mode(&mut self, cycle: u64, offset: u32, value: u32) -> Result<(), Refusal> {
        let pair = (offset - CCMR1) / 4;
        let frozen = (0..2).fold(0, |mask, n| {
            let enabled = self.polarity(2 * pair + n) & 1 == 1;
            mask | if enabled { 0b11 << (8 * n) } else { 0 }
        });
        let merged = self.ccmr[pair as usize] & frozen | value & 0xFFFF & !frozen;
        // TRC; of an output OCxCE and OCxFE, of an input its filter ICxF.
        let is_unknown = |mode: u32| match mode & 0b11 {
            0 => mode & 0x84 != 0,
            0b11 => true,
            _ => mode & 0xF0 != 0,
        };
        if (0..2).any(|n| is_unknown(merged >> (8 * n) & 0xFF)) {
            return Err(Refusal::Unmodelled);
        }
        let before = self.outputs();
        self.ccmr[pair as usize] = merged;
        self.set_up_at = cycle;
        self.note_outputs(cycle, before);
        self.follow_modes(cycle);
        Ok(())
    }

    fn set_enables(&mut self, cycle: u64, value: u32) -> Result<(), Refusal> {
        const RESERVED: u32 = 0b1001;
        let on = |channel: u32| value >> (4 * channel) & 1 == 1;
        if !self.kind.drives_pins && (0..4).any(|channel| on(channel) && !self.is_input(channel)) {
            return Err(Refusal::Unmodelled);
        }
        let before = self.outputs();
        self.ccer = value & 0xBBBB;
        self.set_up_at = cycle;
        self.note_outputs(cycle, before);
        for channel in 0..4 {
            // The prescaler starts again when the channel goes off (RM0090 18.4.7, ICxPSC).
            if self.polarity(channel) & 1 == 0 {
                self.edges[channel as usize] = 0;
            }
            if self.is_input(channel) && self.polarity(channel) == RESERVED {
                return Err(Refusal::Misuse);
            }
        }
        Ok(())
    }

    fn generate(&mut self, cycle: u64, value: u32) {
        if value & UIF != 0 && self.cr1 & UDIS == 0 {
            self.counter.update(cycle);
            self.set_up_at = cycle;
            if self.cr1 & URS == 0 {
                self.sr |= UIF;
            }
            if self.cr1 & OPM != 0 {
                self.stop(cycle);
            }
            self.follow_modes(cycle);
        }
        if value & UIF != 0 && self.cr2 & MMS == 0 {
            self.rises.push(cycle);
        }
        for channel in (0..4).filter(|n| value >> (n + 1) & 1 == 1) {
            if self.is_input(channel) {
                self.capture(channel, self.counter.count(cycle));
            } else {
                self.sr |= 1 << (channel + 1);
                self.requests |= (self.dier >> (CC1DE + channel) & 1) << channel;
            }
        }
    }
}
