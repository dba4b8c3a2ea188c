//! Expands `#[derive(Record)]`.

use proc_macro2::TokenStream;
use quote::{ToTokens, quote, quote_spanned};
use syn::{DeriveInput, Error, LitInt};

use crate::attribute::{Attribute, Shape};
use crate::errors::Errors;
use crate::field::{self, Declared};
use crate::{instance, path};

/// A sub-index, or several in a row.
pub struct Sub {
    pub number: u16,
    pub entry: TokenStream,
    pub title: String,
    /// Values with a name, as an expression.
    pub values: TokenStream,
    /// The constant of its field.
    pub constant: Option<TokenStream>,
    pub arm: TokenStream,
    /// Match arm for the value that a transmit PDO reads. `None`: it may not.
    pub bits: Option<TokenStream>,
    /// Match arm that writes the value of a receive PDO. `None`: it may not.
    pub set_bits: Option<TokenStream>,
    /// Statement that refuses a number which is no value of an enumeration. `None`: no client writes it.
    pub check: Option<TokenStream>,
    /// The last sub-index, as an expression.
    pub last: TokenStream,
}

pub fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let (mut subs, mut initials, mut values) = (Vec::new(), Vec::new(), TokenStream::new());
    let (mut numbers, mut errors, mut is_empty) = (Vec::new(), Errors::default(), true);
    for field in &crate::fields(input)?.named {
        let name = field::ident(field)?;
        let mut attribute = None;
        match errors.take(field::declared(field, "sub", None)) {
            Some(Declared::Value(value)) => attribute = Some(value),
            // Its error is enough.
            None => is_empty = false,
            Some(Declared::Misspelled(_)) => {
                is_empty = false;
                errors.add_silent();
            }
            Some(_) => {}
        }
        let initial = field::initial(field, attribute.as_deref());
        initials.push(quote!(#name: #initial));
        if let Some(attribute) = attribute {
            values.extend(field::initial_constant(input, field, &attribute));
            is_empty = false;
            numbers.extend(attribute.value(254).map(|number| (number, attribute.number.span())));
            subs.extend(sub(input, field, &attribute, &mut errors));
        }
    }
    if is_empty {
        errors.add(Error::new_spanned(&input.ident, "a record has at least one `#[sub(..)]`"));
    }
    errors.add_repeated(numbers, |number| format!("sub-index {number} is declared twice"));
    subs.sort_by_key(|sub| sub.number);
    let structure = errors.take(structure(input)).flatten();
    errors.finish()?;
    values.extend(implementation(input, subs, &initials, structure));
    Ok(values)
}

fn implementation(
    input: &DeriveInput,
    mut subs: Vec<Sub>,
    initials: &[TokenStream],
    structure: Option<TokenStream>,
) -> TokenStream {
    let krate = path::canopen();
    let last = subs.last().map(|sub| sub.last.clone());
    if subs.first().is_some_and(|first| first.number != 0) {
        let (entry, title) = (quote!(#krate::od::Entry::highest(#last)), "Highest sub-index supported");
        subs.insert(
            0,
            Sub {
                number: 0,
                entry,
                title: title.into(),
                values: quote!(&[]),
                constant: None,
                arm: quote!(),
                bits: None,
                set_bits: None,
                check: None,
                last: quote!(),
            },
        );
    }
    let (entries, titles) = (subs.iter().map(|sub| &sub.entry), subs.iter().map(|sub| &sub.title));
    let (values, checks) =
        (subs.iter().map(|sub| &sub.values), subs.iter().filter_map(|sub| sub.check.as_ref()));
    // The last sub-index first: the arm of several in a row covers all that are behind it.
    let arms = subs.iter().rev().map(|sub| &sub.arm);
    let reads: Vec<_> = subs.iter().rev().filter_map(|sub| sub.bits.as_ref()).collect();
    let writes: Vec<_> = subs.iter().rev().filter_map(|sub| sub.set_bits.as_ref()).collect();
    let ident = &input.ident;
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    let constants: Vec<_> = subs.iter().filter_map(|sub| sub.constant.clone()).collect();
    let constants = instance::constants(input, &constants);
    let (asserted, in_default) = instance::assertion(input, ident.span(), |this| {
        let entries = quote!(<#this as #krate::od::Record>::ENTRIES);
        let krate = path::canopen_at(ident.span());
        quote_spanned!(ident.span()=> #krate::od::assert_entries(#entries))
    });
    quote! {
        #asserted

        #constants

        impl #impl_generics #krate::od::Record for #ident #type_generics #bounds {
            const ENTRIES: &'static [#krate::od::Entry] = &[#(#entries),*];
            const NAMES: &'static [&'static str] = &[#(#titles),*];
            const VALUES: &'static [&'static [#krate::od::NamedValue]] = &[#(#values),*];
            #structure

            fn variable(&mut self, sub: u8) -> ::core::option::Option<&mut dyn #krate::od::Variable> {
                match sub {
                    #(#arms)*
                    _ => ::core::option::Option::None,
                }
            }

            #[allow(unused_variables)]
            #[inline]
            fn bits(&self, sub: u8, run: #krate::od::Run) -> ::core::option::Option<u64> {
                match sub {
                    #(#reads)*
                    _ => ::core::option::Option::None,
                }
            }

            #[allow(unused_variables)]
            fn check(sub: u8, value: &[u8]) -> ::core::result::Result<(), #krate::types::AbortCode> {
                #(#checks)*
                ::core::result::Result::Ok(())
            }

            #[allow(unused_variables)]
            #[inline]
            fn set_bits(
                &mut self,
                sub: u8,
                run: #krate::od::Run,
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
                #in_default
                Self { #(#initials),* }
            }
        }
    }
}

/// `None` after an error.
pub fn sub(
    input: &DeriveInput,
    field: &syn::Field,
    attribute: &Attribute,
    errors: &mut Errors,
) -> Option<Sub> {
    let krate = path::canopen();
    let name = &field.ident;
    let (title, number) = (errors.take(field::title(field)), errors.take(attribute.value(254)));
    let access = match attribute.shape {
        Shape::Var => errors.take(attribute.required_access()),
        Shape::Array | Shape::Record { .. } => {
            let message = "a sub-index is a single value; `#[sub(1.., ..)]` declares several in a row";
            errors.add(Error::new(attribute.number.span(), message));
            None
        }
    };
    let array = attribute.in_a_row.then(|| errors.take(field::array(field)));
    let (title, number, access) = (title?, number?, access?);
    let first = number as u8;
    // Its value, and several in a row from there on.
    let nth = quote!(::core::primitive::usize::from(sub - #first));
    let (value, count, last, pattern, place_mut) = if let Some(array) = array {
        let array = array?;
        let (value, count) = (&*array.elem, field::sub_indices(&array.len));
        let last = quote!(#first + (#count - 1));
        let place_mut = quote!(self.#name.get_mut(#nth)?);
        (value, count, last, quote!(#first..), place_mut)
    } else {
        (&field.ty, quote!(1), quote!(#first), quote!(#first), quote!(&mut self.#name))
    };
    let (bits, set_bits) = if attribute.in_a_row {
        let values = quote!(self.#name);
        (field::run_bits(&values, &nth, value), field::set_run_bits(&values, &nth, value, attribute))
    } else {
        (field::bits(&quote!(&self.#name), value), field::set_bits(&place_mut, value, attribute))
    };
    let entry =
        attribute.qualified(&field.ty, quote!(#krate::od::Entry::of::<#value>(#first, #count, #access)));
    let same_error = field::same_error(value);
    let arm = |value: TokenStream| quote!(#pattern => #value,);
    let (filled, access_types) = (instance::filled(input, value.to_token_stream()), attribute.access_types());
    let (read, written) = attribute.directions();
    Some(Sub {
        number,
        entry,
        title,
        values: field::named(value),
        constant: field::constant(
            field,
            &format!("sub-index {first}"),
            &quote!(#krate::od::SubIndex<Self, #filled, #access_types>),
            &quote!(#krate::od::SubIndex::new(#first, #count)),
        ),
        arm: arm(quote!({
            #same_error
            ::core::option::Option::Some(<#value as #krate::od::Typed>::as_variable(#place_mut))
        })),
        bits: read.then(|| arm(bits)),
        set_bits: written.then(|| arm(set_bits)),
        check: attribute
            .is_writable()
            .then(|| field::check(&quote!(sub.wrapping_sub(#first) < #count), value)),
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
