//! DMA1 and DMA2: eight streams each that move data on request of peripherals, from peripheral to memory or back.
//!
//! RM0090 chapter 10. Modelled: direct mode, circular and single buffers, priorities, half and complete flags, transfer
//! errors, disabling under way, interrupts. Not modelled, and refused when a stream is enabled: FIFO mode, bursts, double
//! buffers, transfers between memories, the peripheral as flow controller. A transfer takes no time. A stream whose request no modelled peripheral raises waits for ever.

use crate::mmio::Refusal;

pub(super) const LISR: u32 = 0x00;
pub(super) const HISR: u32 = 0x04;
const LIFCR: u32 = 0x08;
const HIFCR: u32 = 0x0C;
pub(super) const FIRST_STREAM: u32 = 0x10;
pub(super) const STREAM_LEN: u32 = 0x18;
pub(super) const LAST: u32 = FIRST_STREAM + 8 * STREAM_LEN - 1;
/// Registers of a stream.
pub(super) const CR: u32 = 0x00;
pub(super) const NDTR: u32 = 0x04;
pub(super) const PAR: u32 = 0x08;
pub(super) const M0AR: u32 = 0x0C;
pub(super) const M1AR: u32 = 0x10;
pub(super) const FCR: u32 = 0x14;

const EN: u32 = 1 << 0;
/// DMEIE, TEIE, HTIE, TCIE.
const INTERRUPTS: u32 = 0xF << 1;
const PFCTRL: u32 = 1 << 5;
/// DIR: from memory, and between memories.
const FROM_MEMORY: u32 = 1 << 6;
const BETWEEN_MEMORIES: u32 = 1 << 7;
const CIRC: u32 = 1 << 8;
const PINC: u32 = 1 << 9;
const MINC: u32 = 1 << 10;
const MSIZE: u32 = 0b11 << 13;
const DBM: u32 = 1 << 18;
const BURSTS: u32 = 0xF << 21;
pub(super) const CR_BITS: u32 = 0x0FEF_FFFF;
/// Modes of CR that are not modelled.
const LACKING: u32 = PFCTRL | DBM | BURSTS | PINC | BETWEEN_MEMORIES;
const DMDIS: u32 = 1 << 2;
const FEIE: u32 = 1 << 7;
const FIFO_EMPTY: u32 = 0b100 << 3;

/// Flags of one stream: FEIF, DMEIF, TEIF, HTIF, TCIF.
const TEIF: u32 = 1 << 3;
const HTIF: u32 = 1 << 4;
const TCIF: u32 = 1 << 5;
pub(super) const FLAGS: u32 = 0b11_1101;
/// Position of the flags of streams 0 to 3 in LISR, and of 4 to 7 in HISR.
pub(super) const FLAG_SHIFT: [u32; 4] = [0, 6, 16, 22];

/// NVIC inputs of the streams of DMA1 and DMA2 (RM0090 table 61).
const IRQS: [[u16; 8]; 2] = [[11, 12, 13, 14, 15, 16, 17, 47], [56, 57, 58, 59, 60, 68, 69, 70]];

/// One stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stream {
    pub(super) cr: u32,
    pub(super) ndtr: u32,
    pub(super) par: u32,
    pub(super) m0ar: u32,
    pub(super) m1ar: u32,
    pub(super) fcr: u32,
    pub(super) flags: u32,
    /// NDTR as written, for circular mode.
    reload: u32,
    /// Items since the buffer's start.
    done: u32,
}

impl Stream {
    const RESET: Stream =
        Stream { cr: 0, ndtr: 0, par: 0, m0ar: 0, m1ar: 0, fcr: 0x01, flags: 0, reload: 0, done: 0 };

    /// Forgets the registers of a stream that is off and has no flags: they have no effect.
    pub(super) fn forget(&mut self) {
        if !self.is_enabled() && self.flags == 0 {
            *self = Stream::RESET;
        }
    }

    fn is_enabled(&self) -> bool {
        self.cr & EN != 0
    }

    /// PSIZE; in direct mode it is the size at both ends.
    fn bytes(&self) -> u32 {
        1 << (self.cr >> 11 & 0b11)
    }

    fn irq(&self) -> bool {
        // DMEIE to TCIE are one bit below their flags.
        self.flags & (self.cr & INTERRUPTS) << 1 != 0 || self.flags & 1 != 0 && self.fcr & FEIE != 0
    }

    /// PL: 0 is low, 3 is very high.
    fn priority(&self) -> u32 {
        self.cr >> 16 & 0b11
    }

    /// Returns whether the model has the mode of an enabled stream.
    pub(super) fn is_modelled(&self) -> bool {
        let is_lacking = self.cr & LACKING != 0 || self.fcr & DMDIS != 0 || self.bytes() == 8;
        !(self.is_enabled() && is_lacking)
    }

    fn enable(&mut self) -> Result<(), Refusal> {
        if self.cr & LACKING != 0 || self.fcr & DMDIS != 0 {
            return Err(Refusal::Unmodelled);
        }
        // RM0090 10.3.17: all flags of the stream are cleared before; addresses fit the size; 11b is no size.
        if self.flags != 0 || self.bytes() == 8 || (self.par | self.m0ar) & (self.bytes() - 1) != 0 {
            return Err(Refusal::Misuse);
        }
        // Direct mode: hardware makes MSIZE equal to PSIZE (RM0090 10.5.5).
        self.cr = self.cr & !MSIZE | self.cr >> 11 << 13 & MSIZE | EN;
        self.done = 0;
        Ok(())
    }

    fn write_cr(&mut self, value: u32) -> Result<(), Refusal> {
        let value = value & CR_BITS;
        if !self.is_enabled() {
            self.cr = value & !EN;
            return if value & EN != 0 { self.enable() } else { Ok(()) };
        }
        // Everything else is protected while the stream runs.
        self.cr = self.cr & !INTERRUPTS | value & INTERRUPTS;
        if value & EN == 0 {
            // RM0090 10.3.14: the end of a stopped transfer sets the flags like any other end.
            self.cr &= !EN;
            self.flags |= TCIF;
        }
        Ok(())
    }

    fn write(&mut self, register: u32, value: u32) -> Result<(), Refusal> {
        match register {
            CR => return self.write_cr(value),
            // Protected while the stream runs.
            NDTR | PAR | M0AR | M1AR if self.is_enabled() => {}
            NDTR => (self.ndtr, self.reload) = (value & 0xFFFF, value & 0xFFFF),
            PAR => self.par = value,
            M0AR => self.m0ar = value,
            M1AR => self.m1ar = value,
            FCR if self.is_enabled() => self.fcr = self.fcr & !FEIE | value & FEIE,
            FCR => self.fcr = value & (FEIE | DMDIS | 0b11),
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    fn read(&self, register: u32) -> Result<u32, Refusal> {
        Ok(match register {
            CR => self.cr,
            NDTR => self.ndtr,
            PAR => self.par,
            M0AR => self.m0ar,
            M1AR => self.m1ar,
            FCR => self.fcr | FIFO_EMPTY,
            _ => return Err(Refusal::Unmodelled),
        })
    }
}

/// Next transfer of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// Stream of the transfer.
    pub stream: usize,
    /// Address of the peripheral's register, or of the memory to copy from.
    pub peripheral: u32,
    /// Address in memory.
    pub memory: u32,
    /// Size of the item in bytes: 1, 2 or 4.
    pub bytes: u32,
    /// True for a transfer from memory to the peripheral.
    pub from_memory: bool,
}

/// The controller.
#[derive(Clone, Debug)]
pub struct Dma {
    pub(super) streams: [Stream; 8],
    controller: usize,
    /// A bit for each stream that is enabled.
    enabled: u8,
}

impl Dma {
    /// Makes a controller after a reset; 0 is DMA1, 1 is DMA2.
    pub fn new(controller: usize) -> Self {
        Dma { streams: [Stream::RESET; 8], controller, enabled: 0 }
    }

    /// Resets the controller, by RCC or a system reset.
    pub fn reset(&mut self) {
        *self = Dma::new(self.controller);
    }

    /// Updates the state after a change of a stream.
    pub(super) fn follow(&mut self, stream: usize) {
        let bit = 1 << stream;
        self.enabled = self.enabled & !bit | if self.streams[stream].is_enabled() { bit } else { 0 };
    }

    /// A load.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what does not exist.
    pub fn read(&self, offset: u32) -> Result<u32, Refusal> {
        let flags =
            |first: usize| (0..4).fold(0, |isr, n| isr | self.streams[first + n].flags << FLAG_SHIFT[n]);
        match offset {
            LISR => Ok(flags(0)),
            HISR => Ok(flags(4)),
            LIFCR | HIFCR => Ok(0),
            FIRST_STREAM..=LAST => self.streams[index(offset)].read((offset - FIRST_STREAM) % STREAM_LEN),
            _ => Err(Refusal::Unmodelled),
        }
    }

    /// A store.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for a register that does not exist and a transfer that is not modelled,
    /// [`Refusal::Misuse`] for one that the manual forbids.
    pub fn write(&mut self, offset: u32, value: u32) -> Result<(), Refusal> {
        match offset {
            LISR | HISR => Ok(()),
            LIFCR | HIFCR => {
                let first = if offset == LIFCR { 0 } else { 4 };
                for (stream, shift) in self.streams[first..].iter_mut().zip(FLAG_SHIFT) {
                    stream.flags &= !(value >> shift & FLAGS);
                }
                Ok(())
            }
            FIRST_STREAM..=LAST => {
                let register = (offset - FIRST_STREAM) % STREAM_LEN;
                let result = self.streams[index(offset)].write(register, value);
                self.follow(index(offset));
                result
            }
            _ => Err(Refusal::Unmodelled),
        }
    }

    /// Returns the next transfer: of the streams for which `asks(stream, channel)` returns a request, the one with the
    /// highest priority, then the lowest number (RM0090 10.3.5).
    pub fn next(&self, asks: impl Fn(usize, u32) -> bool) -> Option<Transfer> {
        let mut first: Option<(usize, &Stream)> = None;
        let mut rest = self.enabled;
        while rest != 0 {
            let n = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let stream = &self.streams[n];
            if stream.ndtr == 0 {
                continue;
            }
            if asks(n, self.channel(n)) && first.is_none_or(|(_, other)| stream.priority() > other.priority())
            {
                first = Some((n, stream));
            }
        }
        let (n, stream) = first?;
        let offset = if stream.cr & MINC != 0 { stream.done * stream.bytes() } else { 0 };
        Some(Transfer {
            stream: n,
            peripheral: stream.par,
            memory: stream.m0ar.wrapping_add(offset),
            bytes: stream.bytes(),
            from_memory: stream.cr & FROM_MEMORY != 0,
        })
    }

    /// CHSEL of a stream.
    pub fn channel(&self, stream: usize) -> u32 {
        self.streams[stream].cr >> 25 & 0b111
    }

    /// Completes an item of a stream. Returns how many are left.
    pub fn done(&mut self, number: usize) -> u32 {
        let stream = &mut self.streams[number];
        stream.done += 1;
        stream.ndtr -= 1;
        if stream.ndtr == stream.reload / 2 && stream.ndtr != 0 {
            stream.flags |= HTIF;
        }
        let left = stream.ndtr;
        if left == 0 {
            stream.flags |= TCIF;
            if stream.cr & CIRC != 0 {
                stream.ndtr = stream.reload;
                stream.done = 0;
            } else {
                stream.cr &= !EN;
            }
        }
        self.follow(number);
        left
    }

    /// Stops a stream after a bus error.
    pub fn failed(&mut self, stream: usize) {
        self.streams[stream].flags |= TEIF;
        self.streams[stream].cr &= !EN;
        self.follow(stream);
    }

    /// Calls `raise` for each NVIC line that is high.
    pub fn irqs(&self, mut raise: impl FnMut(u16)) {
        for (stream, irq) in self.streams.iter().zip(IRQS[self.controller]) {
            if stream.irq() {
                raise(irq);
            }
        }
    }
}

const fn index(offset: u32) -> usize {
    ((offset - FIRST_STREAM) / STREAM_LEN) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    const S2: u32 = 0x40;
    const S4: u32 = 0x70;
    const CHANNEL_6: u32 = 6 << 25;
    const WORDS: u32 = 2 << 11 | 2 << 13;

    fn set_up(dma: &mut Dma, stream: u32, len: u32, cr: u32) {
        for (register, value) in [(PAR, 0x4000_0C34), (M0AR, 0x2000_0100), (NDTR, len), (CR, cr)] {
            dma.write(stream + register, value).unwrap();
        }
        dma.write(stream + CR, cr | EN).unwrap();
    }

    fn ring(len: u32) -> Dma {
        let mut dma = Dma::new(0);
        set_up(&mut dma, S2, len, CHANNEL_6 | WORDS | MINC | CIRC);
        dma
    }

    /// Serves `count` requests of any stream. Returns their addresses in memory.
    fn served(dma: &mut Dma, count: usize) -> Vec<u32> {
        (0..count)
            .map_while(|_| {
                let transfer = dma.next(|_, channel| channel == 6)?;
                dma.done(transfer.stream);
                Some(transfer.memory)
            })
            .collect()
    }

    #[test]
    fn registers_reset_as_the_manual_says() {
        let dma = Dma::new(0);
        for offset in (0..0x10).step_by(4) {
            assert_eq!(dma.read(offset), Ok(0));
        }
        let stream = |register| dma.read(0x10 + 7 * 0x18 + register);
        assert_eq!([CR, NDTR, PAR, M0AR, M1AR].map(stream), [Ok(0); 5]);
        assert_eq!(stream(FCR), Ok(0x21));
        assert_eq!(dma.read(0xD0), Err(Refusal::Unmodelled));
    }

    #[test]
    fn a_ring_starts_again_where_it_began() {
        let mut dma = ring(4);
        let expected = [0x2000_0100, 0x2000_0104, 0x2000_0108, 0x2000_010C, 0x2000_0100];
        assert_eq!(served(&mut dma, 5), expected);
        assert_eq!(dma.read(S2 + NDTR), Ok(3));
    }

    /// RM0090 10.5.1: HTIF2 is bit 20, TCIF2 bit 21 of LISR; cleared through the same bits of LIFCR.
    #[test]
    fn half_and_complete_show_and_clear_in_their_places() {
        let mut dma = ring(4);
        served(&mut dma, 1);
        assert_eq!(dma.read(LISR), Ok(0));
        served(&mut dma, 1);
        assert_eq!(dma.read(LISR), Ok(1 << 20));
        served(&mut dma, 2);
        assert_eq!(dma.read(LISR), Ok(3 << 20));
        dma.write(LIFCR, 1 << 20).unwrap();
        assert_eq!(dma.read(LISR), Ok(1 << 21));
        dma.write(HIFCR, u32::MAX).unwrap();
        assert_eq!(dma.read(LISR), Ok(1 << 21));
    }

    #[test]
    fn flags_raise_the_line_of_their_stream_where_enabled() {
        let mut dma = ring(2);
        let line = |dma: &Dma| {
            let mut raised = Vec::new();
            dma.irqs(|irq| raised.push(irq));
            raised
        };
        served(&mut dma, 2);
        assert_eq!(line(&dma), [0_u16; 0]);
        // HTIE and TCIE may change while it runs; CHSEL may not.
        dma.write(S2 + CR, EN | 1 << 4).unwrap();
        assert_eq!(line(&dma), [13]);
        assert_eq!(dma.read(S2 + CR), Ok(CHANNEL_6 | WORDS | MINC | CIRC | EN | 1 << 4));
        dma.write(LIFCR, 1 << 21).unwrap();
        assert_eq!(line(&dma), [0_u16; 0]);
    }

    #[test]
    fn a_single_buffer_ends_with_the_stream_disabled() {
        let mut dma = Dma::new(0);
        set_up(&mut dma, S4, 3, CHANNEL_6 | WORDS | MINC);
        assert_eq!(served(&mut dma, 9).len(), 3);
        assert_eq!((dma.read(S4 + CR).unwrap() & EN, dma.read(S4 + NDTR)), (0, Ok(0)));
        // Stream 4: HTIF4 is bit 4, TCIF4 bit 5 of HISR.
        assert_eq!(dma.read(HISR), Ok(1 << 4 | 1 << 5));
    }

    #[test]
    fn stream_disabled_in_progress_keeps_count_and_shows_complete() {
        let mut dma = ring(8);
        served(&mut dma, 3);
        dma.write(S2 + CR, 0).unwrap();
        assert_eq!(served(&mut dma, 1), [0_u32; 0]);
        assert_eq!((dma.read(S2 + NDTR), dma.read(LISR)), (Ok(5), Ok(1 << 21)));
    }

    #[test]
    fn a_stream_with_flags_left_does_not_start() {
        let mut dma = ring(8);
        dma.write(S2 + CR, CHANNEL_6 | WORDS).unwrap();
        assert_eq!(dma.write(S2 + CR, CHANNEL_6 | WORDS | EN), Err(Refusal::Misuse));
        dma.write(LIFCR, 0x3D << 16).unwrap();
        assert_eq!(dma.write(S2 + CR, CHANNEL_6 | WORDS | EN), Ok(()));
    }

    #[test]
    fn priority_goes_before_the_number_of_the_stream() {
        let mut dma = Dma::new(0);
        set_up(&mut dma, S2, 4, CHANNEL_6 | WORDS | MINC);
        set_up(&mut dma, S4, 4, CHANNEL_6 | WORDS | MINC | 1 << 16);
        assert_eq!(dma.next(|_, _| true).map(|t| t.stream), Some(4));
        dma.write(S4 + CR, 0).unwrap();
        assert_eq!(dma.next(|_, _| true).map(|t| t.stream), Some(2));
    }

    #[test]
    fn a_running_streams_addresses_are_protected() {
        let mut dma = ring(4);
        dma.write(S2 + M0AR, 0x2000_2000).unwrap();
        dma.write(S2 + NDTR, 1).unwrap();
        assert_eq!((dma.read(S2 + M0AR), dma.read(S2 + NDTR)), (Ok(0x2000_0100), Ok(4)));
    }

    #[test]
    fn what_is_not_modelled_is_refused_at_the_start() {
        for bits in [1 << 5, 3 << 6, 1 << 9, 1 << 18, 1 << 21, 1 << 23] {
            let mut dma = Dma::new(0);
            dma.write(S2 + CR, bits).unwrap();
            assert_eq!(dma.write(S2 + CR, bits | EN), Err(Refusal::Unmodelled), "{bits:X}h");
        }
        let mut dma = Dma::new(0);
        dma.write(S2 + FCR, DMDIS).unwrap();
        assert_eq!(dma.write(S2 + CR, EN), Err(Refusal::Unmodelled));
    }

    #[test]
    fn an_address_that_does_not_fit_its_size_is_refused() {
        let mut dma = Dma::new(0);
        dma.write(S2 + M0AR, 0x2000_0002).unwrap();
        assert_eq!(dma.write(S2 + CR, WORDS | EN), Err(Refusal::Misuse));
    }

    #[test]
    fn a_bus_error_stops_the_stream() {
        let mut dma = ring(4);
        dma.failed(2);
        assert_eq!((dma.read(S2 + CR).unwrap() & EN, dma.read(LISR)), (0, Ok(1 << 19)));
    }
}
