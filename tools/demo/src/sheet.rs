//! Electronic data sheets (CiA 306): which PDOs a device sends and receives, and the objects in them.
//!
//! A *data sheet* lists the objects of a device with their names, types and default values. Of a DCF, the values of the device itself
//! count. The shipped images have theirs in `docs/eds`; an image of the user's has the file of `--eds N=FILE`.

use std::ops::RangeInclusive;

use configparser::ini::Ini;
use eds::pdos;

/// Bits of a COB-ID entry that exclude a PDO: not valid; 29-bit identifier.
const EXCLUDED: u32 = 1 << 31 | 1 << 29;

/// First and last communication record of a transmit PDO and of a receive PDO, and the distance to its mapping.
const TPDOS: RangeInclusive<u16> = 0x1800..=0x19FF;
const RPDOS: RangeInclusive<u16> = 0x1400..=0x15FF;
const TO_MAPPING: u16 = 0x200;

/// Most objects in a PDO.
const MOST: u32 = 64;

/// The PDOs of a device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sheet {
    /// Transmit PDOs, by their numbers.
    pub pdos: Vec<Pdo>,
    /// Receive PDOs, by their numbers.
    pub received: Vec<Pdo>,
}

/// A PDO.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pdo {
    /// Number, from 1.
    pub number: u16,
    /// COB-ID.
    pub id: u16,
    /// Its objects in their order.
    pub fields: Vec<Field>,
}

/// An object in a PDO.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name of the object and of its sub-index.
    pub name: String,
    /// Data type, its index in CiA 301 table 44.
    pub data_type: u32,
    /// Length in bits, at most 64.
    pub bits: u32,
}

impl Sheet {
    /// Reads the data sheet of a device with this Node-ID.
    ///
    /// # Errors
    /// When the text has no sections and keys, or a PDO has an entry that is no number.
    pub fn read(text: &str, node: u8) -> Result<Sheet, String> {
        let mut ini = Ini::new();
        ini.read(text.to_owned())?;
        let file = File { ini: &ini, node };
        Ok(Sheet { pdos: file.pdos(TPDOS)?, received: file.pdos(RPDOS)? })
    }
}

impl Sheet {
    /// Its PDOs, for the comparison with those of other nodes.
    pub fn node(&self, name: &str) -> pdos::Node {
        let all = |pdos: &[Pdo]| pdos.iter().map(Pdo::compared).collect();
        pdos::Node { name: name.to_owned(), sent: all(&self.pdos), received: all(&self.received) }
    }
}

impl Pdo {
    fn compared(&self) -> pdos::Pdo {
        let fields = self.fields.iter().map(|field| pdos::Field {
            name: field.name.clone(),
            data_type: field.data_type,
            bits: field.bits,
        });
        pdos::Pdo { number: self.number, id: self.id, fields: fields.collect() }
    }

    /// The values in a frame, by name; `None` when the frame has another length.
    pub fn values<'a>(&'a self, data: &[u8]) -> Option<Vec<(&'a str, String)>> {
        let bits: u32 = self.fields.iter().map(|field| field.bits).sum();
        if bits.div_ceil(8) as usize != data.len() || bits > 64 {
            return None;
        }
        let mut rest = data.iter().rev().fold(0_u64, |value, byte| value << 8 | u64::from(*byte));
        let value = |field: &'a Field| {
            let raw = rest & (u64::MAX >> (64 - field.bits));
            rest = rest.checked_shr(field.bits).unwrap_or(0);
            (field.name.as_str(), field.text(raw))
        };
        Some(self.fields.iter().map(value).collect())
    }
}

impl Field {
    /// A value for people.
    fn text(&self, raw: u64) -> String {
        match self.data_type {
            0x01 => (raw != 0).to_string(),
            0x02..=0x04 | 0x10 | 0x12..=0x15 => {
                ((raw << (64 - self.bits)) as i64 >> (64 - self.bits)).to_string()
            }
            0x08 if self.bits == 32 => f32::from_bits(raw as u32).to_string(),
            0x11 if self.bits == 64 => f64::from_bits(raw).to_string(),
            0x05..=0x07 | 0x16 | 0x18..=0x1B => raw.to_string(),
            _ => format!("{raw:0width$X}h", width = self.bits.div_ceil(4) as usize),
        }
    }
}

/// A file that is being read. Names of sections and keys are in small letters there.
struct File<'a> {
    ini: &'a Ini,
    node: u8,
}

impl File<'_> {
    /// The valid PDOs of a direction, by its communication records.
    fn pdos(&self, records: RangeInclusive<u16>) -> Result<Vec<Pdo>, String> {
        let mut pdos = Vec::new();
        for record in records.clone() {
            let Some(id) = self.value(&format!("{record:x}sub1"))?.filter(|id| id & EXCLUDED == 0) else {
                continue;
            };
            let fields = self.fields(record + TO_MAPPING)?;
            if !fields.is_empty() {
                pdos.push(Pdo { number: record - records.start() + 1, id: (id & 0x7FF) as u16, fields });
            }
        }
        Ok(pdos)
    }

    /// The objects of a mapping; empty when there are none.
    fn fields(&self, mapping: u16) -> Result<Vec<Field>, String> {
        let count = self.value(&format!("{mapping:x}sub0"))?.unwrap_or(0).min(MOST);
        let mut fields = Vec::new();
        for place in 1..=count {
            let entry = self.value(&format!("{mapping:x}sub{place:x}"))?.unwrap_or(0);
            let (index, sub, bits) = (entry >> 16, entry >> 8 & 0xFF, entry & 0xFF);
            if !(1..=64).contains(&bits) {
                return Err(format!("[{mapping:X}sub{place:X}] maps {bits} bits; allowed are 1 to 64"));
            }
            let of_sub = format!("{index:04x}sub{sub:x}");
            let section =
                if self.ini.get(&of_sub, "datatype").is_some() { of_sub } else { format!("{index:04x}") };
            let object = self.ini.get(&format!("{index:04x}"), "parametername");
            let inner = self.ini.get(&section, "parametername");
            let name = match (object, inner) {
                (Some(object), Some(inner)) if object != inner => format!("{object}, {inner}"),
                (Some(name), _) | (None, Some(name)) => name,
                (None, None) => format!("{index:04X}h sub {sub:02X}h"),
            };
            let data_type = self.number(&section, "datatype")?.unwrap_or(0);
            fields.push(Field { name, data_type, bits });
        }
        Ok(fields)
    }

    /// The value of an object: what the device has, or else its default. `None`: there is no such object.
    fn value(&self, section: &str) -> Result<Option<u32>, String> {
        match self.number(section, "parametervalue")? {
            None => self.number(section, "defaultvalue"),
            value => Ok(value),
        }
    }

    /// A number, decimal or with `0x`; `$NODEID+` adds the Node-ID (CiA 306).
    fn number(&self, section: &str, key: &str) -> Result<Option<u32>, String> {
        let Some(text) = self.ini.get(section, key).filter(|text| !text.trim().is_empty()) else {
            return Ok(None);
        };
        let upper = text.trim().to_uppercase();
        let (base, digits) = match upper.strip_prefix("$NODEID+") {
            Some(digits) => (u32::from(self.node), digits),
            None => (0, upper.as_str()),
        };
        let value = match digits.strip_prefix("0X") {
            Some(digits) => u32::from_str_radix(digits, 16),
            None => digits.parse(),
        };
        let sum = value.ok().and_then(|value| value.checked_add(base));
        sum.map(Some).ok_or_else(|| format!("[{section}] {key}: '{text}' is no number of 32 bits"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[1800sub1]\nDefaultValue=$NODEID+0x180\n[1801sub1]\nDefaultValue=$NODEID+0x80000280\n\
        [1802sub1]\nDefaultValue=0x40000382\n\
        [1A00sub0]\nDefaultValue=3\n[1A00sub1]\nDefaultValue=0x20000110\n[1A00sub2]\nDefaultValue=0x20010008\n\
        [1A00sub3]\nDefaultValue=0x20020020\n[1A02sub0]\nDefaultValue=0\n\
        [2000]\nParameterName=Heater\n[2000sub1]\nParameterName=Temperature\nDataType=0x0003\n\
        [2001]\nParameterName=State\nDataType=0x0005\n[2002]\nParameterName=Power\nDataType=0x0008\n";

    #[test]
    fn valid_pdos_with_objects_are_read() {
        let sheet = Sheet::read(TEXT, 5).unwrap();
        assert_eq!(sheet.pdos.len(), 1);
        let Pdo { number, id, fields } = &sheet.pdos[0];
        assert_eq!((*number, *id), (1, 0x185));
        let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
        assert_eq!(names, ["Heater, Temperature", "State", "Power"]);
    }

    /// Given the bytes of -5, 200 and 1.5 as IEEE 754 has it (3FC0 0000h), then they are values with names.
    #[test]
    fn frames_are_values_by_name() {
        let sheet = Sheet::read(TEXT, 5).unwrap();
        let values = sheet.pdos[0].values(&[0xFB, 0xFF, 200, 0, 0, 0xC0, 0x3F]).unwrap();
        let expected = [("Heater, Temperature", "-5"), ("State", "200"), ("Power", "1.5")];
        assert_eq!(values, expected.map(|(name, value)| (name, value.to_owned())));
        assert_eq!(sheet.pdos[0].values(&[0; 8]), None, "another length");
    }

    #[test]
    fn value_of_a_dcf_counts_before_the_default() {
        let text = TEXT.replacen("DefaultValue=", "ParameterValue=0x201\nDefaultValue=", 1);
        assert_eq!(Sheet::read(&text, 5).unwrap().pdos[0].id, 0x201);
    }

    #[test]
    fn an_entry_that_is_no_number_is_an_error() {
        let error = Sheet::read(&TEXT.replace("$NODEID+0x180", "some"), 5).unwrap_err();
        assert!(error.contains("'some' is no number"), "{error}");
    }
}
