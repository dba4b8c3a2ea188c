//! A field of a declaration: its name, its type, its value at power-on.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Attribute as Syntax, Error, Expr, ExprLit, Field, Ident, Lit, Meta, Type, TypeArray};

use crate::attribute::Attribute;

/// The attribute with this name, if the field has it.
pub fn attribute<'a>(field: &'a Field, name: &str) -> Option<&'a Syntax> {
    field.attrs.iter().find(|attribute| attribute.path().is_ident(name))
}

/// The name of a field.
pub fn ident(field: &Field) -> syn::Result<&Ident> {
    field.ident.as_ref().ok_or_else(|| Error::new_spanned(field, "its values need names"))
}

/// The first line of its documentation: what it is called in EDS and DCF.
pub fn title(field: &Field) -> syn::Result<String> {
    let lines = field.attrs.iter().filter(|attribute| attribute.path().is_ident("doc"));
    let texts = lines.filter_map(|line| match &line.meta {
        Meta::NameValue(pair) => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    });
    let first = texts.map(|text| text.trim().trim_end_matches('.').to_owned()).next();
    let message = "what is it called? The first line of its documentation goes into EDS and DCF";
    first.filter(|text| !text.is_empty()).ok_or_else(|| Error::new_spanned(field, message))
}

/// The type of an array field.
pub fn array(field: &Field) -> syn::Result<&TypeArray> {
    match &field.ty {
        Type::Array(array) => Ok(array),
        other => Err(Error::new_spanned(other, "several in a row need an array")),
    }
}

/// The value at power-on.
pub fn initial(field: &Field, declared: Option<&Attribute>) -> TokenStream {
    match (declared.and_then(|attribute| attribute.default.as_ref()), &field.ty) {
        (Some(value), _) => quote!(#value),
        (None, Type::Array(_)) => {
            quote!(::core::array::from_fn(|_| ::core::default::Default::default()))
        }
        (None, _) => quote!(::core::default::Default::default()),
    }
}

/// What a transmit PDO reads of a value.
pub fn bits(value: &TokenStream) -> TokenStream {
    quote!(::core::option::Option::Some(::ecss_can::od::Variable::bits(#value)))
}

/// What a transmit PDO reads of several in a row.
pub fn run_bits(values: &TokenStream, nth: &TokenStream) -> TokenStream {
    quote!(run.read(&#values[..], #nth))
}

/// What a receive PDO writes to several in a row, with limits only what keeps them.
pub fn set_run_bits(values: &TokenStream, nth: &TokenStream, attribute: &Attribute) -> TokenStream {
    if attribute.low.is_none() && attribute.high.is_none() {
        return quote!(run.write(&mut #values[..], #nth, bits));
    }
    let limits = attribute.limits();
    quote!({
        const LIMITS: ::core::option::Option<&::ecss_can::od::Limits> = #limits;
        run.write_within(&mut #values[..], #nth, bits, LIMITS?)
    })
}

/// What a receive PDO writes to a value, with limits only what keeps them.
pub fn set_bits(value: &TokenStream, of: &Type, attribute: &Attribute) -> TokenStream {
    let write = quote!(::core::option::Option::Some(::ecss_can::od::Variable::set_bits(#value, bits)));
    if attribute.low.is_none() && attribute.high.is_none() {
        return write;
    }
    let limits = attribute.limits();
    quote!({
        const LIMITS: ::core::option::Option<&::ecss_can::od::Limits> = #limits;
        LIMITS?.check(<#of as ::ecss_can::od::Typed>::TYPE, bits).ok()?;
        #write
    })
}
