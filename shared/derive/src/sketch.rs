//! Declarations of fields that have an error: as much as is known, and usable by all that uses the field.
//!
//! A *sketch* may be read, written and mapped. So a wrong word in a declaration is not followed by an error about a
//! PDO of the same object.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::{DeriveInput, Field, Type, TypeArray};

use crate::attribute::{Attribute, Shape};
use crate::errors::Errors;
use crate::field::{self, Declared};
use crate::objects::{self, Object, element};
use crate::record::{self, Sub};
use crate::{instance, path};

/// Returns the objects of a declaration in rising order, and the types of its groups.
pub fn objects(input: &DeriveInput) -> (Vec<Object<'_>>, Vec<&Type>) {
    let (mut objects, mut groups): (Vec<Object<'_>>, Vec<&Type>) = (Vec::new(), Vec::new());
    for field in fields(input) {
        let right = match field::declared(field, "object", Some("objects")) {
            Ok(Declared::Group | Declared::Misspelled("objects")) => {
                groups.push(&field.ty);
                continue;
            }
            Ok(Declared::Skipped | Declared::Misspelled("skip")) => continue,
            Ok(Declared::Value(attribute)) => {
                without_error(|errors| objects::object(field, &attribute, errors))
            }
            Ok(Declared::Misspelled(_)) | Err(_) => None,
        };
        let is_free = |number: u16| objects.iter().all(|object| object.number != number);
        let object = right.filter(|object| is_free(object.number));
        objects.push(object.unwrap_or_else(|| object_of(field, is_free)));
    }
    objects.sort_by_key(|object| object.number);
    (objects, groups)
}

/// Returns the sub-indices of a declaration.
pub fn subs(input: &DeriveInput) -> Vec<Sub> {
    let sub = |field| match field::declared(field, "sub", None) {
        Ok(Declared::Skipped | Declared::Misspelled("skip")) => None,
        Ok(Declared::Value(attribute)) => {
            let right = without_error(|errors| record::sub(input, field, &attribute, errors));
            Some(right.unwrap_or_else(|| sub_of(input, field)))
        }
        _ => Some(sub_of(input, field)),
    };
    fields(input).filter_map(sub).collect()
}

fn fields(input: &DeriveInput) -> impl Iterator<Item = &Field> {
    crate::fields(input).into_iter().flat_map(|fields| &fields.named)
}

fn without_error<T>(declare: impl FnOnce(&mut Errors) -> Option<T>) -> Option<T> {
    let mut errors = Errors::default();
    declare(&mut errors).filter(|_| errors.finish().is_ok())
}

/// Returns the array of a field that should be one.
fn row<'a>(field: &'a Field, attribute: &Attribute) -> Option<&'a TypeArray> {
    attribute.in_a_row.then(|| field::array(field).ok()).flatten()
}

/// An object with an index that no other one has: its own, else one below.
fn object_of(field: &Field, is_free: impl Fn(u16) -> bool) -> Object<'_> {
    let krate = path::canopen();
    let attribute = field::sketched(field, "object");
    let mut number = attribute.value(u16::MAX).unwrap_or(u16::MAX);
    while !is_free(number) {
        number = number.wrapping_sub(1);
    }
    let (value, count) = match row(field, &attribute) {
        Some(array) => {
            let len = &array.len;
            (&*array.elem, quote!((#len) as u16))
        }
        None if attribute.in_a_row => (&field.ty, quote!(::core::primitive::u16::MAX - #number)),
        None => (&field.ty, quote!(1)),
    };
    let record = matches!(attribute.shape, Shape::Record { .. }).then_some(value);
    let entries = match record {
        Some(record) => quote!(<#record as #krate::od::Record>::ENTRIES),
        None => {
            let entry = entry(0, quote!(255));
            quote!(&[#entry])
        }
    };
    Object {
        number,
        declaration: quote!(#krate::od::Object { index: #number, count: #count, entries: #entries }),
        names: TokenStream::new(),
        field,
        record,
        element: element(value, &attribute),
        access_types: attribute.access_types(),
        is_single: attribute.shape == Shape::Var && !attribute.in_a_row,
        variable: TokenStream::new(),
        bits: None,
        set_bits: None,
        check: None,
    }
}

fn sub_of(input: &DeriveInput, field: &Field) -> Sub {
    let krate = path::canopen();
    let attribute = field::sketched(field, "sub");
    let number = attribute.value(254).unwrap_or(254);
    let first = number as u8;
    let (value, count) = match row(field, &attribute) {
        Some(array) => (&*array.elem, field::sub_indices(&array.len)),
        None if attribute.in_a_row => (&field.ty, quote!(255 - #first)),
        None => (&field.ty, quote!(1)),
    };
    let (filled, access_types) = (instance::filled(input, value.to_token_stream()), attribute.access_types());
    Sub {
        number,
        entry: entry(first, count.clone()),
        title: String::new(),
        values: TokenStream::new(),
        constant: field::constant(
            field,
            "unknown",
            &quote!(#krate::od::SubIndex<Self, #filled, #access_types>),
            &quote!(#krate::od::SubIndex::new(#first, #count)),
        ),
        arm: TokenStream::new(),
        bits: None,
        set_bits: None,
        check: None,
        last: TokenStream::new(),
    }
}

/// Values that everybody may read, write and map.
fn entry(first: u8, count: TokenStream) -> TokenStream {
    let krate = path::canopen();
    quote! {
        #krate::od::Entry::of::<::core::primitive::u8>(#first, #count, #krate::od::Access::Rw)
            .for_pdo(#krate::od::PdoUse::Required)
    }
}
