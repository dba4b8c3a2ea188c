//! USART1 to USART6, asynchronous.
//!
//! RM0090 chapter 30, RM0390 chapter 25. Modelled: transmission and reception with their double buffers, 8 and 9 bits,
//! parity, stop bits, both oversamplings, bit time by BRR, TXE, TC, RXNE, IDLE, ORE, FE and PE with the sequences that clear
//! them, interrupts, DMA requests. Not modelled, and refused: synchronous mode, LIN, IrDA, smartcard, half duplex, RTS and CTS,
//! break and mute mode.

use std::collections::VecDeque;

use crate::mmio::Refusal;

const SR: u32 = 0x00;
const DR: u32 = 0x04;
const BRR: u32 = 0x08;
const CR1: u32 = 0x0C;
const CR2: u32 = 0x10;
const CR3: u32 = 0x14;
const GTPR: u32 = 0x18;

/// SR.
const PE: u32 = 1 << 0;
const FE: u32 = 1 << 1;
const NF: u32 = 1 << 2;
const ORE: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;
/// Cleared by a load of SR and one of DR.
const SEQUENCE: u32 = PE | FE | NF | ORE | IDLE;
/// CR1.
const RE: u32 = 1 << 2;
const TE: u32 = 1 << 3;
const PEIE: u32 = 1 << 8;
const PS: u32 = 1 << 9;
const PCE: u32 = 1 << 10;
const M: u32 = 1 << 12;
const UE: u32 = 1 << 13;
const OVER8: u32 = 1 << 15;
/// SBK and RWU.
const CR1_LACKING: u32 = 0b11;
/// CR2: all but STOP and the address.
const STOP: u32 = 0b11 << 12;
const CR2_MODELLED: u32 = STOP | 0xF;
/// CR3: EIE, DMAR, DMAT, ONEBIT.
const EIE: u32 = 1 << 0;
const DMAR: u32 = 1 << 6;
const DMAT: u32 = 1 << 7;
const CR3_MODELLED: u32 = EIE | DMAR | DMAT | 1 << 11;
/// How far the bit rate of the other end may be off: half a bit in the middle of the stop bit.
const TOLERANCE: f64 = 0.04;

/// A byte that has left on TX.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sent {
    /// The cycle at which its last stop bit ended.
    pub cycle: u64,
    /// USART1 is 0.
    pub usart: usize,
    /// The data bits.
    pub data: u16,
    /// HCLK cycles of a bit.
    pub bit: u64,
}

/// One interface.
#[derive(Clone, Debug)]
pub struct Usart {
    sr: u32,
    brr: u32,
    cr1: u32,
    cr2: u32,
    cr3: u32,
    gtpr: u32,
    /// The received word, and the one that waits to be sent.
    rdr: u32,
    tdr: u32,
    /// Error and idle flags that a load of SR has shown.
    shown: u32,
    /// End and content of the word that is being sent.
    sending: Option<(u64, u32)>,
    /// What the other end still sends: bits per second and data.
    incoming: VecDeque<(u32, u8)>,
    /// End and content of the word that arrives, and whether its stop bit is seen.
    receiving: Option<(u64, u32, bool)>,
    /// When the line will have been idle for a word.
    idle_at: Option<u64>,
    /// HCLK cycles per PCLK cycle, and PCLK in Hz.
    divider: u64,
    pclk: u64,
    routed: [bool; 2],
    sent: Vec<(u64, u32, u64)>,
}

impl Default for Usart {
    fn default() -> Self {
        Usart {
            sr: TC | TXE,
            brr: 0,
            cr1: 0,
            cr2: 0,
            cr3: 0,
            gtpr: 0,
            rdr: 0,
            tdr: 0,
            shown: 0,
            sending: None,
            incoming: VecDeque::new(),
            receiving: None,
            idle_at: None,
            divider: 1,
            pclk: 16_000_000,
            routed: [false; 2],
            sent: Vec::new(),
        }
    }
}

impl Usart {
    /// RCC or a system reset. The other end goes on.
    pub fn reset(&mut self) {
        let (divider, pclk) = (self.divider, self.pclk);
        let (incoming, sent) = (std::mem::take(&mut self.incoming), std::mem::take(&mut self.sent));
        *self = Usart { divider, pclk, incoming, sent, ..Usart::default() };
    }

    /// Whether it takes part in anything.
    pub fn is_enabled(&self) -> bool {
        self.cr1 & UE != 0
    }

    /// The clock tree changed: `divider` HCLK cycles per PCLK cycle of `pclk` Hz.
    pub fn set_clock(&mut self, divider: u64, pclk: u64) {
        (self.divider, self.pclk) = (divider, pclk);
    }

    /// Whether TX and RX reach pins.
    pub fn set_pins(&mut self, cycle: u64, routed: [bool; 2]) {
        self.routed = routed;
        self.listen(cycle);
    }

    /// The other end sends `bytes`, one after the other, at `baud`.
    pub fn put(&mut self, cycle: u64, baud: u32, bytes: &[u8]) {
        self.incoming.extend(bytes.iter().map(|byte| (baud, *byte)));
        self.listen(cycle);
    }

    /// Whether [`Usart::take_sent`] has anything to give.
    pub fn has_sent(&self) -> bool {
        !self.sent.is_empty()
    }

    /// Words sent since the last call: cycle of the end, data, cycles of a bit.
    pub fn take_sent(&mut self) -> Vec<(u64, u32, u64)> {
        std::mem::take(&mut self.sent)
    }

    /// HCLK cycles of a bit: BRR is the divider in 1/16, or in 1/8 without bit 3 (RM0090 30.3.4).
    fn bit(&self) -> u64 {
        let ticks = if self.cr1 & OVER8 != 0 { self.brr >> 4 << 3 | self.brr & 0b111 } else { self.brr };
        self.divider * u64::from(ticks.max(1))
    }

    /// Bits of data, without parity.
    fn data_bits(&self) -> u32 {
        8 + u32::from(self.cr1 & M != 0) - u32::from(self.cr1 & PCE != 0)
    }

    /// Cycles of a word: start bit, data, parity, stop bits.
    fn word(&self) -> u64 {
        let halves = [2, 1, 4, 3][((self.cr2 & STOP) >> 12) as usize];
        self.bit() * (1 + 8 + u64::from(self.cr1 & M != 0)) + self.bit() * halves / 2
    }

    fn with_parity(&self, data: u32) -> u32 {
        let bits = self.data_bits();
        let data = data & ((1 << bits) - 1);
        let odd = data.count_ones() & 1 == 1;
        if self.cr1 & PCE == 0 { data } else { data | u32::from(odd != (self.cr1 & PS != 0)) << bits }
    }

    /// When something next ends.
    pub fn next_event(&self) -> Option<u64> {
        let words = [self.sending.map(|(end, _)| end), self.receiving.map(|(end, ..)| end), self.idle_at];
        words.into_iter().flatten().min()
    }

    /// Does what happened until `cycle`.
    pub fn catch_up(&mut self, cycle: u64) {
        while let Some(end) = self.next_event().filter(|end| *end <= cycle) {
            if let Some((_, word)) = self.sending.take_if(|(at, _)| *at == end) {
                if self.routed[0] {
                    self.sent.push((end, word & ((1 << self.data_bits()) - 1), self.bit()));
                }
                if self.sr & TXE == 0 { self.start(end) } else { self.sr |= TC }
            }
            if let Some((_, word, is_whole)) = self.receiving.take_if(|(at, ..)| *at == end) {
                self.receive(end, word, is_whole);
            }
            if self.idle_at.take_if(|at| *at == end).is_some() {
                self.sr |= IDLE;
            }
        }
    }

    /// A word goes from DR to the shift register.
    fn start(&mut self, cycle: u64) {
        self.sr |= TXE;
        self.sending = Some((cycle + self.word(), self.with_parity(self.tdr)));
    }

    /// The next start bit of the other end.
    fn listen(&mut self, cycle: u64) {
        let hears = self.cr1 & (UE | RE) == UE | RE && self.routed[1];
        if !hears || self.receiving.is_some() {
            return;
        }
        let Some((baud, byte)) = self.incoming.pop_front() else { return };
        self.idle_at = None;
        let own = self.pclk as f64 * self.divider as f64 / self.bit() as f64;
        let fits = (f64::from(baud) / own - 1.0).abs() <= TOLERANCE;
        // Sampled at a wrong rate a word is garbage without stop bit.
        let word = if fits { self.with_parity(u32::from(byte)) } else { u32::from(!byte) };
        self.receiving = Some((cycle + self.word(), word, fits));
    }

    fn receive(&mut self, cycle: u64, word: u32, is_whole: bool) {
        if self.sr & RXNE != 0 {
            self.sr |= ORE;
        } else {
            self.rdr = word;
            self.sr |= RXNE | if is_whole { 0 } else { FE };
        }
        self.idle_at = Some(cycle + self.word());
        self.listen(cycle);
    }

    /// The interrupt line.
    pub fn irq(&self) -> bool {
        // IDLEIE to TXEIE stand where IDLE to TXE do; RXNEIE stands for ORE as well.
        let same = self.sr & self.cr1 & (IDLE | RXNE | TC | TXE) != 0;
        let overrun = self.sr & ORE != 0 && self.cr1 & RXNE != 0;
        let parity = self.sr & PE != 0 && self.cr1 & PEIE != 0;
        let errors = self.sr & (FE | NF | ORE) != 0 && self.cr3 & (EIE | DMAR) == EIE | DMAR;
        same || overrun || parity || errors
    }

    /// Whether it asks for a word to send by DMA.
    pub fn asks_to_send(&self) -> bool {
        self.cr3 & DMAT != 0 && self.sr & TXE != 0 && self.cr1 & (UE | TE) == UE | TE
    }

    /// Whether a received word waits for DMA.
    pub fn asks_to_receive(&self) -> bool {
        self.cr3 & DMAR != 0 && self.sr & RXNE != 0
    }

    /// A load.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what does not exist.
    pub fn read(&mut self, cycle: u64, offset: u32) -> Result<u32, Refusal> {
        self.catch_up(cycle);
        Ok(match offset {
            SR => {
                self.shown = self.sr & (SEQUENCE | TC);
                self.sr
            }
            DR => {
                self.sr &= !(RXNE | self.shown & SEQUENCE);
                self.shown &= !SEQUENCE;
                self.rdr
            }
            BRR => self.brr,
            CR1 => self.cr1,
            CR2 => self.cr2,
            CR3 => self.cr3,
            GTPR => self.gtpr,
            _ => return Err(Refusal::Unmodelled),
        })
    }

    /// A store.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what is not modelled, [`Refusal::Misuse`] for a divider below the oversampling.
    pub fn write(&mut self, cycle: u64, offset: u32, value: u32) -> Result<(), Refusal> {
        self.catch_up(cycle);
        let value = value & 0xFFFF;
        let lacking = match offset {
            CR1 => value & CR1_LACKING,
            CR2 => value & !CR2_MODELLED,
            CR3 => value & !CR3_MODELLED,
            GTPR => value,
            _ => 0,
        };
        if lacking != 0 {
            return Err(Refusal::Unmodelled);
        }
        match offset {
            // TC and RXNE clear by writing 0.
            SR => self.sr &= value | !(TC | RXNE),
            DR => {
                self.sr &= !(TXE | self.shown & TC);
                self.shown &= !TC;
                self.tdr = value & 0x1FF;
                self.send(cycle);
            }
            BRR => self.brr = value,
            CR1 => {
                let least = if value & OVER8 != 0 { 8 } else { 16 };
                self.cr1 = value;
                if value & UE != 0 && value & (RE | TE) != 0 && self.bit() / self.divider < least {
                    return Err(Refusal::Misuse);
                }
                if value & UE == 0 {
                    (self.sending, self.receiving, self.idle_at) = (None, None, None);
                    self.sr |= TC | TXE;
                }
                self.send(cycle);
                self.listen(cycle);
            }
            CR2 => self.cr2 = value,
            CR3 => self.cr3 = value,
            GTPR => self.gtpr = value,
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    /// Starts to send what waits in DR.
    fn send(&mut self, cycle: u64) {
        if self.cr1 & (UE | TE) == UE | TE && self.sr & TXE == 0 && self.sending.is_none() {
            self.sr &= !TC;
            self.start(cycle);
        }
    }
}
