//! A field of a declaration: its name, its type, its value at power-on.

use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::ext::IdentExt;
use syn::parse::ParseStream;
use syn::spanned::Spanned;
use syn::{Attribute as Syntax, DeriveInput, Error, Expr, ExprLit, Field, Ident, Lit, Meta, Type, TypeArray};

use crate::attribute::Attribute;
use crate::errors::Errors;
use crate::path;
use crate::spelling;

/// Returns the attribute with this name, if the field has it.
///
/// # Errors
/// If the field has more than one.
pub fn attribute<'a>(field: &'a Field, name: &str) -> syn::Result<Option<&'a Syntax>> {
    let mut all = field.attrs.iter().filter(|attribute| attribute.path().is_ident(name));
    match (all.next(), all.next()) {
        (_, Some(second)) => Err(Error::new_spanned(second, format!("a field has one `#[{name}]`"))),
        (first, None) => Ok(first),
    }
}

/// Declaration of a field: a value, a group, or skipped.
pub enum Declared {
    /// A value, an object or a sub-index.
    Value(Box<Attribute>),
    /// A group of objects, declared by a struct of its own.
    Group,
    /// A field that no client sees.
    Skipped,
    /// The name of its attribute is misspelled, which the compiler reports: this one is meant.
    Misspelled(&'static str),
}

/// Returns how a field is declared. `value` is the name of the attribute of a value, `group` that of a group.
///
/// # Errors
/// If the field has no declaration, or two.
pub fn declared(field: &Field, value: &'static str, group: Option<&'static str>) -> syn::Result<Declared> {
    let group_syntax = group.map(|group| attribute(field, group)).transpose()?.flatten();
    let found = [attribute(field, value)?, group_syntax, attribute(field, "skip")?];
    let mut others = found.iter().flatten().skip(1);
    if let Some(other) = others.next() {
        return Err(Error::new_spanned(other, "the field is declared by another attribute already"));
    }
    match found {
        [Some(syntax), ..] => syntax.parse_args().map(|attribute| Declared::Value(Box::new(attribute))),
        [_, Some(syntax), _] => syntax.meta.require_path_only().map(|_| Declared::Group),
        [_, _, Some(syntax)] => syntax.meta.require_path_only().map(|_| Declared::Skipped),
        _ => {
            let is_meant = |name: &&str| field.attrs.iter().any(|syntax| spelling::resembles(syntax, name));
            if let Some(name) = [value, "skip"].into_iter().chain(group).find(is_meant) {
                return Ok(Declared::Misspelled(name));
            }
            let group = group.map_or(String::new(), |group| format!(", `#[{group}]`"));
            let message = format!(
                "missing declaration: add `#[{value}(..)]`{group} or, for a field that no client sees, `#[skip]`"
            );
            Err(Error::new_spanned(&field.ident, message))
        }
    }
}

/// Returns the attribute with this name, as much as can be read of it. Its name may be misspelled.
pub fn sketched(field: &Field, name: &str) -> Attribute {
    let is_meant = |syntax: &&Syntax| syntax.path().is_ident(name) || spelling::resembles(syntax, name);
    let read = |syntax: &Syntax| {
        let reader = |input: ParseStream| Ok(Attribute::read(input, &mut Errors::default()));
        syntax.parse_args_with(reader).ok()
    };
    field.attrs.iter().find(is_meant).and_then(read).unwrap_or_else(|| Attribute::of(None, false))
}

/// Returns the name of a field.
pub fn ident(field: &Field) -> syn::Result<&Ident> {
    field.ident.as_ref().ok_or_else(|| Error::new_spanned(field, "its values need names"))
}

/// Returns the name in EDS and DCF: the first line of the documentation.
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
    let message = "missing name: the first line of its documentation (`/// ..`) is its name in EDS and DCF";
    first.filter(|text| !text.is_empty()).ok_or_else(|| Error::new_spanned(&field.ident, message))
}

/// Returns the constant of a field. It has the name of the field in capitals and the same visibility.
pub fn constant(field: &Field, number: &str, of: &TokenStream, value: &TokenStream) -> Option<TokenStream> {
    let name = field.ident.as_ref()?;
    let constant = Ident::new(&name.unraw().to_string().to_uppercase(), name.span());
    let (visibility, doc) = (&field.vis, format!("Address of `{name}`: {number}."));
    Some(quote! {
        #[doc = #doc]
        #[allow(dead_code)]
        #visibility const #constant: #of = #value;
    })
}

/// Returns the type of an array field.
pub fn array(field: &Field) -> syn::Result<&TypeArray> {
    match &field.ty {
        Type::Array(array) => Ok(array),
        other => Err(Error::new_spanned(other, "several in a row need an array")),
    }
}

/// Returns the length of an array as a number of sub-indices. A length above 254 is an error at its place.
pub fn sub_indices(len: &Expr) -> TokenStream {
    let krate = path::canopen_at(len.span());
    quote_spanned!(len.span()=> #krate::od::sub_indices(#len))
}

/// Returns the value at power-on.
pub fn initial(field: &Field, declared: Option<&Attribute>) -> TokenStream {
    let krate = path::canopen();
    let of = &field.ty;
    match (declared.and_then(|attribute| attribute.default.as_ref().map(|value| (attribute, value))), of) {
        (Some((attribute, _)), _) if attribute.is_limited() => {
            let number = &attribute.number;
            quote!(<Self as #krate::od::Initial<#of, #number>>::VALUE)
        }
        (Some((_, value)), _) => quote!(#value),
        (None, _) => unwritten(of),
    }
}

/// Returns the value at power-on of a field without `default`.
fn unwritten(of: &Type) -> TokenStream {
    let krate = path::canopen();
    if let Type::Array(array) = of {
        let element = unwritten(&array.elem);
        return quote!(::core::array::from_fn(|_| #element));
    }
    // The error of a type without default stands at the type.
    let function = Ident::new("unwritten", of.span());
    quote!({
        #[allow(unused_imports)]
        use #krate::od::Unwritten as _;
        <#of>::#function()
    })
}

/// Returns the value at power-on as a constant, for a value that has limits. Their check reads it.
pub fn initial_constant(input: &DeriveInput, field: &Field, attribute: &Attribute) -> Option<TokenStream> {
    let krate = path::canopen();
    let value = attribute.default.as_ref().filter(|_| attribute.is_limited())?;
    let (ident, of, number) = (&input.ident, &field.ty, &attribute.number);
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    Some(quote! {
        impl #impl_generics #krate::od::Initial<#of, #number> for #ident #type_generics #bounds {
            const VALUE: #of = #value;
        }
    })
}

/// Returns a statement that asks of a type what its declaration asks. In another function that uses the type, it makes
/// the error of a wrong type the same one, which the compiler shows once.
pub fn same_error(of: &Type) -> TokenStream {
    let krate = path::canopen();
    quote!(let _ = #krate::od::Entry::of::<#of>;)
}

/// Returns the values with a name, those of an enumeration, as an expression.
pub fn named(of: &Type) -> TokenStream {
    let krate = path::canopen();
    let same_error = same_error(of);
    quote!({
        #same_error
        <#of as #krate::od::Typed>::VALUES
    })
}

/// Returns a statement that refuses a number which is no value of its type, if the condition `is_meant` holds.
pub fn check(is_meant: &TokenStream, of: &Type) -> TokenStream {
    let krate = path::canopen();
    let same_error = same_error(of);
    quote! {
        #same_error
        #krate::od::checked::value_of::<#of>(#is_meant, value)?;
    }
}

/// Returns the expression by which a transmit PDO reads a value of this type.
pub fn bits(value: &TokenStream, of: &Type) -> TokenStream {
    let krate = path::canopen();
    let same_error = same_error(of);
    quote!({
        #same_error
        ::core::option::Option::Some(<#of as #krate::od::Variable>::bits(#value))
    })
}

/// Returns the expression by which a transmit PDO reads consecutive values.
pub fn run_bits(values: &TokenStream, nth: &TokenStream, of: &Type) -> TokenStream {
    let same_error = same_error(of);
    quote!({
        #same_error
        run.read::<#of>(&#values[..], #nth)
    })
}

/// Returns the expression by which a receive PDO writes consecutive values. It writes only values within the
/// limits.
pub fn set_run_bits(
    values: &TokenStream,
    nth: &TokenStream,
    of: &Type,
    attribute: &Attribute,
) -> TokenStream {
    let krate = path::canopen();
    let same_error = same_error(of);
    if !attribute.is_limited() {
        return quote!({
            #same_error
            run.write::<#of>(&mut #values[..], #nth, bits)
        });
    }
    let limits = attribute.limits();
    quote!({
        #same_error
        const LIMITS: ::core::option::Option<&#krate::od::Limits> = #limits;
        run.write_within::<#of>(&mut #values[..], #nth, bits, LIMITS?)
    })
}

/// Returns the expression by which a receive PDO writes a value. It writes only a value of its type within the limits.
pub fn set_bits(value: &TokenStream, of: &Type, attribute: &Attribute) -> TokenStream {
    let krate = path::canopen();
    let same_error = same_error(of);
    let write = quote! {
        if !<#of as #krate::od::Typed>::is_value(bits) {
            return ::core::option::Option::None;
        }
        ::core::option::Option::Some(<#of as #krate::od::Variable>::set_bits(#value, bits))
    };
    if !attribute.is_limited() {
        return quote!({
            #same_error
            #write
        });
    }
    let limits = attribute.limits();
    quote!({
        #same_error
        const LIMITS: ::core::option::Option<&#krate::od::Limits> = #limits;
        LIMITS?.check(<#of as #krate::od::Typed>::TYPE, bits).ok()?;
        #write
    })
}
