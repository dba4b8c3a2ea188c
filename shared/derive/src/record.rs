//! `#[derive(Record)]`.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{DeriveInput, Error, LitInt};

use crate::attribute::Attribute;
use crate::field;

/// A sub-index, or several in a row.
struct Sub {
    number: u16,
    entry: TokenStream,
    title: String,
    arm: TokenStream,
    /// The last sub-index, as an expression.
    last: TokenStream,
}

pub fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let mut subs = Vec::new();
    let mut initials = Vec::new();
    for field in &crate::fields(input)?.named {
        let name = field::ident(field)?;
        let declared = field::attribute(field, "sub").map(|syntax| syntax.parse_args()).transpose()?;
        let initial = field::initial(field, declared.as_ref());
        initials.push(quote!(#name: #initial));
        if let Some(attribute) = declared {
            subs.push(sub(field, &attribute)?);
        }
    }
    subs.sort_by_key(|sub| sub.number);
    if let Some(pair) = subs.windows(2).find(|pair| pair[0].number == pair[1].number) {
        let message = format!("sub-index {} is declared twice", pair[0].number);
        return Err(Error::new_spanned(&input.ident, message));
    }
    let Some(last) = subs.last().map(|sub| sub.last.clone()) else {
        return Err(Error::new_spanned(&input.ident, "a record has at least one #[sub(..)]"));
    };
    if subs.first().is_some_and(|first| first.number != 0) {
        let (entry, title) = (quote!(::ecss_can::od::Entry::highest(#last)), "Highest sub-index supported");
        subs.insert(0, Sub { number: 0, entry, title: title.into(), arm: quote!(), last: quote!() });
    }
    let (entries, titles, arms) = (
        subs.iter().map(|sub| &sub.entry),
        subs.iter().map(|sub| &sub.title),
        subs.iter().map(|sub| &sub.arm),
    );
    let structure = structure(input)?;
    let ident = &input.ident;
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    Ok(quote! {
        impl #impl_generics ::ecss_can::od::Record for #ident #type_generics #bounds {
            const ENTRIES: &'static [::ecss_can::od::Entry] = &[#(#entries),*];
            const NAMES: &'static [&'static str] = &[#(#titles),*];
            #structure

            fn variable(&mut self, sub: u8) -> ::core::option::Option<&mut dyn ::ecss_can::od::Variable> {
                match sub {
                    #(#arms)*
                    _ => ::core::option::Option::None,
                }
            }
        }

        impl #impl_generics ::core::default::Default for #ident #type_generics #bounds {
            fn default() -> Self {
                Self { #(#initials),* }
            }
        }
    })
}

fn sub(field: &syn::Field, attribute: &Attribute) -> syn::Result<Sub> {
    let name = field::ident(field)?;
    let number = attribute.value()?;
    let first = u8::try_from(number).map_err(|_| Error::new_spanned(&attribute.number, "at most 254"))?;
    let (access, limits, pdo) = (attribute.required_access()?, attribute.limits(), attribute.pdo);
    let (value, count, last, arm) = if attribute.in_a_row {
        let array = field::array(field)?;
        let (value, len) = (&array.elem, &array.len);
        let arm = quote! {
            #first.. => {
                let nth = ::core::primitive::usize::from(sub - #first);
                let place = self.#name.get_mut(nth)?;
                ::core::option::Option::Some(place)
            }
        };
        (quote!(#value), quote!((#len) as u8), quote!(#first + (#len) as u8 - 1), arm)
    } else {
        let value = &field.ty;
        let arm = quote!(#first => ::core::option::Option::Some(&mut self.#name),);
        (quote!(#value), quote!(1), quote!(#first), arm)
    };
    let entry = quote! {
        ::ecss_can::od::Entry::of::<#value>(#first, #count, #access).for_pdo(#pdo).within(#limits)
    };
    Ok(Sub { number, entry, title: field::title(field)?, arm, last })
}

/// `#[record(0x40)]`.
fn structure(input: &DeriveInput) -> syn::Result<Option<TokenStream>> {
    let Some(attribute) = input.attrs.iter().find(|attribute| attribute.path().is_ident("record")) else {
        return Ok(None);
    };
    let index: LitInt = attribute.parse_args()?;
    Ok(Some(quote!(
        const STRUCTURE: u16 = #index;
    )))
}
