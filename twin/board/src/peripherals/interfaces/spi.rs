//! SPI1 to SPI3 as masters.
//!
//! RM0090 chapter 28, RM0390 chapter 26. Modelled: full duplex, 8 and 16 bits, both bit orders, all clock modes, the speed by
//! BR, TXE, RXNE, BSY, OVR and MODF, interrupts, DMA requests. Not modelled, and refused: slave mode, one data line, reception
//! alone, CRC, the TI frame format, I2S.

use crate::devices::{SpiDevice, SpiMode};
use crate::mmio::Refusal;
use crate::pin::Pin;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SR: u32 = 0x08;
const DR: u32 = 0x0C;
const CRCPR: u32 = 0x10;
const RXCRCR: u32 = 0x14;
const TXCRCR: u32 = 0x18;
const I2SCFGR: u32 = 0x1C;
const I2SPR: u32 = 0x20;

/// CR1.
const CPHA: u32 = 1 << 0;
const CPOL: u32 = 1 << 1;
const MSTR: u32 = 1 << 2;
const SPE: u32 = 1 << 6;
const LSBFIRST: u32 = 1 << 7;
const SSI: u32 = 1 << 8;
const SSM: u32 = 1 << 9;
const DFF: u32 = 1 << 11;
/// RXONLY, CRCNEXT, CRCEN, BIDIMODE.
const CR1_LACKING: u32 = 1 << 10 | 1 << 12 | 1 << 13 | 1 << 15;
/// CR2.
const RXDMAEN: u32 = 1 << 0;
const TXDMAEN: u32 = 1 << 1;
const SSOE: u32 = 1 << 2;
const ERRIE: u32 = 1 << 5;
const RXNEIE: u32 = 1 << 6;
const TXEIE: u32 = 1 << 7;
const CR2_MODELLED: u32 = RXDMAEN | TXDMAEN | SSOE | ERRIE | RXNEIE | TXEIE;
/// SR.
const RXNE: u32 = 1 << 0;
const TXE: u32 = 1 << 1;
const MODF: u32 = 1 << 5;
const OVR: u32 = 1 << 6;
const BSY: u32 = 1 << 7;

/// A device and its chip select; `None` for one that is always selected.
#[derive(Clone, Debug)]
struct Attached {
    device: Box<dyn SpiDevice>,
    select: Option<Pin>,
    is_selected: bool,
}

/// One interface with its devices.
#[derive(Clone, Debug)]
pub struct Spi {
    cr1: u32,
    cr2: u32,
    sr: u32,
    i2spr: u32,
    crcpr: u32,
    rdr: u32,
    tdr: u32,
    /// OVR was shown by a load of DR: the load of SR that follows clears it.
    overrun_read: bool,
    shown: u32,
    /// End and content of the word that is being sent.
    sending: Option<(u64, u32)>,
    divider: u64,
    routed: bool,
    devices: Vec<Attached>,
}

impl Default for Spi {
    fn default() -> Self {
        Spi {
            cr1: 0,
            cr2: 0,
            sr: TXE,
            i2spr: 2,
            crcpr: 7,
            rdr: 0,
            tdr: 0,
            overrun_read: false,
            shown: 0,
            sending: None,
            divider: 1,
            routed: false,
            devices: Vec::new(),
        }
    }
}

impl Spi {
    /// RCC or a system reset.
    pub fn reset(&mut self) {
        let devices = std::mem::take(&mut self.devices);
        *self = Spi { divider: self.divider, devices, ..Spi::default() };
    }

    /// Whether it takes part in anything.
    pub fn is_enabled(&self) -> bool {
        self.cr1 & SPE != 0
    }

    /// Wires a device; `select` is its chip select, active low.
    pub fn attach(&mut self, device: Box<dyn SpiDevice>, select: Option<Pin>) {
        self.devices.push(Attached { device, select, is_selected: select.is_none() });
    }

    /// Whether any device hangs on it.
    pub fn has_devices(&self) -> bool {
        !self.devices.is_empty()
    }

    /// The clock tree changed: `divider` HCLK cycles per PCLK cycle.
    pub fn set_clock(&mut self, divider: u64) {
        self.divider = divider;
    }

    /// Whether SCK and MOSI reach pins, and which chip selects are low.
    pub fn set_pins(&mut self, routed: bool, level: impl Fn(Pin) -> bool) {
        self.routed = routed;
        for Attached { device, select, is_selected } in &mut self.devices {
            let selected = select.is_none_or(|pin| !level(pin));
            if selected != *is_selected {
                *is_selected = selected;
                device.select(selected);
            }
        }
    }

    fn bits(&self) -> u32 {
        if self.cr1 & DFF != 0 { 16 } else { 8 }
    }

    fn start(&mut self, cycle: u64) {
        // SCK is PCLK over 2, 4, ... 256.
        let bit = self.divider << ((self.cr1 >> 3 & 0b111) + 1);
        self.sr |= TXE;
        self.sending = Some((cycle + bit * u64::from(self.bits()), self.tdr));
    }

    /// When the word under way ends.
    pub fn next_event(&self) -> Option<u64> {
        self.sending.map(|(end, _)| end)
    }

    /// Does what happened until `cycle`.
    pub fn catch_up(&mut self, cycle: u64) {
        while let Some((end, word)) = self.sending.take_if(|(end, _)| *end <= cycle) {
            let answer = self.exchange(word);
            if self.sr & RXNE != 0 {
                self.sr |= OVR;
            } else {
                self.rdr = answer;
                self.sr |= RXNE;
            }
            if self.sr & TXE == 0 {
                self.start(end);
            }
        }
    }

    /// What the selected devices answer. A line that nobody drives reads high.
    fn exchange(&mut self, word: u32) -> u32 {
        let bits = self.bits();
        let as_sent = |word: u32, is_reversed: bool| match is_reversed {
            true => word.reverse_bits() >> (32 - bits),
            false => word,
        };
        let is_reversed = self.cr1 & LSBFIRST != 0;
        let all_ones = (1 << bits) - 1;
        if !self.routed {
            return all_ones;
        }
        let mode = SpiMode { idles_high: self.cr1 & CPOL != 0, second_edge: self.cr1 & CPHA != 0 };
        let sent = as_sent(word, is_reversed);
        let selected = self.devices.iter_mut().filter(|attached| attached.is_selected);
        let answer = selected.fold(all_ones, |line, Attached { device, .. }| {
            line & device.transfer(mode, bits, sent as u16) as u32
        });
        as_sent(answer, is_reversed)
    }

    /// The interrupt line.
    pub fn irq(&self) -> bool {
        let on = |enable: u32, flags: u32| self.cr2 & enable != 0 && self.sr & flags != 0;
        on(TXEIE, TXE) || on(RXNEIE, RXNE) || on(ERRIE, OVR | MODF)
    }

    /// Whether it asks for a word to send by DMA.
    pub fn asks_to_send(&self) -> bool {
        self.cr2 & TXDMAEN != 0 && self.sr & TXE != 0 && self.is_enabled()
    }

    /// Whether a received word waits for DMA.
    pub fn asks_to_receive(&self) -> bool {
        self.cr2 & RXDMAEN != 0 && self.sr & RXNE != 0
    }

    /// A load.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what does not exist.
    pub fn read(&mut self, cycle: u64, offset: u32) -> Result<u32, Refusal> {
        self.catch_up(cycle);
        Ok(match offset {
            CR1 => self.cr1,
            CR2 => self.cr2,
            SR => {
                let value = self.sr | if self.sending.is_some() { BSY } else { 0 };
                // OVR clears by a load of DR and one of SR (RM0090 28.3.10).
                if std::mem::take(&mut self.overrun_read) {
                    self.sr &= !OVR;
                }
                self.shown = value;
                value
            }
            DR => {
                self.overrun_read = self.sr & OVR != 0;
                self.sr &= !RXNE;
                self.rdr
            }
            CRCPR => self.crcpr,
            RXCRCR | TXCRCR | I2SCFGR => 0,
            I2SPR => self.i2spr,
            _ => return Err(Refusal::Unmodelled),
        })
    }

    /// A store.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what is not modelled.
    pub fn write(&mut self, cycle: u64, offset: u32, value: u32) -> Result<(), Refusal> {
        self.catch_up(cycle);
        let value = value & 0xFFFF;
        match offset {
            CR1 if value & CR1_LACKING != 0 || value & (SPE | MSTR) == SPE => {
                return Err(Refusal::Unmodelled);
            }
            CR1 => self.control(cycle, value),
            CR2 if value & !CR2_MODELLED != 0 => return Err(Refusal::Unmodelled),
            CR2 => self.cr2 = value,
            // CRCERR clears by writing 0, and never sets.
            SR => {}
            DR => {
                self.tdr = if self.cr1 & DFF != 0 { value } else { value & 0xFF };
                self.sr &= !TXE;
                if self.is_enabled() && self.sending.is_none() {
                    self.start(cycle);
                }
            }
            CRCPR => self.crcpr = value,
            RXCRCR | TXCRCR => {}
            I2SCFGR if value & 1 << 11 != 0 => return Err(Refusal::Unmodelled),
            I2SCFGR => {}
            I2SPR => self.i2spr = value & 0x3FF,
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    fn control(&mut self, cycle: u64, value: u32) {
        // MODF clears by a load of SR and a store to CR1.
        if self.shown & MODF != 0 {
            self.sr &= !MODF;
        }
        self.cr1 = value;
        // A master whose NSS is low falls out of master mode (RM0090 28.3.10).
        if value & (SPE | SSM | SSI) == SPE | SSM {
            self.sr |= MODF;
            self.cr1 &= !(SPE | MSTR);
        }
        if !self.is_enabled() {
            self.sending = None;
        } else if self.sr & TXE == 0 && self.sending.is_none() {
            self.start(cycle);
        }
    }
}
