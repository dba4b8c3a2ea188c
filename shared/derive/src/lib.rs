//! An object dictionary declared as a struct.
//!
//! `#[derive(Objects)]` makes a struct of values a dictionary or a group of its objects, `#[derive(Record)]` a structure
//! under one index. Both implement `Default` from the `default`s of the declaration. See `ecss_can::od` for an example.
//!
//! | attribute | of | meaning |
//! | --- | --- | --- |
//! | `#[object(0x1017, ..)]` | a field | an object |
//! | `#[object(0x1400.., ..)]` | an array field | objects with indices in a row, one for each element |
//! | `#[objects]` | a field | a group of objects: another struct with `derive(Objects)` |
//! | `#[sub(1, ..)]` | a field of a record | a sub-index |
//! | `#[sub(1.., ..)]` | an array field of a record | sub-indices in a row |
//! | `#[record(0x40)]` | a record | index of its structure (DEFSTRUCT) |
//! | `#[skip]` | a field | no client sees it; a field without any of these is an error |
//! | `#[objects(check = function)]` | a struct | the function refuses what clients write |
//! | `#[objects(device)]` | a struct | it is the application of a `Device`, which is checked with its PDOs |
//!
//! Inside the parentheses: `ro`, `wo`, `rw`, `rwr`, `rww` or `constant`; `record` or `array` for objects that are no
//! single value; `pdo` for values that PDOs may carry; `keep` for a DOMAIN that "save" (1010h) keeps, `volatile` for
//! a value that it does not keep; `low = ..`, `high = ..`, `default = ..`.
//!
//! Each field becomes a constant, named as the field in capitals: an `ecss_can::od::Field` or `Fields` of an object, a
//! `SubIndex` of an entry of a record. A type parameter with a default has it there, so that `Device::VALUE` needs no argument.
//!
//! All errors of a declaration are reported at once. An index or sub-index that two fields have, also in groups of groups and
//! in rows of them, is refused by a constant beside the declaration, so that `cargo check` shows it. A type parameter has its
//! default there; a declaration with a parameter without default is checked where its `Default` is used.

mod attribute;
mod errors;
mod field;
mod instance;
mod objects;
mod record;
mod stub;
#[cfg(test)]
mod tests;

use proc_macro::TokenStream;
use proc_macro2::TokenStream as TokenStream2;
use syn::{Data, DeriveInput, Error, Fields, FieldsNamed, parse_macro_input};

/// A dictionary, or a group of its objects.
#[proc_macro_derive(Objects, attributes(object, objects, skip))]
pub fn objects(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    objects::expand(&input).unwrap_or_else(|errors| beside(errors, stub::objects(&input))).into()
}

/// A structure of values under one index.
#[proc_macro_derive(Record, attributes(record, sub, skip))]
pub fn record(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    record::expand(&input).unwrap_or_else(|errors| beside(errors, stub::record(&input))).into()
}

/// The errors, and what keeps the compiler from reporting others that follow from them.
fn beside(errors: Error, stub: TokenStream2) -> TokenStream2 {
    let mut tokens = errors.into_compile_error();
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
