//! Expands `#[derive(Enumeration)]`.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, quote};
use syn::ext::IdentExt;
use syn::punctuated::Punctuated;
use syn::{Data, DeriveInput, Error, Fields, Ident, Meta, Token, Variant};

use crate::errors::Errors;
use crate::path;

/// Type of the discriminants: its name, its bytes, and its variant of `DataType`.
const SIZES: [(&str, usize, &str); 6] = [
    ("u8", 1, "Unsigned8"),
    ("u16", 2, "Unsigned16"),
    ("u32", 4, "Unsigned32"),
    ("i8", 1, "Integer8"),
    ("i16", 2, "Integer16"),
    ("i32", 4, "Integer32"),
];

pub fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let Data::Enum(data) = &input.data else {
        return Err(Error::new_spanned(&input.ident, "only an enum has the values of an enumeration"));
    };
    let mut errors = Errors::default();
    let repr = errors.take(repr(input));
    if !input.generics.params.is_empty() {
        errors.add(Error::new_spanned(&input.generics, "an enumeration has no parameters"));
    }
    for variant in data.variants.iter().filter(|variant| !matches!(variant.fields, Fields::Unit)) {
        let message = "a variant of an enumeration is a number: it has no fields";
        errors.add(Error::new_spanned(&variant.fields, message));
    }
    if data.variants.is_empty() {
        // The compiler reports it: such an enum has no `repr`.
        errors.add_silent();
    }
    errors.finish()?;
    let repr = repr.ok_or_else(|| missing(input))?;
    Ok(implementation(input, &repr, &data.variants))
}

/// The type of the numbers.
struct Repr {
    ident: Ident,
    bytes: usize,
    data_type: &'static str,
}

fn repr(input: &DeriveInput) -> syn::Result<Repr> {
    let mut words = Vec::new();
    for attribute in input.attrs.iter().filter(|attribute| attribute.path().is_ident("repr")) {
        words.extend(attribute.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated)?);
    }
    for ident in words.iter().filter_map(|word| word.path().get_ident()) {
        if let Some((_, bytes, data_type)) = SIZES.into_iter().find(|(name, ..)| ident == name) {
            return Ok(Repr { ident: ident.clone(), bytes, data_type });
        }
    }
    let word = words.first().ok_or_else(|| missing(input))?;
    let name = word.path().to_token_stream();
    let message = format!("`{name}` is no size of an enumeration; known are {}", known());
    Err(Error::new_spanned(word, message))
}

fn missing(input: &DeriveInput) -> Error {
    let message = format!("missing size: add `#[repr(u8)]`; known are {}", known());
    Error::new_spanned(&input.ident, message)
}

fn known() -> String {
    SIZES.map(|(name, ..)| name).join(", ")
}

fn implementation(
    input: &DeriveInput,
    repr: &Repr,
    variants: &Punctuated<Variant, Token![,]>,
) -> TokenStream {
    let (krate, ident) = (path::canopen(), &input.ident);
    let Repr { ident: repr, bytes, data_type } = repr;
    let repr = quote!(::core::primitive::#repr);
    let data_type = Ident::new(data_type, Span::call_site());
    // Without the sign: the bits above those of the type are zero.
    let unsigned = Ident::new(&format!("u{}", 8 * bytes), Span::call_site());
    let names: Vec<&Ident> = variants.iter().map(|variant| &variant.ident).collect();
    let texts = names.iter().map(|name| name.unraw().to_string());
    quote! {
        impl #krate::od::Variable for #ident {
            fn bits(&self) -> ::core::primitive::u64 {
                let number = match self {
                    #(Self::#names => Self::#names as #repr,)*
                };
                number as ::core::primitive::#unsigned as ::core::primitive::u64
            }

            fn set_bits(&mut self, bits: ::core::primitive::u64) {
                let number = bits as #repr;
                #(
                    if number == Self::#names as #repr {
                        *self = Self::#names;
                    }
                )*
            }
        }

        impl #krate::od::Typed for #ident {
            const TYPE: #krate::od::DataType = #krate::od::DataType::#data_type;
            const SIZE: ::core::primitive::usize = #bytes;
            const VALUES: &'static [#krate::od::NamedValue] = &[#(
                #krate::od::NamedValue { number: Self::#names as #repr as ::core::primitive::i64, name: #texts }
            ),*];

            fn is_value(bits: ::core::primitive::u64) -> ::core::primitive::bool {
                let number = bits as #repr;
                #(number == Self::#names as #repr)||*
            }
        }

        impl #krate::od::Number for #ident {
            fn from_bits(bits: ::core::primitive::u64) -> ::core::option::Option<Self> {
                let number = bits as #repr;
                #(
                    if number == Self::#names as #repr {
                        return ::core::option::Option::Some(Self::#names);
                    }
                )*
                ::core::option::Option::None
            }
        }
    }
}

/// Returns implementations that stand beside the errors of a declaration: a number of one byte.
pub fn stub(input: &DeriveInput) -> TokenStream {
    let (krate, ident) = (path::canopen(), &input.ident);
    let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
    quote! {
        impl #impl_generics #krate::od::Variable for #ident #type_generics #bounds {}

        impl #impl_generics #krate::od::Typed for #ident #type_generics #bounds {
            const TYPE: #krate::od::DataType = #krate::od::DataType::Unsigned8;
            const SIZE: ::core::primitive::usize = 1;
        }

        impl #impl_generics #krate::od::Number for #ident #type_generics #bounds {}
    }
}

#[cfg(test)]
mod tests {
    use syn::parse_quote;

    use super::*;

    fn refused(input: &DeriveInput) -> Vec<String> {
        expand(input).unwrap_err().into_iter().map(|error| error.to_string()).collect()
    }

    #[test]
    fn size_of_an_enumeration_is_that_of_its_repr() {
        for (name, bytes, data_type) in SIZES {
            let repr = Ident::new(name, Span::call_site());
            let expanded = expand(&parse_quote! {
                #[repr(align(4), #repr)]
                enum Mode {
                    Off,
                }
            });
            let expanded = expanded.unwrap().to_string();
            assert!(
                expanded.contains(&format!("SIZE : :: core :: primitive :: usize = {bytes}usize")),
                "{expanded}"
            );
            assert!(expanded.contains(&format!("DataType :: {data_type} ;")), "{expanded}");
        }
    }

    #[test]
    fn enum_without_a_known_size_is_refused() {
        let with = |attribute: Option<syn::Attribute>| {
            refused(&parse_quote! {
                #attribute
                enum Mode {
                    Off,
                }
            })
        };
        let known = "known are u8, u16, u32, i8, i16, i32";
        assert_eq!(with(None), [format!("missing size: add `#[repr(u8)]`; {known}")]);
        for (attribute, name) in [(parse_quote!(#[repr(u64)]), "u64"), (parse_quote!(#[repr(C)]), "C")] {
            assert_eq!(with(Some(attribute)), [format!("`{name}` is no size of an enumeration; {known}")]);
        }
    }

    #[test]
    fn all_mistakes_of_an_enum_are_reported_at_once() {
        let mistakes = refused(&parse_quote! {
            enum Mode<T> {
                Off,
                Level(T),
                Auto { level: u8 },
            }
        });
        let fields = "a variant of an enumeration is a number: it has no fields";
        assert_eq!(mistakes[1..], ["an enumeration has no parameters", fields, fields]);
        assert!(mistakes[0].starts_with("missing size"));
    }

    #[test]
    fn struct_is_no_enumeration() {
        assert_eq!(
            refused(&parse_quote!(
                struct Mode;
            )),
            ["only an enum has the values of an enumeration"]
        );
    }
}
