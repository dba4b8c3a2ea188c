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
    /// Of what a transmit PDO reads, if it may.
    bits: Option<TokenStream>,
    /// Of what a receive PDO writes, if it may.
    set_bits: Option<TokenStream>,
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
        let (title, arm, last) = (title.into(), quote!(), quote!());
        subs.insert(0, Sub { number: 0, entry, title, arm, bits: None, set_bits: None, last });
    }
    let (entries, titles) = (subs.iter().map(|sub| &sub.entry), subs.iter().map(|sub| &sub.title));
    // The last sub-index first: the arm of several in a row covers all that are behind it.
    let arms = subs.iter().rev().map(|sub| &sub.arm);
    let reads: Vec<_> = subs.iter().rev().filter_map(|sub| sub.bits.as_ref()).collect();
    let writes: Vec<_> = subs.iter().rev().filter_map(|sub| sub.set_bits.as_ref()).collect();
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

            #[allow(unused_variables)]
            #[inline]
            fn bits(&self, sub: u8, run: ::ecss_can::od::Run) -> ::core::option::Option<u64> {
                match sub {
                    #(#reads)*
                    _ => ::core::option::Option::None,
                }
            }

            #[allow(unused_variables)]
            #[inline]
            fn set_bits(
                &mut self,
                sub: u8,
                run: ::ecss_can::od::Run,
                bits: u64,
            ) -> ::core::option::Option<()> {
                match sub {
                    #(#writes)*
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
    let first = u8::try_from(number).ok().filter(|first| *first <= 254);
    let first = first.ok_or_else(|| Error::new_spanned(&attribute.number, "at most 254"))?;
    let (access, qualities) = (attribute.required_access()?, attribute.qualities());
    // Its value, and several in a row from there on.
    let nth = quote!(::core::primitive::usize::from(sub - #first));
    let (value, count, last, pattern, place_mut) = if attribute.in_a_row {
        let array = field::array(field)?;
        let (value, len) = (&*array.elem, &array.len);
        let last = quote!(#first + (::ecss_can::od::sub_indices(#len) - 1));
        let place_mut = quote!(self.#name.get_mut(#nth)?);
        (value, quote!(::ecss_can::od::sub_indices(#len)), last, quote!(#first..), place_mut)
    } else {
        (&field.ty, quote!(1), quote!(#first), quote!(#first), quote!(&mut self.#name))
    };
    let (bits, set_bits) = if attribute.in_a_row {
        let values = quote!(self.#name);
        (field::run_bits(&values, &nth), field::set_run_bits(&values, &nth, attribute))
    } else {
        (field::bits(&quote!(&self.#name)), field::set_bits(&place_mut, value, attribute))
    };
    let entry = quote! {
        ::ecss_can::od::Entry::of::<#value>(#first, #count, #access) #qualities
    };
    let arm = |value: TokenStream| quote!(#pattern => #value,);
    let (read, written) = attribute.directions();
    Ok(Sub {
        number,
        entry,
        title: field::title(field)?,
        // A place of its own: what becomes of it is a trait object.
        arm: arm(quote!({
            let place = #place_mut;
            ::core::option::Option::Some(place)
        })),
        bits: read.then(|| arm(bits)),
        set_bits: written.then(|| arm(set_bits)),
        last,
    })
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
