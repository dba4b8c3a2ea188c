//! Runs of bits that belong together, with the names that text books give them.

use can_wire::field::Field;
use can_wire::time::Time;
use can_wire::waveform::{Bit, Lane};

/// The part of a frame, or of what is between frames, that a band shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Sof,
    Identifier,
    Rtr,
    Ide,
    Reserved(u8),
    Dlc,
    /// Index of the byte.
    Data(u8),
    Crc,
    CrcDelimiter,
    Ack,
    AckDelimiter,
    Eof,
    Intermission,
    Suspend,
    ActiveFlag,
    PassiveFlag,
    OverloadFlag,
    Superposition,
    Delimiter,
    Waiting,
}

/// One run of bits.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Band {
    pub(super) kind: Kind,
    pub(super) from: Time,
    pub(super) to: Time,
    /// The bits without stuff bits, first one highest.
    value: u64,
    bits: u32,
}

/// The bands of a lane in the order of time.
pub(super) fn bands(lane: &Lane) -> Vec<Band> {
    let mut bands: Vec<Band> = Vec::new();
    for bit in &lane.bits {
        let last = bands.last_mut().filter(|last| last.to.0.abs_diff(bit.start.0) <= lane.bit_time.0 / 2);
        let kind = kind_of(bit, last.as_ref().map(|last| last.kind));
        let is_stuff = bit.field == Field::Stuff;
        let value = if is_stuff { 0 } else { u64::from(bit.sampled) };
        match last.filter(|last| last.kind == kind) {
            Some(band) => {
                band.to = bit.end;
                if !is_stuff {
                    band.value = band.value << 1 | value;
                    band.bits += 1;
                }
            }
            None => {
                bands.push(Band { kind, from: bit.start, to: bit.end, value, bits: u32::from(!is_stuff) })
            }
        }
    }
    bands
}

/// What a bit belongs to that follows one of kind `before`.
fn kind_of(bit: &Bit, before: Option<Kind>) -> Kind {
    match bit.field {
        Field::Sof => Kind::Sof,
        Field::Identifier(_) | Field::Extension(_) => Kind::Identifier,
        Field::Rtr | Field::ExtendedRtr => Kind::Rtr,
        Field::Ide => Kind::Ide,
        Field::Reserved(bit) => Kind::Reserved(bit),
        Field::Dlc(_) => Kind::Dlc,
        Field::Data(bit) => Kind::Data(bit / 8),
        Field::Crc(_) => Kind::Crc,
        // A stuff bit belongs to the field of the bit before it.
        Field::Stuff => before.unwrap_or(Kind::Sof),
        Field::CrcDelimiter => Kind::CrcDelimiter,
        Field::AckSlot => Kind::Ack,
        Field::AckDelimiter => Kind::AckDelimiter,
        Field::Eof(_) => Kind::Eof,
        Field::Intermission(_) => Kind::Intermission,
        Field::Suspend(_) => Kind::Suspend,
        // A passive flag is recessive.
        Field::ErrorFlag(_) if bit.driven => Kind::PassiveFlag,
        Field::ErrorFlag(_) => Kind::ActiveFlag,
        Field::OverloadFlag(_) => Kind::OverloadFlag,
        // The first recessive bit after the flags is the first of the delimiter.
        Field::Superposition(_) if bit.sampled => Kind::Delimiter,
        Field::Superposition(_) => Kind::Superposition,
        Field::Delimiter(_) => Kind::Delimiter,
        Field::Idle => Kind::Waiting,
    }
}

impl Band {
    /// Its class in the picture, and its names: the longest first, for as much room as there is.
    pub(super) fn look(&self) -> (&'static str, Vec<String>) {
        let fixed = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let hex = |name: &str, short: &str, width: usize, of: u32| {
            let mut names = vec![name.to_owned(), short.to_owned()];
            if self.bits == of {
                let value = format!("{:0width$X}h", self.value);
                names.splice(1..1, [format!("{short} {value}"), value.clone()]);
                names.insert(0, format!("{name} {value}"));
            }
            names
        };
        match self.kind {
            Kind::Sof => ("sof", fixed(&["SOF"])),
            Kind::Identifier if self.bits == 29 => ("id", hex("identifier", "ID", 8, 29)),
            Kind::Identifier => ("id", hex("identifier", "ID", 3, 11)),
            Kind::Rtr => ("control", fixed(&["RTR"])),
            Kind::Ide => ("control", fixed(&["IDE"])),
            Kind::Reserved(bit) => ("control", vec![format!("r{}", 1 - bit.min(1))]),
            Kind::Dlc if self.bits == 4 => ("dlc", vec![format!("DLC {}", self.value), "DLC".to_owned()]),
            Kind::Dlc => ("dlc", fixed(&["DLC"])),
            Kind::Data(byte) => ("data", hex(&format!("data {byte}:"), &format!("D{byte}"), 2, 8)),
            Kind::Crc => ("crc", hex("CRC", "CRC", 4, 15)),
            Kind::CrcDelimiter => ("fixed", fixed(&["CRC delimiter", "del"])),
            Kind::Ack => ("ack", fixed(&["ACK"])),
            Kind::AckDelimiter => ("fixed", fixed(&["ACK delimiter", "del"])),
            Kind::Eof => ("fixed", fixed(&["end of frame", "EOF"])),
            Kind::Intermission => ("between", fixed(&["intermission", "IFS"])),
            Kind::Suspend => ("between", fixed(&["suspend transmission", "suspend", "SUS"])),
            Kind::ActiveFlag => ("flag", fixed(&["active error flag", "error flag", "flag"])),
            Kind::PassiveFlag => ("passive", fixed(&["passive error flag", "passive flag", "pasv"])),
            Kind::OverloadFlag => ("overload", fixed(&["overload flag", "overload", "OVL"])),
            Kind::Superposition => ("superposition", fixed(&["superposition", "superpos.", "sup"])),
            Kind::Delimiter => ("delimiter", fixed(&["delimiter", "del"])),
            Kind::Waiting => ("between", fixed(&["not on the bus", "off"])),
        }
    }
}
