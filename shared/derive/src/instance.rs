//! A declared type with its parameters filled in, for constants beside it.

use proc_macro2::{Group, Span, TokenStream, TokenTree};
use quote::{ToTokens, quote, quote_spanned};
use syn::{DeriveInput, GenericParam, Ident, Lifetime};

/// Returns the arguments of the type: the default of each parameter. `None` if one has no default.
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

/// Replaces each type parameter by its default, as in [`constants`].
pub fn filled(input: &DeriveInput, tokens: TokenStream) -> TokenStream {
    let Some(arguments) = inferred(input) else { return tokens };
    let names: Vec<_> = input.generics.params.iter().map(name).collect();
    replaced(tokens, &names, &arguments)
}

/// The arguments of the type in [`constants`]. `None`: it keeps its parameters, a lifetime is inferred.
fn inferred(input: &DeriveInput) -> Option<Vec<TokenStream>> {
    arguments(input).filter(|_| input.generics.lifetimes().next().is_none())
}

fn name(parameter: &GenericParam) -> Option<&Ident> {
    match parameter {
        GenericParam::Lifetime(_) => None,
        GenericParam::Type(parameter) => Some(&parameter.ident),
        GenericParam::Const(parameter) => Some(&parameter.ident),
    }
}

fn replaced(tokens: TokenStream, names: &[Option<&Ident>], arguments: &[TokenStream]) -> TokenStream {
    let replace = |token| match token {
        TokenTree::Ident(ident) => match names.iter().position(|name| *name == Some(&ident)) {
            Some(nth) => arguments[nth].clone(),
            None => ident.into_token_stream(),
        },
        TokenTree::Group(group) => {
            let inside = replaced(group.stream(), names, arguments);
            Group::new(group.delimiter(), inside).into_token_stream()
        }
        other => other.into_token_stream(),
    };
    tokens.into_iter().flat_map(replace).collect()
}

/// Returns an `impl` block with constants of the type. Each parameter has its default there, so that
/// `Type::CONSTANT` needs no argument.
pub fn constants(input: &DeriveInput, constants: &[TokenStream]) -> TokenStream {
    let ident = &input.ident;
    match inferred(input) {
        Some(arguments) => quote!(impl #ident<#(#arguments),*> { #(#constants)* }),
        None => {
            let (impl_generics, type_generics, bounds) = input.generics.split_for_impl();
            quote!(impl #impl_generics #ident #type_generics #bounds { #(#constants)* })
        }
    }
}

/// Returns an assertion about the type, reported at `span`. It is a constant beside the type. For a generic type
/// it is also a statement in the constructor.
pub fn assertion(
    input: &DeriveInput,
    span: Span,
    assertion: impl Fn(TokenStream) -> TokenStream,
) -> (TokenStream, TokenStream) {
    let mut ident = input.ident.clone();
    ident.set_span(span);
    let beside = arguments(input).map(|arguments| {
        let asserted = assertion(quote_spanned!(span=> #ident<#(#arguments),*>));
        quote_spanned!(span=> const _: () = #asserted;)
    });
    let is_generic = !input.generics.params.is_empty();
    let inside = is_generic.then(|| {
        let asserted = assertion(quote!(Self));
        quote!(const { #asserted };)
    });
    (beside.unwrap_or_default(), inside.unwrap_or_default())
}
