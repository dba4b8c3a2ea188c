//! The receiver's view of a frame: destuffing, fields, CRC.

use crate::wire::encode::crc_step;
use crate::wire::field::Field;
use crate::wire::frame::{WireFrame, WireId};

const CRC_BITS: u16 = 15;
/// Plain bits before the data field.
const STANDARD_HEADER: u16 = 19;
const EXTENDED_HEADER: u16 = 39;
/// Equal bits in a row after which a complementary one is stuffed.
const STUFF_RUN: u8 = 5;

/// A broken stuffing rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wire) struct StuffError;

/// Takes a frame bit by bit, SOF first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::wire) struct Decoder {
    /// Bits taken, stuff bits included.
    index: u16,
    /// Bits taken without stuff bits.
    plain: u16,
    /// Plain bits from SOF to the end of the CRC sequence; unknown before the DLC.
    total: u16,
    last: bool,
    run: u8,
    crc: u16,
    received_crc: u16,
    identifier: u32,
    extended: bool,
    remote: bool,
    dlc: u8,
    data: [u8; 8],
}

impl Decoder {
    pub(in crate::wire) fn new() -> Self {
        Decoder { total: u16::MAX, last: true, ..Decoder::default() }
    }

    /// Returns the number of bits taken, which is the index of the next bit.
    pub(in crate::wire) fn index(&self) -> usize {
        usize::from(self.index)
    }

    /// Returns whether the next bit is a stuff bit.
    pub(in crate::wire) fn stuff_is_due(&self) -> bool {
        self.run == STUFF_RUN
    }

    /// Returns whether the stuffed part is complete and fixed-form bits follow.
    pub(in crate::wire) fn is_complete(&self) -> bool {
        self.plain == self.total && !self.stuff_is_due()
    }

    pub(in crate::wire) fn crc_is_good(&self) -> bool {
        self.crc == self.received_crc
    }

    /// Returns the field of the next bit, in the stuffed part.
    pub(in crate::wire) fn field(&self) -> Field {
        if self.stuff_is_due() { Field::Stuff } else { self.plain_field() }
    }

    fn plain_field(&self) -> Field {
        let n = self.plain;
        let low = |first: u16| (n - first) as u8;
        match n {
            0 => Field::Sof,
            1..=11 => Field::Identifier(low(1)),
            12 => Field::Rtr,
            13 => Field::Ide,
            14..=31 if self.extended => Field::Extension(low(14)),
            32 if self.extended => Field::ExtendedRtr,
            33 | 34 if self.extended => Field::Reserved(low(33)),
            35..=38 if self.extended => Field::Dlc(low(35)),
            14 => Field::Reserved(1),
            15..=18 => Field::Dlc(low(15)),
            _ if n >= self.total - CRC_BITS => Field::Crc(low(self.total - CRC_BITS)),
            _ => Field::Data(low(self.header())),
        }
    }

    /// Takes a bit of the stuffed part.
    pub(in crate::wire) fn push(&mut self, level: bool) -> Result<(), StuffError> {
        self.index += 1;
        if self.stuff_is_due() {
            if level == self.last {
                return Err(StuffError);
            }
            (self.last, self.run) = (level, 1);
            return Ok(());
        }
        self.run = if level == self.last { self.run + 1 } else { 1 };
        self.last = level;
        self.take(level);
        Ok(())
    }

    /// Takes a bit of the fixed form.
    pub(in crate::wire) fn push_fixed(&mut self) {
        self.index += 1;
    }

    fn take(&mut self, level: bool) {
        let field = self.plain_field();
        match field {
            Field::Crc(_) => self.received_crc = self.received_crc << 1 | u16::from(level),
            _ => self.crc = crc_step(self.crc, level),
        }
        match field {
            Field::Identifier(_) | Field::Extension(_) => {
                self.identifier = self.identifier << 1 | u32::from(level)
            }
            Field::Rtr | Field::ExtendedRtr => self.remote = level,
            Field::Ide => self.extended = level,
            Field::Dlc(_) => self.dlc = self.dlc << 1 | u8::from(level),
            Field::Data(n) => self.data[usize::from(n / 8)] |= u8::from(level) << (7 - n % 8),
            _ => {}
        }
        self.plain += 1;
        if self.plain == self.header() && matches!(field, Field::Dlc(_)) {
            let bytes = if self.remote { 0 } else { u16::from(self.dlc.min(8)) };
            self.total = self.plain + 8 * bytes + CRC_BITS;
        }
    }

    fn header(&self) -> u16 {
        if self.extended { EXTENDED_HEADER } else { STANDARD_HEADER }
    }

    /// The frame, once the stuffed part is complete.
    pub(in crate::wire) fn frame(&self) -> WireFrame {
        let id = if self.extended {
            WireId::Extended(self.identifier)
        } else {
            WireId::Standard(self.identifier as u16)
        };
        WireFrame { id, remote: self.remote, dlc: self.dlc, data: self.data }
    }
}
