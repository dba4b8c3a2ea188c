//! Expands `#[derive(PdoValues)]`.

use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Data, DeriveInput, Error, Ident, Type};

use crate::errors::Errors;
use crate::{field, path};

/// Most values of a PDO.
const MAPPED: usize = 8;

pub fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let fields = crate::fields(input)?;
    let mut errors = Errors::default();
    if let Some(field) = fields.named.iter().nth(MAPPED) {
        let message =
            format!("a PDO carries at most {MAPPED} values, this struct has {}", fields.named.len());
        errors.add(Error::new_spanned(&field.ident, message));
    }
    errors.finish()?;
    let krate = path::canopen();
    let names = fields.named.iter().map(field::ident).collect::<syn::Result<Vec<&Ident>>>()?;
    let types: Vec<&Type> = fields.named.iter().map(|field| &field.ty).collect();
    let unpack = quote! {
        let (#(#names,)*) = <Self::Tuple as #krate::pdo::PdoValues>::unpack(payload)?;
        ::core::option::Option::Some(Self { #(#names),* })
    };
    let pack = quote!(#krate::pdo::PdoValues::pack((#(self.#names,)*)));
    Ok(implementation(input, &types, unpack, pack))
}

/// Returns an implementation that stands beside the errors of a declaration. It has the types of the first fields.
pub fn stub(input: &DeriveInput) -> TokenStream {
    let types: Vec<&Type> = match &input.data {
        Data::Struct(data) => data.fields.iter().take(MAPPED).map(|field| &field.ty).collect(),
        Data::Enum(_) | Data::Union(_) => Vec::new(),
    };
    implementation(input, &types, quote!(::core::option::Option::None), quote!(0))
}

fn implementation(
    input: &DeriveInput,
    types: &[&Type],
    unpack: TokenStream,
    pack: TokenStream,
) -> TokenStream {
    let (krate, ident) = (path::canopen(), &input.ident);
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    // The error of a field that is no number stands at its type.
    let numbers = types.iter().map(|of| {
        let krate = path::canopen_at(of.span());
        quote_spanned!(of.span()=> #of: #krate::od::Number)
    });
    let bounds = match bounds {
        Some(bounds) => {
            let own = bounds.predicates.iter();
            quote!(where #(#own,)* #(#numbers,)*)
        }
        None => quote!(where #(#numbers,)*),
    };
    quote! {
        impl #impl_generics #krate::pdo::PdoValues for #ident #type_generics #bounds {
            type Tuple = (#(#types,)*);

            fn unpack(payload: ::core::primitive::u64) -> ::core::option::Option<Self> {
                #unpack
            }

            fn pack(self) -> ::core::primitive::u64 {
                #pack
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use syn::parse_quote;

    use super::*;

    fn refused(input: &DeriveInput) -> String {
        expand(input).unwrap_err().to_string()
    }

    #[test]
    fn values_have_names_and_are_at_most_eight() {
        assert_eq!(
            refused(&parse_quote!(
                struct Change(u8);
            )),
            "its values need names"
        );
        assert_eq!(
            refused(&parse_quote!(
                enum Change {
                    One,
                }
            )),
            "only a struct can be declared so"
        );
        assert!(
            expand(&parse_quote!(
                struct Change {
                    a: u8,
                    b: u8,
                    c: u8,
                    d: u8,
                    e: u8,
                    f: u8,
                    g: u8,
                    h: u8,
                }
            ))
            .is_ok()
        );
        let nine = parse_quote! {
            struct Change { a: u8, b: u8, c: u8, d: u8, e: u8, f: u8, g: u8, h: u8, i: u8 }
        };
        assert_eq!(refused(&nine), "a PDO carries at most 8 values, this struct has 9");
    }
}
