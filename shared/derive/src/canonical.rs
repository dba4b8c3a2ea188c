//! Expands `#[derive(Canonical)]`.
//!
//! All expressions are evaluated before any field changes, so they read the state as it was.

use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::{format_ident, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{
    Data, DeriveInput, Error, Expr, Field, Fields, Index, Member, Type, TypeArray, WherePredicate,
    parse_quote,
};

use crate::errors::Errors;
use crate::horizon::{self, Horizon};
use crate::path;

/// A struct, or a variant of an enum.
#[derive(Default)]
struct Shape {
    /// Pattern that binds each field.
    bindings: TokenStream,
    /// Evaluates the expressions at the fields.
    evaluated: TokenStream,
    /// Shifts the fields.
    shifted: TokenStream,
    /// Bounds of the fields whose type has a type parameter.
    bounds: Vec<TokenStream>,
}

/// Returns the implementation.
pub fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let mut errors = Errors::default();
    let context = errors.take(horizon::context(&input.attrs)).flatten();
    let mut bounds = Vec::new();
    let body = match &input.data {
        Data::Struct(data) => {
            let Shape { bindings, evaluated, shifted, bounds: own } = shape(input, &data.fields, &mut errors);
            bounds = own;
            quote!(#evaluated let Self { #bindings } = self; #shifted)
        }
        Data::Enum(data) => {
            let arms = data.variants.iter().map(|variant| {
                let Shape { bindings, evaluated, shifted, bounds: own } =
                    shape(input, &variant.fields, &mut errors);
                bounds.extend(own);
                let name = &variant.ident;
                quote! {
                    Self::#name { .. } => {
                        #evaluated
                        if let Self::#name { #bindings } = self {
                            #shifted
                        }
                    }
                }
            });
            let arms: Vec<_> = arms.collect();
            quote!(match *self { #(#arms)* })
        }
        Data::Union(_) => {
            errors.add(Error::new_spanned(&input.ident, "only a struct or an enum has a canonical form"));
            TokenStream::new()
        }
    };
    errors.finish()?;
    Ok(implementation(input, context.as_ref(), &bounds, body))
}

/// Returns an implementation that does nothing. Beside it the errors of a declaration are the only ones.
pub fn stub(input: &DeriveInput) -> TokenStream {
    let context = horizon::context(&input.attrs).ok().flatten();
    implementation(input, context.as_ref(), &[], TokenStream::new())
}

fn implementation(
    input: &DeriveInput,
    context: Option<&Type>,
    bounds: &[TokenStream],
    body: TokenStream,
) -> TokenStream {
    let krate = path::canopen();
    let (ident, mut generics) = (&input.ident, input.generics.clone());
    if !bounds.is_empty() {
        let predicates = &mut generics.make_where_clause().predicates;
        predicates.extend(bounds.iter().map(|bound| -> WherePredicate { parse_quote!(#bound) }));
    }
    let (impl_generics, type_generics, bounds) = generics.split_for_impl();
    let context = context.map_or_else(|| quote!(()), |context| quote!(#context));
    quote! {
        #[automatically_derived]
        #[diagnostic::do_not_recommend]
        #[allow(unused_variables, irrefutable_let_patterns)]
        impl #impl_generics #krate::types::Canonical for #ident #type_generics #bounds {
            type Context = #context;

            fn canonical(&mut self, now: #krate::types::Instant, context: &Self::Context) {
                #body
            }
        }
    }
}

fn shape(input: &DeriveInput, fields: &Fields, errors: &mut Errors) -> Shape {
    let mut shape = Shape::default();
    for (nth, field) in fields.iter().enumerate() {
        if let Some(attribute) = errors.take(horizon::of_field(&field.attrs)) {
            let place = Place::new(input, field, nth);
            errors.take(place.add(attribute, &mut shape));
        }
    }
    shape
}

/// A field, with the names of its variables.
struct Place<'a> {
    of: &'a Type,
    /// `true`: its type has a type parameter of the declaration.
    is_generic: bool,
    member: Member,
    field: Ident,
    value: Ident,
    context: Ident,
}

impl<'a> Place<'a> {
    fn new(input: &DeriveInput, field: &'a Field, nth: usize) -> Self {
        // No expression of the declaration sees these.
        let name = |kind| format_ident!("{kind}_{nth}", span = Span::mixed_site());
        let member = match &field.ident {
            Some(ident) => Member::Named(ident.clone()),
            None => Member::Unnamed(Index::from(nth)),
        };
        let parameters: Vec<_> = input.generics.type_params().map(|parameter| &parameter.ident).collect();
        let of = &field.ty;
        let is_generic = names(quote!(#of), &parameters);
        Place { of, is_generic, member, field: name("field"), value: name("value"), context: name("context") }
    }

    fn add(&self, attribute: horizon::Attribute, shape: &mut Shape) -> syn::Result<()> {
        let Place { of, member, field, value, .. } = self;
        shape.bindings.extend(quote!(#member: #field,));
        if let Some(expression) = attribute.value {
            shape.evaluated.extend(quote!(let #value: #of = #expression;));
            shape.shifted.extend(quote!(*#field = #value;));
        }
        match attribute.horizon {
            None => self.add_plain(shape),
            Some(Horizon::Due) => self.add_instants(&format_ident!("due"), None, shape),
            Some(Horizon::Age(horizon)) => self.add_instants(&format_ident!("age"), Some(&horizon), shape),
            Some(Horizon::Grid(period)) => self.add_instants(&format_ident!("grid"), Some(&period), shape),
            Some(Horizon::Within(context)) => self.add_machine(&context, shape),
            Some(Horizon::Each(function)) => self.add_machines(&function, shape)?,
        }
        Ok(())
    }

    /// A field without a horizon. An instant has no canonical form: the compiler reports it at the type.
    fn add_plain(&self, shape: &mut Shape) {
        let Place { of, field, .. } = self;
        let krate = path::canopen_at(of.span());
        let shift =
            quote_spanned!(of.span()=> <#of as #krate::types::Canonical>::canonical(#field, now, &()););
        shape.shifted.extend(shift);
        if self.is_generic {
            shape.bounds.push(quote!(#of: #krate::types::Canonical<Context = ()>));
        }
    }

    fn add_instants(&self, function: &Ident, horizon: Option<&Expr>, shape: &mut Shape) {
        let Place { of, field, context, .. } = self;
        let krate = path::canopen_at(of.span());
        let duration = horizon.map(|horizon| {
            let krate = path::canopen();
            shape.evaluated.extend(quote!(let #context: #krate::types::Duration = #horizon;));
            quote!(, #context)
        });
        let shift =
            quote_spanned!(of.span()=> <#of as #krate::types::Instants>::#function(#field, now #duration););
        shape.shifted.extend(shift);
        if self.is_generic {
            shape.bounds.push(quote!(#of: #krate::types::Instants));
        }
    }

    fn add_machine(&self, expression: &Expr, shape: &mut Shape) {
        let Place { of, field, context, .. } = self;
        let krate = path::canopen_at(of.span());
        let machine = quote_spanned!(of.span()=> <#of as #krate::types::Canonical>);
        shape.evaluated.extend(quote!(let #context: #machine::Context = #expression;));
        shape.shifted.extend(quote!(#machine::canonical(#field, now, &#context);));
    }

    fn add_machines(&self, function: &Expr, shape: &mut Shape) -> syn::Result<()> {
        let Place { field, context, .. } = self;
        let Type::Array(TypeArray { elem, len, .. }) = self.of else {
            return Err(Error::new_spanned(self.of, "`each` stands at an array: use `within`"));
        };
        let krate = path::canopen_at(elem.span());
        let machine = quote_spanned!(elem.span()=> <#elem as #krate::types::Canonical>);
        shape.evaluated.extend(quote! {
            let #context: [#machine::Context; #len] = ::core::array::from_fn(#function);
        });
        shape.shifted.extend(quote! {
            for (#field, #context) in #field.iter_mut().zip(&#context) {
                #machine::canonical(#field, now, #context);
            }
        });
        Ok(())
    }
}

/// Returns whether one of these parameters stands in a type.
fn names(of: TokenStream, parameters: &[&Ident]) -> bool {
    of.into_iter().any(|token| match token {
        TokenTree::Ident(ident) => parameters.contains(&&ident),
        TokenTree::Group(group) => names(group.stream(), parameters),
        _ => false,
    })
}
