//! PDOs of a data sheet at power-on.

use std::fmt::Display;

use async_canopen_eds::{DataSheet, Unreadable};
use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::quoted;
use super::values::{Kind, Value, kind};

/// First records of both directions, and the distance to those of the mapping.
const RECEIVED: u16 = 0x1400;
const TRANSMITTED: u16 = 0x1800;
const TO_MAPPING: u16 = 0x200;
const MOST: u16 = 512;

/// Bits of a COB-ID (CiA 301 7.5.2.35).
const INVALID: u32 = 1 << 31;
const EXTENDED: u32 = 1 << 29;
const ID: u32 = 0x7FF;

/// Most values of a PDO, and most bits.
const VALUES: u32 = 8;
const BITS: u32 = 64;

/// A valid PDO.
pub struct Pdo {
    is_transmitted: bool,
    number: u16,
    /// What it carries, or why it has no constant.
    pub mapped: Result<Mapped, String>,
}

/// What a PDO carries.
pub struct Mapped {
    pub id: CobId,
    pub parts: Vec<Part>,
}

/// COB-ID, or the base to which the Node-ID is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CobId {
    Fixed(u16),
    Node(u16),
}

/// Value that a PDO carries.
#[derive(Debug, PartialEq, Eq)]
pub enum Part {
    Object {
        at: (u16, u8),
        title: String,
        data_type: u32,
    },
    /// The receiver has no object for it.
    Gap {
        data_type: u32,
    },
}

/// Returns the valid PDOs. A number that cannot be read is wrong.
pub fn of(sheet: &DataSheet, values: &[Value], wrong: &mut dyn FnMut(&dyn Display)) -> Vec<Pdo> {
    let mut pdos = Vec::new();
    for index in sheet.indices() {
        let (is_transmitted, first) = match index {
            _ if (RECEIVED..RECEIVED + MOST).contains(&index) => (false, RECEIVED),
            _ if (TRANSMITTED..TRANSMITTED + MOST).contains(&index) => (true, TRANSMITTED),
            _ => continue,
        };
        match mapped(sheet, values, index, is_transmitted) {
            Ok(Some(mapped)) => pdos.push(Pdo { is_transmitted, number: index - first + 1, mapped }),
            Ok(None) => {}
            Err(error) => wrong(&error),
        }
    }
    pdos
}

/// What the PDO of a record carries. `None`: the PDO is not valid.
fn mapped(
    sheet: &DataSheet,
    values: &[Value],
    index: u16,
    is_transmitted: bool,
) -> Result<Option<Result<Mapped, String>>, Unreadable> {
    let id = match cob_id(sheet, index)? {
        Some(Ok(id)) => id,
        Some(Err(reason)) => return Ok(Some(Err(reason))),
        None => return Ok(None),
    };
    let mapping = index + TO_MAPPING;
    let number = |sub| Ok(sheet.object(mapping, sub, 0)?.map(|value| value.number));
    let count = match number(0)? {
        Some(count @ 0..=VALUES) => count as u8,
        Some(count) => {
            return Ok(Some(Err(format!("{mapping:04X}h maps {count} values, at most 8 are allowed"))));
        }
        None => return Ok(Some(Err(format!("{mapping:04X}h sub-index 0 has no default")))),
    };
    let (mut parts, mut all) = (Vec::new(), 0);
    for sub in 1..=count {
        let Some(entry) = number(sub)? else {
            return Ok(Some(Err(format!("{mapping:04X}h sub-index {sub} has no default"))));
        };
        if entry == 0 {
            continue;
        }
        match part(entry, values, is_transmitted) {
            Ok(part) => parts.push(part),
            Err(reason) => return Ok(Some(Err(reason))),
        }
        all += entry & 0xFF;
    }
    Ok(Some(match all {
        0 => Err(format!("{mapping:04X}h maps nothing")),
        1..=BITS => Ok(Mapped { id, parts }),
        _ => Err(format!("{mapping:04X}h maps {all} bits, at most 64 are allowed")),
    }))
}

/// COB-ID of a record, or the reason why it has none that is allowed. `None`: the PDO is not valid.
pub fn cob_id(sheet: &DataSheet, index: u16) -> Result<Option<Result<CobId, String>>, Unreadable> {
    let at = |node| Ok::<_, Unreadable>(sheet.object(index, 1, node)?.map(|value| value.number));
    let (Some(base), Some(last)) = (at(0)?, at(127)?) else {
        return Ok(Some(Err(format!("{index:04X}h sub-index 1 has no default"))));
    };
    if last & INVALID != 0 {
        return Ok(None);
    }
    if last & EXTENDED != 0 {
        return Ok(Some(Err("its COB-ID has 29 bits".into())));
    }
    let raw = (base & ID) as u16;
    let (id, mut all) = match last.wrapping_sub(base) {
        0 => (CobId::Fixed(raw), raw..=raw),
        127 => (CobId::Node(raw), raw + 1..=raw + 127),
        _ => {
            return Ok(Some(Err("its COB-ID follows the Node-ID in another way than base + Node-ID".into())));
        }
    };
    Ok(Some(match all.find(|raw| !is_allowed(*raw)) {
        None => Ok(id),
        Some(raw) => Err(format!(
            "COB-ID {raw:03X}h is not for PDOs: allowed are 081h to 100h, 181h to 580h, 600h, 680h to 6DFh and 700h"
        )),
    }))
}

/// As `CobIdOf` has it (CiA 301 7.3.5).
fn is_allowed(raw: u16) -> bool {
    matches!(raw, 0x081..=0x100 | 0x181..=0x580 | 0x600 | 0x680..=0x6DF | 0x700)
}

/// The value of an entry of a mapping.
fn part(entry: u32, values: &[Value], is_transmitted: bool) -> Result<Part, String> {
    let (index, sub, bits) = ((entry >> 16) as u16, (entry >> 8) as u8, entry & 0xFF);
    let is_dummy = !is_transmitted && matches!(index, 0x01..=0x07) && sub == 0;
    let value = values.iter().find(|value| value.at == (index, sub));
    let data_type = match value {
        Some(value) => value.data_type,
        None if is_dummy => index.into(),
        None => {
            return Err(format!(
                "it carries {index:04X}h sub-index {sub}, which is no value of the data sheet"
            ));
        }
    };
    match kind(data_type) {
        Some(Kind { bits: Some(own), .. }) if own == bits => {}
        Some(Kind { bits: Some(own), name, .. }) => {
            return Err(format!(
                "it carries {bits} bits of {index:04X}h sub-index {sub}, whose type {name} has {own}"
            ));
        }
        _ => return Err(format!("it carries {index:04X}h sub-index {sub}, which is no number")),
    }
    Ok(match value {
        Some(value) => Part::Object { at: value.at, title: value.title.clone(), data_type },
        None => Part::Gap { data_type },
    })
}

impl Part {
    fn data_type(&self) -> u32 {
        match self {
            Part::Object { data_type, .. } | Part::Gap { data_type } => *data_type,
        }
    }

    fn documentation(&self) -> String {
        match self {
            Part::Object { title, .. } => quoted(title),
            Part::Gap { data_type } => {
                kind(*data_type).map_or_else(String::new, |kind| format!("a gap ({})", kind.name))
            }
        }
    }
}

impl Pdo {
    /// Returns the name of its constant.
    pub fn name(&self) -> String {
        format!("{}PDO_{}", if self.is_transmitted { 'T' } else { 'R' }, self.number)
    }

    /// Declares its constant. `names` gives the constant of an object.
    pub fn constant<'a>(
        &self,
        mapped: &Mapped,
        krate: &TokenStream,
        names: impl Fn((u16, u8)) -> Option<&'a String>,
    ) -> TokenStream {
        let name = format_ident!("{}", self.name());
        let (id, shown) = match mapped.id {
            CobId::Fixed(raw) => (quote!(fixed(#raw)), format!("{raw:03X}h")),
            CobId::Node(base) => (quote!(node(#base)), format!("{base:03X}h + node")),
        };
        let kinds = mapped.parts.iter().filter_map(|part| kind(part.data_type()));
        let types: Vec<TokenStream> = kinds.map(|kind| kind.rust(krate)).collect();
        let calls = mapped.parts.iter().zip(&types).map(|(part, rust)| match part {
            Part::Object { at, .. } => {
                let object = names(*at).map(|name| format_ident!("{name}"));
                // The node has this mapping, whatever `PDOMapping` says.
                quote!(.map(Self::#object.mappable()))
            }
            Part::Gap { .. } => quote!(.skip::<#rust>()),
        });
        let titles: Vec<String> = mapped.parts.iter().map(Part::documentation).collect();
        let direction = if self.is_transmitted { "Transmit" } else { "Receive" };
        let documentation =
            format!("{direction} PDO {}, COB-ID {shown}: {}.", self.number, titles.join(", "));
        quote! {
            #[doc = #documentation]
            pub const #name: #krate::pdo::Pdo<Self, (#(#types,)*)> =
                #krate::pdo::Pdo::new(#krate::pdo::CobIdOf::#id) #(#calls)*;
        }
    }
}
