//! Values of a data sheet: address, type and access right.

use std::fmt::Display;

use async_canopen_eds::{DataSheet, Entry, Unreadable, of_object};
use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::quoted;

/// Object codes whose object has no value: DEFTYPE, DEFSTRUCT, NULL (CiA 301 table 42).
const WITHOUT_VALUE: [u32; 3] = [0x0, 0x5, 0x6];
/// Object code DOMAIN, and its data type.
const DOMAIN: (u32, u32) = (0x2, 0x0F);
/// Data type of sub-index 0.
const UNSIGNED8: u32 = 0x05;

/// A VAR, or a sub-index of an ARRAY or a RECORD.
pub struct Value {
    pub at: (u16, u8),
    is_var: bool,
    /// Name in the data sheet: of the object, and of the sub-index behind a comma.
    pub title: String,
    pub data_type: u32,
    access: Access,
    is_mappable: bool,
}

/// `AccessType` of a data sheet.
struct Access {
    word: String,
    is_readable: bool,
    is_writable: bool,
}

/// A data type that this crate knows.
pub struct Kind {
    pub name: &'static str,
    /// Bits in a PDO. `None`: no PDO carries it.
    pub bits: Option<u32>,
    of: Of,
}

enum Of {
    /// A type of the language.
    Primitive(&'static str),
    /// A type of the module `od`.
    Own(&'static str),
    /// A type of the module `od` with a capacity, of which a data sheet says nothing.
    Text(&'static str, usize),
    Domain,
}

/// Returns the type with this index (CiA 301 table 44). `None`: there is none of this name in the crate.
pub fn kind(data_type: u32) -> Option<Kind> {
    use Of::{Domain, Own, Primitive, Text};
    let (name, bits, of) = match data_type {
        0x01 => ("BOOLEAN", 1, Primitive("bool")),
        0x02 => ("INTEGER8", 8, Primitive("i8")),
        0x03 => ("INTEGER16", 16, Primitive("i16")),
        0x04 => ("INTEGER32", 32, Primitive("i32")),
        0x05 => ("UNSIGNED8", 8, Primitive("u8")),
        0x06 => ("UNSIGNED16", 16, Primitive("u16")),
        0x07 => ("UNSIGNED32", 32, Primitive("u32")),
        0x08 => ("REAL32", 32, Primitive("f32")),
        0x09 => ("VISIBLE_STRING", 0, Text("VisibleString", 255)),
        0x0A => ("OCTET_STRING", 0, Text("OctetString", 255)),
        0x0B => ("UNICODE_STRING", 0, Text("UnicodeString", 254)),
        0x0C => ("TIME_OF_DAY", 48, Own("TimeOfDay")),
        0x0D => ("TIME_DIFFERENCE", 48, Own("TimeDifference")),
        0x0F => ("DOMAIN", 0, Domain),
        0x10 => ("INTEGER24", 24, Own("I24")),
        0x11 => ("REAL64", 64, Primitive("f64")),
        0x12 => ("INTEGER40", 40, Own("I40")),
        0x13 => ("INTEGER48", 48, Own("I48")),
        0x14 => ("INTEGER56", 56, Own("I56")),
        0x15 => ("INTEGER64", 64, Primitive("i64")),
        0x16 => ("UNSIGNED24", 24, Own("U24")),
        0x18 => ("UNSIGNED40", 40, Own("U40")),
        0x19 => ("UNSIGNED48", 48, Own("U48")),
        0x1A => ("UNSIGNED56", 56, Own("U56")),
        0x1B => ("UNSIGNED64", 64, Primitive("u64")),
        _ => return None,
    };
    Some(Kind { name, bits: (bits > 0).then_some(bits), of })
}

impl Kind {
    /// Returns the type in the language.
    pub fn rust(&self, krate: &TokenStream) -> TokenStream {
        match self.of {
            Of::Primitive(name) => {
                let name = format_ident!("{name}");
                quote!(::core::primitive::#name)
            }
            Of::Own(name) => {
                let name = format_ident!("{name}");
                quote!(#krate::od::#name)
            }
            Of::Text(name, capacity) => {
                let name = format_ident!("{name}");
                quote!(#krate::od::#name<#capacity>)
            }
            Of::Domain => quote!(#krate::od::Domain<[::core::primitive::u8; 0]>),
        }
    }
}

/// Returns the values of a data sheet, in the order of their addresses. A wrong one is left out.
pub fn of(sheet: &DataSheet, wrong: &mut dyn FnMut(&dyn Display)) -> Vec<Value> {
    let mut values = Vec::new();
    for index in sheet.indices() {
        match addresses(sheet, index) {
            Err(error) => wrong(&error),
            Ok((subs, is_var)) => {
                for sub in subs {
                    match value(sheet, (index, sub), is_var) {
                        Ok(value) => values.push(value),
                        Err(error) => wrong(&error),
                    }
                }
            }
        }
    }
    values
}

/// Sub-indices of an object with a value, and whether it is a VAR.
fn addresses(sheet: &DataSheet, index: u16) -> Result<(Vec<u8>, bool), Unreadable> {
    let code = object_code(sheet, index)?;
    if code.is_some_and(|code| WITHOUT_VALUE.contains(&code)) {
        return Ok((Vec::new(), false));
    }
    let subs = sheet.sub_indices(index)?;
    let has_several = matches!(code, Some(0x8 | 0x9)) || !subs.is_empty();
    Ok(if has_several { (subs, false) } else { (vec![0], true) })
}

fn object_code(sheet: &DataSheet, index: u16) -> Result<Option<u32>, Unreadable> {
    Ok(sheet.number(&of_object(index), "ObjectType", 0)?.map(|value| value.number))
}

fn value(sheet: &DataSheet, (index, sub): (u16, u8), is_var: bool) -> Result<Value, Unreadable> {
    let title = sheet.name(index, sub);
    let at = (index, sub);
    // CiA 306: `NrOfObjects` of a compact object has no entries of its own.
    if sub == 0 && sheet.is_compact(index, sub)? {
        let access = Access { word: "ro".into(), is_readable: true, is_writable: false };
        let title = format!("{title}, Number of objects");
        return Ok(Value { at, is_var, title, data_type: UNSIGNED8, access, is_mappable: false });
    }
    let is_domain = is_var && object_code(sheet, index)? == Some(DOMAIN.0);
    let data_type = match (sheet.data_type(index, sub)?, is_domain) {
        (Some(data_type @ 1..=0xFFFF), _) => data_type,
        (None, true) => DOMAIN.1,
        (None, false) => return Err(missing(at, is_var, "DataType", "such as 0x0005 of an UNSIGNED8")),
        (Some(_), _) => {
            let entry = sheet.property(index, sub, "DataType");
            let error = |entry: &Entry| entry.wrong("no data type; allowed are 0x0001 to 0xFFFF");
            return Err(entry.map_or_else(|| Unreadable::missing("DataType"), error));
        }
    };
    let access = match sheet.property(index, sub, "AccessType") {
        Some(entry) => access(entry)?,
        // CiA 306: the default of a DOMAIN.
        None if is_domain => Access { word: "rw".into(), is_readable: true, is_writable: true },
        None => return Err(missing(at, is_var, "AccessType", "ro, wo, rw, rwr, rww or const")),
    };
    let mapping = sheet.property(index, sub, "PDOMapping");
    let is_mappable = mapping.is_some_and(|entry| entry.text().trim_start_matches("0x").starts_with('1'));
    Ok(Value { at, is_var, title, data_type, access, is_mappable })
}

fn missing((index, sub): (u16, u8), is_var: bool, key: &str, allowed: &str) -> Unreadable {
    let section = if is_var { of_object(index) } else { async_canopen_eds::of_sub(index, sub) };
    Unreadable::missing(&format!("[{section}] {key}: {allowed}"))
}

fn access(entry: &Entry) -> Result<Access, Unreadable> {
    let word = entry.text().to_ascii_lowercase();
    let (is_readable, is_writable) = match word.as_str() {
        "ro" | "const" => (true, false),
        "wo" => (false, true),
        "rw" | "rwr" | "rww" => (true, true),
        _ => return Err(entry.wrong("no access right; allowed are ro, wo, rw, rwr, rww and const")),
    };
    Ok(Access { word, is_readable, is_writable })
}

impl Value {
    /// Returns what makes its name another one than that of each other value.
    pub fn suffix(&self) -> String {
        let (index, sub) = self.at;
        if self.is_var { format!("_{index:04X}") } else { format!("_{index:04X}_{sub:02X}") }
    }

    /// Declares its constant.
    pub fn constant(&self, name: &str, krate: &TokenStream) -> TokenStream {
        let ((index, sub), name) = (self.at, format_ident!("{name}"));
        let Access { word, is_readable, is_writable } = &self.access;
        let kind = kind(self.data_type);
        let type_name = match &kind {
            Some(kind) => kind.name.to_owned(),
            None => format!("data type {:04X}h", self.data_type),
        };
        let documentation =
            format!("{}: {index:04X}h sub-index {sub}, {type_name}, `{word}`.", quoted(&self.title));
        let at = quote!(#krate::types::Address::new(#index, #sub));
        let Some(kind) = kind else {
            return quote! {
                #[doc = #documentation]
                pub const #name: #krate::od::Field = #krate::od::Field::raw(#at);
            };
        };
        let read = format_ident!("{}", if *is_readable { "Readable" } else { "NotReadable" });
        let written = format_ident!("{}", if *is_writable { "Writable" } else { "NotWritable" });
        let rust = kind.rust(krate);
        let mappable = (self.is_mappable && kind.bits.is_some()).then(|| quote!(.mappable()));
        quote! {
            #[doc = #documentation]
            pub const #name: #krate::od::Field<#rust, #krate::od::#read, #krate::od::#written> =
                #krate::od::Field::at(#at) #mappable;
        }
    }
}
