//! Declares an object dictionary as a struct, and the canonical form of a state machine at its fields.
//!
//! `#[derive(Objects)]` turns a struct of values into a dictionary, or into a group of objects of a dictionary.
//! `#[derive(Record)]` turns a struct into a record: several values under one index. Both implement `Default` with
//! the values of `default = ..`. The module `async_canopen::od` has an example.
//!
//! | attribute | stands on | meaning |
//! | --- | --- | --- |
//! | `#[object(0x1017, ..)]` | a field | an object |
//! | `#[object(0x1400.., ..)]` | an array field | objects with consecutive indices, one for each element |
//! | `#[objects]` | a field | a group of objects: another struct with `derive(Objects)` |
//! | `#[sub(1, ..)]` | a field of a record | a sub-index |
//! | `#[sub(1.., ..)]` | an array field of a record | consecutive sub-indices, one for each element |
//! | `#[record(0x40)]` | a record | index of its structure (DEFSTRUCT) |
//! | `#[skip]` | a field | no client sees the field; a field with none of these attributes is an error |
//! | `#[objects(check = function)]` | a struct | the function may refuse a value that a client writes |
//! | `#[objects(device)]` | a struct | the struct is the application of a `Device`, and is checked with its PDOs |
//! | `#[objects(device, sdo_servers = 2)]` | a struct | the device has a second SDO server (1201h), which a client configures |
//! | `#[objects(device, time)]` | a struct | the code beside it implements `DeviceTime` of `ecss-can`, otherwise the macro does |
//!
//! A second SDO server is an extension: Table 11-1 of ECSS-E-ST-50-15C omits 1201h, and Table 9-12 forbids it for the minimal set. It is for
//! slaves; a master with such a device does not compile.
//!
//! Inside the parentheses stand, separated by commas:
//!
//! - the access right: `ro`, `wo`, `rw`, `rwr`, `rww` or `constant`;
//! - `record` or `array` for an object that is more than a single value;
//! - `pdo` for a number, BOOLEAN or time that PDOs may carry, `optional` if a frame of a receive PDO may end before it;
//! - `keep` for a DOMAIN that "save" (1010h) stores, `volatile` for a value that "save" does not store;
//! - `low = ..` and `high = ..` for an integer: values of its type, `low` at most `high`;
//! - `default = ..`, the value at power-on. Beside `low` or `high` it is a constant expression within these limits.
//!
//! Each field becomes a constant with the name of the field in capitals: `async_canopen::od::Field` or `Fields` for an
//! object, `SubIndex` for an entry of a record. There each type parameter has its default, so that `Device::VALUE`
//! needs no argument.
//!
//! A value may be an enum that derives [`Enumeration`](macro@Enumeration). A struct that derives [`PdoValues`](macro@PdoValues) gives
//! the values of a PDO names.
//!
//! [`eds!`] makes such constants of the data sheet of another maker.
//!
//! `#[derive(Canonical)]` is for state machines: see [`macro@Canonical`].
//!
//! The expanded code names `async-canopen`, or `ecss-can`, which exports the same modules, by the name that the manifest of
//! the package gives it.
//!
//! # Errors
//!
//! The macro reports all errors of a declaration at once. What is wrong is declared in a form that other code can
//! use, so that a mistake is one error. A constant beside the declaration refuses an index or
//! sub-index that occurs twice, also across groups and consecutive indices. So `cargo check` shows the error. A
//! declaration that has a type parameter without a default is checked where its `Default` is used.
//!
//! Related crates: [`async-canopen`](https://docs.rs/async-canopen),
//! [`async-canopen-eds`](https://docs.rs/async-canopen-eds), [`ecss-can`](https://docs.rs/ecss-can).

mod attribute;
mod canonical;
mod eds;
mod enumeration;
mod errors;
mod field;
mod horizon;
mod instance;
mod objects;
mod path;
mod pdo_values;
mod record;
mod sketch;
mod spelling;
mod stub;
#[cfg(test)]
mod tests;

use errors::Errors;
use proc_macro::TokenStream;
use proc_macro2::TokenStream as TokenStream2;
use syn::{Data, DeriveInput, Error, Fields, FieldsNamed, parse_macro_input};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Makes a struct a dictionary, or a group of objects of a dictionary.
#[proc_macro_derive(Objects, attributes(object, objects, skip))]
pub fn objects(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    objects::expand(&input).unwrap_or_else(|errors| beside(errors, stub::objects(&input))).into()
}

/// Makes a struct a record: several values under one index.
#[proc_macro_derive(Record, attributes(record, sub, skip))]
pub fn record(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    record::expand(&input).unwrap_or_else(|errors| beside(errors, stub::record(&input))).into()
}

/// Makes an enum without fields a number of the object dictionary, for values that are one of a few.
///
/// `async_canopen::od::Enumeration` has an example.
///
/// The enum has `#[repr(u8)]`, or `u16`, `u32`, `i8`, `i16`, `i32`: the size and the data type of the value. It also implements `Copy` and
/// `Default`. A field has the variant of `Default` at power-on, or that of `default = Mode::Auto`.
///
/// A number without a variant is never a value of a field:
///
/// | it comes by | what happens |
/// | --- | --- |
/// | SDO write to the device | abort 06090030h; the value stays |
/// | receive PDO of the device | as with a value outside `low` and `high`: the value stays, EMCY 8200h, no event of the PDO |
/// | parameter store | the stored value is not applied |
/// | SDO read by a client of this crate | `sdo::Error::UnknownValue` with the number |
/// | PDO from another node | `ReceivedPdo::get` returns `None` |
///
/// A value with `optional` needs a variant with the number 0: a frame that ends before the value carries zero.
///
/// `low` and `high` of a field take integers, and allow fewer of the variants. The data sheet (EDS) has the least and the greatest number
/// as `LowLimit` and `HighLimit`, and a comment with the names of the variants.
///
/// # Errors
/// At the place of the mistake: a missing or another `repr`, fields of a variant, parameters of the enum.
#[proc_macro_derive(Enumeration)]
pub fn enumeration(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    enumeration::expand(&input).unwrap_or_else(|errors| beside(errors, enumeration::stub(&input))).into()
}

/// Makes a struct the values of a PDO, with names instead of places.
///
/// `async_canopen::pdo::PdoValues` has an example.
///
/// The fields are numbers, in the order in which the PDO carries them; at most eight. `Pdo::into_struct` ends the declaration of the PDO.
/// Other types, another order of types, or another number of values do not compile there.
///
/// # Errors
/// At the place of the mistake: fields without names, a ninth field, a field that is no number.
#[proc_macro_derive(PdoValues)]
pub fn pdo_values(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    pdo_values::expand(&input).unwrap_or_else(|errors| beside(errors, pdo_values::stub(&input))).into()
}

/// Implements the canonical form of a state machine: its instants relative to now, without ages that have no effect.
///
/// The trait `async_canopen::types::Canonical` has an example.
///
/// | attribute | stands on | meaning |
/// | --- | --- | --- |
/// | `#[canonical(context = Type)]` | a type | `Canonical::Context`: what the expressions need of the owner of the machine; `()` without it |
/// | `#[canonical(due)]` | instants | compared with now alone: all past ones are alike |
/// | `#[canonical(age = ..)]` | instants | the age has an effect up to this `Duration`; older ones are alike |
/// | `#[canonical(grid = ..)]` | instants | points of a grid with this period, a `Duration`: of past ones the last one counts |
/// | `#[canonical(within = ..)]` | a machine | its context; without the attribute the context is `()` |
/// | `#[canonical(each = ..)]` | an array of machines | a function from `usize`, the place in the array, to the context |
/// | `#[canonical(value = ..)]` | any field | value that the field takes before it is shifted, also beside another word |
///
/// Instants are an `Instant`, or an `Option`, an array, a `PerBus` of instants. One without an attribute does not
/// compile: its horizon is missing. A field without time needs no attribute.
///
/// Expressions may use `self`, `context`, a reference to the context, and `now`, an `Instant`. All of them are
/// evaluated before any field changes. A field whose type has a type parameter bounds the implementation, except for
/// `within` and `each`: there the declaration has the bound.
#[proc_macro_derive(Canonical, attributes(canonical))]
pub fn canonical(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    canonical::expand(&input).unwrap_or_else(|errors| beside(errors, canonical::stub(&input))).into()
}

/// Makes the constants of a node of another maker from its EDS (CiA 306), or from its DCF.
///
/// `async_canopen::od::eds` has an example.
///
/// The macro takes one or several structs, each with its file. The path is relative to the folder of the package's manifest
/// (`CARGO_MANIFEST_DIR`). A change of the file compiles the package again. Each struct becomes a struct without fields, with
/// these constants:
///
/// | in the file | constant |
/// | --- | --- |
/// | VAR, sub-index of an ARRAY or a RECORD | `Field`, with the type of `DataType` and the access right of `AccessType` |
/// | DOMAIN, string | `Field` whose value moves as bytes: `read_bytes`, `write_bytes` |
/// | value of a data type that the crate does not know | `Field::raw` |
/// | valid PDO with default values | `RPDO_n` or `TPDO_n`: a `Pdo`, with the COB-ID and the types of its values |
///
/// - The name is `ParameterName` in capitals. A sub-index has the name of its object before its own. Other characters than ASCII
///   letters and digits become `_`.
/// - A name that occurs twice ends with the index, `POWER_6001`, or with index and sub-index, `POWER_6001_02`. So does one that a PDO has.
/// - A name that begins with a digit begins with `_`.
/// - A value with `PDOMapping=1` may be mapped to further PDOs.
/// - `ParameterValue` of a DCF goes before `DefaultValue`.
/// - A PDO has no constant if a value that it carries is no number of the file with the same number of bits, or if its COB-ID is not for
///   PDOs. The documentation of the struct names it with the reason.
///
/// A string has no capacity in an EDS: those of the types (`VisibleString<255>`) have no meaning. Limits of values are not checked: the
/// node does that.
///
/// # Errors
/// At the path: a file that cannot be read or is no EDS, a value whose `DataType` or `AccessType` is missing or wrong, a number of a PDO
/// that is none. The other constants are usable.
#[proc_macro]
pub fn eds(input: TokenStream) -> TokenStream {
    let nodes = parse_macro_input!(input as eds::Nodes);
    let folder = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
    eds::expand(&nodes, std::path::Path::new(&folder)).into()
}

/// The errors, and what keeps the compiler from reporting others that follow from them.
fn beside(errors: Error, stub: TokenStream2) -> TokenStream2 {
    let mut tokens = Errors::texts(errors);
    tokens.extend(stub);
    tokens
}

/// The fields of a struct.
fn fields(input: &DeriveInput) -> syn::Result<&FieldsNamed> {
    match &input.data {
        Data::Struct(data) => match &data.fields {
            Fields::Named(fields) => Ok(fields),
            _ => Err(Error::new_spanned(&input.ident, "its values need names")),
        },
        _ => Err(Error::new_spanned(&input.ident, "only a struct can be declared so")),
    }
}
