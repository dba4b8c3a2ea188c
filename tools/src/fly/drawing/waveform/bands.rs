//! Runs of bits of one field, with their usual names.

use can_twin::wire::field::Field;
use can_twin::wire::time::Time;
use can_twin::wire::waveform::{Bit, Lane};

/// Numbers of the error flags.
const ACTIVE: u8 = 0;
const PASSIVE: u8 = 1;

/// One run of bits.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Band {
    /// The first field of the run: data by the index of its byte, a flag by [`ACTIVE`] or [`PASSIVE`].
    field: Field,
    pub(super) from: Time,
    pub(super) to: Time,
    /// Bits without stuff bits, the first one is the highest.
    value: u64,
    bits: u32,
}

/// Returns the bands of a lane in chronological order.
pub(super) fn bands(lane: &Lane) -> Vec<Band> {
    let mut bands: Vec<Band> = Vec::new();
    for bit in &lane.bits {
        let last = bands.last_mut().filter(|last| last.to.0.abs_diff(bit.start.0) <= lane.bit_time.0 / 2);
        let field = run_of(bit, last.as_ref().map(|last| last.field));
        let is_stuff = bit.field == Field::Stuff;
        let value = if is_stuff { 0 } else { u64::from(bit.sampled) };
        match last.filter(|last| last.field == field) {
            Some(band) => {
                band.to = bit.end;
                if !is_stuff {
                    band.value = band.value << 1 | value;
                    band.bits += 1;
                }
            }
            None => {
                bands.push(Band { field, from: bit.start, to: bit.end, value, bits: u32::from(!is_stuff) })
            }
        }
    }
    bands
}

/// Returns the first field of the run of a bit; `before` is that of the run before it.
fn run_of(bit: &Bit, before: Option<Field>) -> Field {
    match bit.field {
        Field::Identifier(_) | Field::Extension(_) => Field::Identifier(0),
        Field::ExtendedRtr => Field::Rtr,
        Field::Dlc(_) => Field::Dlc(0),
        Field::Data(bit) => Field::Data(bit / 8),
        Field::Crc(_) => Field::Crc(0),
        // A stuff bit belongs to the field of the bit before it.
        Field::Stuff => before.unwrap_or(Field::Sof),
        Field::Eof(_) => Field::Eof(0),
        Field::Intermission(_) => Field::Intermission(0),
        Field::Suspend(_) => Field::Suspend(0),
        // A passive flag is recessive.
        Field::ErrorFlag(_) => Field::ErrorFlag(if bit.driven { PASSIVE } else { ACTIVE }),
        Field::OverloadFlag(_) => Field::OverloadFlag(0),
        // The first recessive bit after the flags is the first of the delimiter.
        Field::Superposition(_) if !bit.sampled => Field::Superposition(0),
        Field::Superposition(_) | Field::Delimiter(_) => Field::Delimiter(0),
        single => single,
    }
}

impl Band {
    /// Returns its class in the picture, and its names, the longest first, to be chosen by the available room.
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
        match self.field {
            Field::Sof | Field::Stuff => ("sof", fixed(&["SOF"])),
            Field::Identifier(_) | Field::Extension(_) if self.bits == 29 => {
                ("id", hex("identifier", "ID", 8, 29))
            }
            Field::Identifier(_) | Field::Extension(_) => ("id", hex("identifier", "ID", 3, 11)),
            Field::Rtr | Field::ExtendedRtr => ("control", fixed(&["RTR"])),
            Field::Ide => ("control", fixed(&["IDE"])),
            Field::Reserved(bit) => ("control", vec![format!("r{}", 1 - bit.min(1))]),
            Field::Dlc(_) if self.bits == 4 => ("dlc", vec![format!("DLC {}", self.value), "DLC".to_owned()]),
            Field::Dlc(_) => ("dlc", fixed(&["DLC"])),
            Field::Data(byte) => ("data", hex(&format!("data {byte}:"), &format!("D{byte}"), 2, 8)),
            Field::Crc(_) => ("crc", hex("CRC", "CRC", 4, 15)),
            Field::CrcDelimiter => ("fixed", fixed(&["CRC delimiter", "del"])),
            Field::AckSlot => ("ack", fixed(&["ACK"])),
            Field::AckDelimiter => ("fixed", fixed(&["ACK delimiter", "del"])),
            Field::Eof(_) => ("fixed", fixed(&["end of frame", "EOF"])),
            Field::Intermission(_) => ("between", fixed(&["intermission", "IFS"])),
            Field::Suspend(_) => ("between", fixed(&["suspend transmission", "suspend", "SUS"])),
            Field::ErrorFlag(ACTIVE) => ("flag", fixed(&["active error flag", "error flag", "flag"])),
            Field::ErrorFlag(_) => ("passive", fixed(&["passive error flag", "passive flag", "pasv"])),
            Field::OverloadFlag(_) => ("overload", fixed(&["overload flag", "overload", "OVL"])),
            Field::Superposition(_) => ("superposition", fixed(&["superposition", "superpos.", "sup"])),
            Field::Delimiter(_) => ("delimiter", fixed(&["delimiter", "del"])),
            Field::Idle => ("between", fixed(&["not on the bus", "off"])),
        }
    }
}
