//! A declared type with its parameters filled in, for constants beside it.

use proc_macro2::{Span, TokenStream};
use quote::{quote, quote_spanned};
use syn::{DeriveInput, GenericParam, Lifetime};

/// Arguments of the type: each parameter has its default. `None` when one has none.
pub fn arguments(input: &DeriveInput) -> Option<Vec<TokenStream>> {
    let argument = |parameter: &GenericParam| match parameter {
        GenericParam::Lifetime(_) => {
            let lifetime = Lifetime::new("'static", Span::call_site());
            Some(quote!(#lifetime))
        }
        GenericParam::Type(parameter) => parameter.default.as_ref().map(|default| quote!(#default)),
        GenericParam::Const(parameter) => parameter.default.as_ref().map(|default| quote!(#default)),
    };
    input.generics.params.iter().map(argument).collect()
}

/// An assertion about the type: as a constant beside it, and as a statement in its constructor where it is generic.
pub fn assertion(
    input: &DeriveInput,
    assertion: impl Fn(TokenStream) -> TokenStream,
) -> (Option<TokenStream>, Option<TokenStream>) {
    let ident = &input.ident;
    let beside = arguments(input).map(|arguments| {
        let asserted = assertion(quote_spanned!(ident.span()=> #ident<#(#arguments),*>));
        quote_spanned!(ident.span()=> const _: () = #asserted;)
    });
    let inside = assertion(quote!(Self));
    let is_generic = !input.generics.params.is_empty();
    (beside, is_generic.then(|| quote!(const { #inside };)))
}
