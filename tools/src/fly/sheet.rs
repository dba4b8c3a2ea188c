//! Electronic data sheets (CiA 306): which PDOs a device sends and receives, and the objects in them.
//!
//! A *data sheet* lists the objects of a device with their names, types and default values. In a DCF, the values of the
//! device itself are used. The shipped images have theirs in `docs/eds`; an image of the user's has the file of `--eds
//! N=FILE`.
//!
//! A PDO that the file does not describe is left out, and [`Sheet::notes`] says why: a flight does not need it.

#[cfg(test)]
mod odd;
#[cfg(test)]
mod tests;

use std::fmt;
use std::ops::RangeInclusive;

use ecss_can_eds::pdos::{FIRST_OBJECT, Field, Node, Pdo};
use ecss_can_eds::{DataSheet, Entry, Unreadable, Value};

/// Bits of a COB-ID entry: not valid; 29-bit identifier; what an 11-bit identifier leaves zero.
const INVALID: u32 = 1 << 31;
const EXTENDED: u32 = 1 << 29;
const UNUSED: u32 = 0x1FFF_F800;

/// Communication records of transmit and of receive PDOs, and the distance to their mappings.
const TPDOS: RangeInclusive<u16> = 0x1800..=0x19FF;
const RPDOS: RangeInclusive<u16> = 0x1400..=0x15FF;
const TO_MAPPING: u16 = 0x200;

/// Most objects and most bits in a PDO.
const MOST: u32 = 64;

/// Numbers of objects that stand for a multiplex PDO: by source address, by destination address.
const MULTIPLEX: [u32; 2] = [0xFE, 0xFF];

/// Device type, vendor, product and revision: the objects by which a device is known.
pub const IDENTITY: [(u16, u8); 4] = [(0x1000, 0), (0x1018, 1), (0x1018, 2), (0x1018, 3)];

/// PDOs of a device by its data sheet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sheet {
    /// Name of the device (`ProductName`).
    pub product: Option<String>,
    /// Transmit PDOs whose values have names, by their numbers.
    pub pdos: Vec<Pdo>,
    /// COB-IDs of the other transmit PDOs.
    pub others: Vec<u16>,
    /// Values of the objects in [`IDENTITY`].
    pub identity: [Option<u32>; 4],
    /// Receive PDOs whose values have names, by their numbers.
    pub received: Vec<Pdo>,
    /// Entries that were left out, with their positions in the file.
    pub notes: Vec<String>,
}

impl Sheet {
    /// Reads the data sheet of a device with this Node-ID.
    ///
    /// # Errors
    /// When the file is no data sheet.
    pub fn read(bytes: &[u8], node: u8) -> Result<Sheet, Unreadable> {
        let file = DataSheet::read(bytes)?;
        let product = file.entry("DeviceInfo", "ProductName").map(|entry| entry.text().to_owned());
        let mut sheet = Sheet { product, notes: file.doubles().to_vec(), ..Sheet::default() };
        match file.node() {
            Ok(Some(other)) if other != node => {
                sheet.notes.push(format!("the file is that of node {other}; it is taken for node {node}"));
            }
            Err(wrong) => sheet.notes.push(wrong.to_string()),
            Ok(_) => {}
        }
        for ((index, sub), known) in IDENTITY.into_iter().zip(&mut sheet.identity) {
            match file.object(index, sub, node) {
                Ok(value) => *known = value.map(|value| value.number),
                Err(wrong) => sheet.notes.push(format!("{wrong}; the node is not compared with it")),
            }
        }
        let reader = Reader { file: &file, node };
        (sheet.pdos, sheet.others) = reader.pdos("TPDO", TPDOS, &mut sheet.notes);
        (sheet.received, _) = reader.pdos("RPDO", RPDOS, &mut sheet.notes);
        Ok(sheet)
    }

    /// Returns its PDOs for the comparison with those of other nodes.
    pub fn node(&self, name: &str) -> Node {
        Node { name: name.to_owned(), sent: self.pdos.clone(), received: self.received.clone() }
    }
}

/// Value of an object in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// BOOLEAN.
    Flag(bool),
    /// Integer with sign.
    Signed(i64),
    /// Integer without sign.
    Unsigned(u64),
    /// REAL32.
    Short(f32),
    /// REAL64.
    Long(f64),
    /// Another type, or an unknown one: its bits, and their number.
    Bits(u64, u32),
}

/// Returns the values in a frame of a PDO, by name. `None` if the frame has another length.
pub fn values<'a>(pdo: &'a Pdo, data: &[u8]) -> Option<Vec<(&'a str, Number)>> {
    if pdo.bytes() as usize != data.len() {
        return None;
    }
    let mut rest = data.iter().rev().fold(0_u64, |value, byte| value << 8 | u64::from(*byte));
    let value = |field: &'a Field| {
        let raw = rest & (u64::MAX >> (64 - field.bits));
        rest = rest.checked_shr(field.bits).unwrap_or(0);
        (field.name.as_str(), Number::of(field, raw))
    };
    Some(pdo.fields.iter().map(value).collect())
}

impl Number {
    fn of(field: &Field, raw: u64) -> Number {
        let unused = 64 - field.bits;
        match field.data_type {
            0x01 => Number::Flag(raw != 0),
            0x02..=0x04 | 0x10 | 0x12..=0x15 => Number::Signed((raw << unused) as i64 >> unused),
            0x08 if field.bits == 32 => Number::Short(f32::from_bits(raw as u32)),
            0x11 if field.bits == 64 => Number::Long(f64::from_bits(raw)),
            0x05..=0x07 | 0x16 | 0x18..=0x1B => Number::Unsigned(raw),
            _ => Number::Bits(raw, field.bits),
        }
    }

    /// Returns the value on a vertical axis; `None` for one without an order, and for a REAL that is not finite.
    pub fn height(self) -> Option<f64> {
        let height = match self {
            Number::Flag(flag) => f64::from(u8::from(flag)),
            Number::Signed(value) => value as f64,
            Number::Unsigned(value) => value as f64,
            Number::Short(value) => value.into(),
            Number::Long(value) => value,
            Number::Bits(..) => return None,
        };
        height.is_finite().then_some(height)
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Number::Flag(flag) => flag.fmt(f),
            Number::Signed(value) => value.fmt(f),
            Number::Unsigned(value) => value.fmt(f),
            Number::Short(value) => value.fmt(f),
            Number::Long(value) => value.fmt(f),
            Number::Bits(raw, bits) => write!(f, "{raw:0width$X}h", width = bits.div_ceil(4) as usize),
        }
    }
}

/// Reads the PDOs of a file.
struct Reader<'a> {
    file: &'a DataSheet,
    node: u8,
}

impl Reader<'_> {
    /// The valid PDOs of a direction by their communication records, and the COB-IDs of those without names of values.
    fn pdos(
        &self,
        direction: &str,
        records: RangeInclusive<u16>,
        notes: &mut Vec<String>,
    ) -> (Vec<Pdo>, Vec<u16>) {
        let (mut pdos, mut others) = (Vec::new(), Vec::new());
        for record in self.file.indices().filter(|index| records.contains(index)) {
            let number = record - records.start() + 1;
            match self.id(record) {
                Ok(None) => {}
                Ok(Some(id)) => match self.mapped(record + TO_MAPPING) {
                    Ok(entries) if entries.is_empty() => others.push(id),
                    Ok(entries) => {
                        let fields = entries.iter().map(|entry| self.field(*entry, notes)).collect();
                        pdos.push(Pdo { number, id, fields });
                    }
                    Err(wrong) => {
                        others.push(id);
                        notes.push(format!("{wrong}; {direction} {number} is left out"));
                    }
                },
                Err(wrong) => notes.push(format!("{wrong}; {direction} {number} is left out")),
            }
        }
        (pdos, others)
    }

    /// The COB-ID of a communication record. `None`: the PDO is not valid.
    fn id(&self, record: u16) -> Result<Option<u16>, String> {
        let Some(id) = self.value(record, 1)? else {
            let is_mapped = !self.mapped(record + TO_MAPPING)?.is_empty();
            return if is_mapped { Err(missing(record, 1)) } else { Ok(None) };
        };
        match id.number {
            number if number & INVALID != 0 => Ok(None),
            number if number & (EXTENDED | UNUSED) != 0 => {
                Err(wrong(id.entry, "allowed are identifiers of 11 bits"))
            }
            number => Ok(Some((number & 0x7FF) as u16)),
        }
    }

    /// Entries of a mapping. Those that are zero map nothing and are left out.
    fn mapped(&self, mapping: u16) -> Result<Vec<u32>, String> {
        let Some(count) = self.value(mapping, 0)? else {
            let is_empty = self.value(mapping, 1)?.is_none_or(|first| first.number == 0);
            return if is_empty { Ok(Vec::new()) } else { Err(missing(mapping, 0)) };
        };
        if MULTIPLEX.contains(&count.number) {
            let text = "a multiplex PDO (MPDO), whose objects differ from frame to frame";
            return Err(wrong(count.entry, text));
        }
        if count.number > MOST {
            let allowed = "allowed are 0 to 64 objects, and 0xFE and 0xFF for a multiplex PDO";
            return Err(wrong(count.entry, allowed));
        }
        let (mut entries, mut sum) = (Vec::new(), 0);
        for sub in 1..=count.number as u8 {
            let Some(entry) = self.value(mapping, sub)? else { return Err(missing(mapping, sub)) };
            let bits = entry.number & 0xFF;
            sum += bits;
            match entry.number {
                0 => {}
                _ if bits == 0 || sum > MOST => {
                    return Err(wrong(entry.entry, "allowed are 1 to 64 bits in a PDO"));
                }
                number => entries.push(number),
            }
        }
        Ok(entries)
    }

    /// The object of an entry of a mapping.
    fn field(&self, entry: u32, notes: &mut Vec<String>) -> Field {
        let (index, sub, bits) = ((entry >> 16) as u16, (entry >> 8) as u8, entry & 0xFF);
        if u32::from(index) < FIRST_OBJECT {
            return Field { name: String::new(), data_type: 0, bits };
        }
        let data_type = self.file.data_type(index, sub).unwrap_or_else(|wrong| {
            notes.push(format!("{wrong}; its values are shown in hexadecimal"));
            None
        });
        Field { name: self.file.name(index, sub), data_type: data_type.unwrap_or(0), bits }
    }

    fn value(&self, index: u16, sub: u8) -> Result<Option<Value<'_>>, String> {
        self.file.object(index, sub, self.node).map_err(|wrong| wrong.to_string())
    }
}

fn wrong(entry: &Entry, allowed: &str) -> String {
    entry.wrong(allowed).to_string()
}

fn missing(index: u16, sub: u8) -> String {
    format!("[{index:X}sub{sub:X}] has no value: neither ParameterValue nor DefaultValue")
}
