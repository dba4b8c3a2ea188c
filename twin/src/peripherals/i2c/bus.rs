//! I2C1 to I2C3 as bus masters.
//!
//! RM0090 chapter 27, RM0390 chapter 24. Modelled: START, repeated START and STOP, 7-bit addresses, transmission and
//! reception with their double buffer, acknowledgement with POS and LAST, SB, ADDR, BTF, RXNE, TXE, AF and BUSY with
//! the sequences that clear them, clock stretching, the speed by CCR, interrupts, DMA requests, software reset. Not
//! modelled, and refused: SMBus and packet error checking, 10-bit addresses. It is never addressed as a slave. A second
//! master, bus errors and SDA held low by a device do not occur. START and STOP take half a period each.
//!
//! Without a device there is no pull-up: the lines stay low unless the program has enabled the pull-ups of the chip,
//! the bus is busy, and a START waits for ever.

use crate::devices::I2cDevice;
use crate::mmio::Refusal;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const OAR1: u32 = 0x08;
const OAR2: u32 = 0x0C;
const DR: u32 = 0x10;
const SR1: u32 = 0x14;
const SR2: u32 = 0x18;
const CCR: u32 = 0x1C;
const TRISE: u32 = 0x20;
const FLTR: u32 = 0x24;

/// CR1.
const PE: u32 = 1 << 0;
const START: u32 = 1 << 8;
const STOP: u32 = 1 << 9;
const ACK: u32 = 1 << 10;
const POS: u32 = 1 << 11;
const SWRST: u32 = 1 << 15;
/// PE, ENGC, NOSTRETCH, START, STOP, ACK, POS, SWRST.
const CR1_MODELLED: u32 = PE | 0b11 << 6 | START | STOP | ACK | POS | SWRST;
/// CR2.
const FREQ: u32 = 0x3F;
const ITERREN: u32 = 1 << 8;
const ITEVTEN: u32 = 1 << 9;
const ITBUFEN: u32 = 1 << 10;
const DMAEN: u32 = 1 << 11;
const LAST: u32 = 1 << 12;
/// SR1.
const SB: u32 = 1 << 0;
const ADDR: u32 = 1 << 1;
const BTF: u32 = 1 << 2;
const RXNE: u32 = 1 << 6;
const TXE: u32 = 1 << 7;
const AF: u32 = 1 << 10;
/// Flags that are cleared by writing 0: BERR, ARLO, AF, OVR, PECERR, TIMEOUT, SMBALERT.
const ERRORS: u32 = 0xDF00;
/// SR2.
const MSL: u32 = 1 << 0;
const BUSY: u32 = 1 << 1;
const TRA: u32 = 1 << 2;
/// CCR.
const FAST: u32 = 1 << 15;
const DUTY: u32 = 1 << 14;
/// SCL periods of a byte and its acknowledgement.
const BYTE_PERIODS: u64 = 9;

/// Phase of the bus. `end` is the cycle at which it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Idle,
    Starting {
        end: u64,
    },
    /// SB: waits for the program to write the address.
    Started,
    Addressing {
        end: u64,
        byte: u8,
    },
    /// ADDR: waits for the program's sequence that clears it.
    Addressed {
        read: bool,
    },
    /// Transmitter, nothing to shift.
    Waiting,
    Sending {
        end: u64,
        byte: u8,
    },
    Receiving {
        end: u64,
    },
    /// Receiver: this byte waits in the shift register behind an unread one.
    Full {
        byte: u8,
        acknowledged: bool,
    },
    /// After a missing acknowledgement: SCL is low until START or STOP.
    Held,
    Stopping {
        end: u64,
    },
}

/// One controller with its bus.
#[derive(Clone, Debug)]
pub struct I2c {
    cr1: u32,
    cr2: u32,
    oar: [u32; 2],
    ccr: u32,
    trise: u32,
    fltr: u32,
    dr: u8,
    sr1: u32,
    is_master: bool,
    is_transmitter: bool,
    /// Flags read by the last load of SR1.
    shown: u32,
    phase: Phase,
    /// A received byte that remained in the shift register after STOP or a repeated START.
    left_over: Option<u8>,
    /// POS: acknowledgement of the next byte.
    latched_ack: bool,
    /// LAST: the next byte is the last.
    nack_next: bool,
    /// The chip's own pull-ups hold both lines.
    pulled_up: bool,
    /// Both lines are connected to pins.
    routed: bool,
    /// HCLK cycles per PCLK1 cycle, and PCLK1 in Hz.
    pub divider: u64,
    pub pclk: u64,
    pub devices: Vec<Box<dyn I2cDevice>>,
    /// Devices that acknowledged the address.
    selected: Vec<usize>,
}

impl Default for I2c {
    fn default() -> Self {
        I2c::with(1, 16_000_000, Vec::new())
    }
}

impl I2c {
    fn with(divider: u64, pclk: u64, devices: Vec<Box<dyn I2cDevice>>) -> Self {
        I2c {
            cr1: 0,
            cr2: 0,
            oar: [0; 2],
            ccr: 0,
            trise: 2,
            fltr: 0,
            dr: 0,
            sr1: 0,
            is_master: false,
            is_transmitter: false,
            shown: 0,
            phase: Phase::Idle,
            left_over: None,
            latched_ack: false,
            nack_next: false,
            pulled_up: false,
            routed: false,
            divider,
            pclk,
            devices,
            selected: Vec::new(),
        }
    }

    /// Resets the controller, by RCC or a system reset. The devices see the bus released.
    pub fn reset(&mut self) {
        self.release();
        *self = I2c::with(self.divider, self.pclk, std::mem::take(&mut self.devices));
    }

    /// Returns whether the interface is enabled.
    pub fn is_enabled(&self) -> bool {
        self.cr1 & PE != 0
    }

    /// Unplugs every device.
    pub fn detach_all(&mut self) {
        self.devices.clear();
        self.selected.clear();
    }

    /// Sets the state of its pins. `routed`: SCL and SDA reach the bus. `pulled_up`: the chip's pull-ups are on.
    pub fn set_pins(&mut self, cycle: u64, routed: bool, pulled_up: bool) {
        (self.routed, self.pulled_up) = (routed, pulled_up);
        self.proceed(cycle);
    }

    fn lines_are_high(&self) -> bool {
        self.routed && (self.pulled_up || !self.devices.is_empty())
    }

    /// Cycles that SCL is high.
    fn half(&self) -> u64 {
        self.divider * u64::from(self.ccr & 0xFFF).max(1)
    }

    /// Cycles of one byte with its acknowledgement: SCL is low as long as high, twice as long, or 16/9 as long (RM0090
    /// 27.6.8).
    fn byte(&self) -> u64 {
        let halves = match (self.ccr & FAST != 0, self.ccr & DUTY != 0) {
            (false, _) => 2,
            (true, false) => 3,
            (true, true) => 25,
        };
        self.half() * halves * BYTE_PERIODS
    }

    /// Returns the cycle at which the present phase of the bus ends.
    pub fn next_event(&self) -> Option<u64> {
        match self.phase {
            Phase::Starting { end }
            | Phase::Addressing { end, .. }
            | Phase::Sending { end, .. }
            | Phase::Receiving { end }
            | Phase::Stopping { end } => Some(end),
            _ => None,
        }
    }

    /// Simulates the bus until `cycle`.
    pub fn catch_up(&mut self, cycle: u64) {
        while let Some(end) = self.next_event().filter(|end| *end <= cycle) {
            self.end_phase(end);
            self.proceed(end);
        }
    }

    fn end_phase(&mut self, cycle: u64) {
        match self.phase {
            Phase::Starting { .. } => {
                self.cr1 &= !START;
                self.sr1 |= SB;
                self.is_master = true;
                self.phase = Phase::Started;
            }
            Phase::Addressing { byte, .. } => {
                let read = byte & 1 == 1;
                if !self.lines_are_high() {
                    return self.fail();
                }
                let answers = |device: &mut Box<dyn I2cDevice>| device.start(byte >> 1, read);
                let devices = self.devices.iter_mut().enumerate();
                self.selected = devices.filter_map(|(n, device)| answers(device).then_some(n)).collect();
                if self.selected.is_empty() {
                    return self.fail();
                }
                self.sr1 |= if read { ADDR } else { ADDR | TXE };
                self.is_transmitter = !read;
                self.latched_ack = self.cr1 & ACK != 0;
                self.phase = Phase::Addressed { read };
            }
            Phase::Sending { byte, .. } => {
                let devices = &mut self.devices;
                let acknowledged = self.selected.iter().fold(false, |any, &n| devices[n].write(byte) | any);
                if !acknowledged {
                    return self.fail();
                }
                self.phase = Phase::Waiting;
                if self.sr1 & TXE == 0 {
                    self.send(cycle);
                } else {
                    self.sr1 |= BTF;
                }
            }
            Phase::Receiving { .. } => self.receive(cycle),
            Phase::Stopping { .. } => {
                self.cr1 &= !STOP;
                self.release();
            }
            _ => {}
        }
    }

    /// Handles a missing acknowledgement.
    fn fail(&mut self) {
        self.sr1 |= AF;
        self.phase = Phase::Held;
    }

    /// Moves a byte from DR to the shift register.
    fn send(&mut self, cycle: u64) {
        self.sr1 = self.sr1 & !BTF | TXE;
        self.phase = Phase::Sending { end: cycle + self.byte(), byte: self.dr };
    }

    /// Receives a byte. Open-drain lines carry the AND of all senders.
    fn receive(&mut self, cycle: u64) {
        let devices = &mut self.devices;
        let byte = self.selected.iter().fold(0xFF, |byte, &n| byte & devices[n].read());
        let ack = self.cr1 & ACK != 0;
        let acknowledged = if self.cr1 & POS != 0 { self.latched_ack } else { ack } && !self.nack_next;
        self.latched_ack = ack;
        self.nack_next = false;
        if self.sr1 & RXNE != 0 {
            self.sr1 |= BTF;
            self.phase = Phase::Full { byte, acknowledged };
            return;
        }
        self.dr = byte;
        self.sr1 |= RXNE;
        self.go_on_receiving(cycle, acknowledged);
    }

    fn go_on_receiving(&mut self, cycle: u64, acknowledged: bool) {
        let wanted = acknowledged && self.cr1 & (START | STOP) == 0;
        self.phase = if wanted { Phase::Receiving { end: cycle + self.byte() } } else { Phase::Held };
    }

    /// START and STOP take effect once the bus waits for its master.
    fn proceed(&mut self, cycle: u64) {
        if !self.is_enabled() {
            return;
        }
        let is_idle = self.phase == Phase::Idle;
        let waits = matches!(self.phase, Phase::Started | Phase::Waiting | Phase::Full { .. } | Phase::Held);
        if waits && self.cr1 & STOP != 0 {
            self.end_transfer();
            self.phase = Phase::Stopping { end: cycle + self.half() };
        } else if self.cr1 & START != 0 && (waits || is_idle && self.lines_are_high()) {
            self.end_transfer();
            self.phase = Phase::Starting { end: cycle + self.half() };
        }
    }

    /// START and STOP clear SB, TXE and BTF (RM0090 27.6.6).
    fn end_transfer(&mut self) {
        self.sr1 &= !(SB | BTF | TXE);
        if let Phase::Full { byte, .. } = self.phase {
            self.left_over = Some(byte);
        }
    }

    fn release(&mut self) {
        self.devices.iter_mut().for_each(|device| device.stop());
        self.selected.clear();
        (self.is_master, self.is_transmitter) = (false, false);
        self.phase = Phase::Idle;
    }

    /// Returns the lines of the event and the error interrupt.
    pub fn irqs(&self) -> [bool; 2] {
        let on = |enable: u32| self.cr2 & enable != 0;
        let buffers = if on(ITBUFEN) { TXE | RXNE } else { 0 };
        let event = on(ITEVTEN) && self.sr1 & (SB | ADDR | BTF | buffers) != 0;
        [event, on(ITERREN) && self.sr1 & ERRORS != 0]
    }

    /// Returns whether it requests a byte to send by DMA.
    pub fn asks_to_send(&self) -> bool {
        self.cr2 & DMAEN != 0
            && self.sr1 & TXE != 0
            && matches!(self.phase, Phase::Waiting | Phase::Sending { .. })
    }

    /// Returns whether a received byte waits for DMA.
    pub fn asks_to_receive(&self) -> bool {
        self.cr2 & DMAEN != 0 && self.sr1 & RXNE != 0
    }

    /// Handles the last but one byte moved by DMA: with LAST the next one is not acknowledged (RM0090 27.3.7).
    pub fn last_but_one_moved(&mut self) {
        self.nack_next = self.cr2 & LAST != 0;
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
            OAR1 | OAR2 => self.oar[(offset - OAR1) as usize / 4],
            DR => self.take(cycle),
            SR1 => {
                self.shown = self.sr1;
                self.sr1
            }
            SR2 => self.show_state(cycle),
            CCR => self.ccr,
            TRISE => self.trise,
            FLTR => self.fltr,
            _ => return Err(Refusal::Unmodelled),
        })
    }

    fn take(&mut self, cycle: u64) -> u32 {
        let byte = self.dr;
        if let Phase::Full { byte, acknowledged } = self.phase {
            self.dr = byte;
            self.sr1 &= !BTF;
            self.go_on_receiving(cycle, acknowledged);
            self.proceed(cycle);
        } else if let Some(byte) = self.left_over.take() {
            self.dr = byte;
        } else {
            self.sr1 &= !RXNE;
        }
        u32::from(byte)
    }

    /// A load of SR2 after one of SR1 clears ADDR (RM0090 27.6.6).
    fn show_state(&mut self, cycle: u64) -> u32 {
        let is_busy = self.is_enabled() && (self.phase != Phase::Idle || !self.lines_are_high());
        let bit = |on: bool, mask: u32| if on { mask } else { 0 };
        let state = bit(self.is_master, MSL) | bit(is_busy, BUSY) | bit(self.is_transmitter, TRA);
        if let Phase::Addressed { read } = self.phase
            && self.shown & ADDR != 0
        {
            self.sr1 &= !ADDR;
            self.shown = 0;
            if read {
                self.phase = Phase::Receiving { end: cycle + self.byte() };
            } else if self.sr1 & TXE == 0 {
                self.send(cycle);
            } else {
                self.phase = Phase::Waiting;
                self.proceed(cycle);
            }
        }
        state
    }

    /// A store.
    ///
    /// # Errors
    /// [`Refusal::Unmodelled`] for what is not modelled, [`Refusal::Misuse`] for an enable with a speed that the manual
    /// forbids and for an address written before SB was read.
    pub fn write(&mut self, cycle: u64, offset: u32, value: u32) -> Result<(), Refusal> {
        self.catch_up(cycle);
        let value = value & 0xFFFF;
        match offset {
            CR1 => return self.control(cycle, value),
            CR2 => self.cr2 = value & (FREQ | ITERREN | ITEVTEN | ITBUFEN | DMAEN | LAST),
            OAR1 | OAR2 => self.oar[(offset - OAR1) as usize / 4] = value,
            DR => return self.put(cycle, value as u8),
            SR1 => self.sr1 &= value | !ERRORS,
            SR2 => {}
            // Only while the interface is off (RM0090 27.6.8, 27.6.9).
            CCR | TRISE if self.is_enabled() && self.phase != Phase::Idle => return Err(Refusal::Misuse),
            CCR => self.ccr = value & (FAST | DUTY | 0xFFF),
            TRISE => self.trise = value & 0x3F,
            FLTR => self.fltr = value & 0x1F,
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    fn control(&mut self, cycle: u64, value: u32) -> Result<(), Refusal> {
        if value & SWRST != 0 {
            let (routed, pulled_up) = (self.routed, self.pulled_up);
            self.reset();
            (self.cr1, self.routed, self.pulled_up) = (SWRST, routed, pulled_up);
            return Ok(());
        }
        if value & !CR1_MODELLED != 0 {
            return Err(Refusal::Unmodelled);
        }
        if value & PE == 0 {
            // Drops the transfer in progress and the flags.
            self.release();
            self.sr1 = 0;
            self.cr1 = value & !(START | STOP | ACK);
            return Ok(());
        }
        if !self.is_enabled() && !self.speed_is_valid() {
            return Err(Refusal::Misuse);
        }
        // Without a transfer there is nothing to stop.
        self.cr1 = if self.phase == Phase::Idle { value & !STOP } else { value };
        self.proceed(cycle);
        Ok(())
    }

    /// FREQ is PCLK1 in MHz; CCR is at least 4, or 1 with DUTY in fast mode (RM0090 27.6.2, 27.6.8).
    fn speed_is_valid(&self) -> bool {
        let mhz = u64::from(self.cr2 & FREQ);
        let least = if self.ccr & (FAST | DUTY) == FAST | DUTY { 1 } else { 4 };
        (2..=50).contains(&mhz)
            && (mhz * 1_000_000).abs_diff(self.pclk) < 1_000_000
            && self.ccr & 0xFFF >= least
    }

    fn put(&mut self, cycle: u64, byte: u8) -> Result<(), Refusal> {
        match self.phase {
            Phase::Started => {
                // SR1 is read first: nothing else clears SB. 11110xxb begins an address of ten bits.
                if self.shown & SB == 0 {
                    return Err(Refusal::Misuse);
                }
                if byte & 0xF8 == 0xF0 {
                    return Err(Refusal::Unmodelled);
                }
                self.sr1 &= !SB;
                self.shown = 0;
                self.phase = Phase::Addressing { end: cycle + self.byte(), byte };
            }
            Phase::Waiting => {
                self.dr = byte;
                self.send(cycle);
            }
            Phase::Sending { .. } | Phase::Addressed { read: false } => {
                self.dr = byte;
                self.sr1 &= !TXE;
            }
            _ => self.dr = byte,
        }
        Ok(())
    }
}
