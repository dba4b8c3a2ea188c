//! The words in `#[canonical(..)]`.

use proc_macro2::Span;
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Error, Expr, Ident, Token, Type};

use crate::errors::Errors;

/// Every word that may stand at a field.
const KNOWN: &str = "due, age, grid, within, each, value";

/// How long a field has an effect.
pub enum Horizon {
    /// Instants that are compared with now alone.
    Due,
    /// Instants whose age has an effect up to this duration.
    Age(Expr),
    /// Points of a grid with this period.
    Grid(Expr),
    /// A machine with this context.
    Within(Expr),
    /// An array of machines. The function returns the context of the nth.
    Each(Expr),
}

/// The attribute of a field.
#[derive(Default)]
pub struct Attribute {
    /// `None`: the field has no time.
    pub horizon: Option<Horizon>,
    /// Value that the field takes before it is shifted.
    pub value: Option<Expr>,
}

/// A word with its expression.
struct Word {
    name: Ident,
    expression: Option<Expr>,
}

impl Parse for Word {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let name = input.parse()?;
        let expression = match input.parse::<Option<Token![=]>>()? {
            Some(_) => Some(input.parse()?),
            None => None,
        };
        Ok(Word { name, expression })
    }
}

/// `context = Type`.
struct Context(Type);

impl Parse for Context {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let name: Ident = input.parse()?;
        if name != "context" {
            return Err(Error::new(name.span(), "unknown word; a type knows `context = Type`"));
        }
        input.parse::<Token![=]>()?;
        input.parse().map(Context)
    }
}

/// Returns the type of the context: what a declaration needs to know of its owner. `None`: nothing.
pub fn context(attributes: &[syn::Attribute]) -> syn::Result<Option<Type>> {
    let mut found = None;
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("canonical")) {
        let Context(context) = attribute.parse_args()?;
        if found.replace(context).is_some() {
            return Err(Error::new_spanned(attribute, "a second context: one is allowed"));
        }
    }
    Ok(found)
}

/// Returns the attribute of a field.
pub fn of_field(attributes: &[syn::Attribute]) -> syn::Result<Attribute> {
    let (mut found, mut errors) = (Attribute::default(), Errors::default());
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("canonical")) {
        let words = attribute.parse_args_with(Punctuated::<Word, Token![,]>::parse_terminated);
        for word in errors.take(words).into_iter().flatten() {
            errors.take(found.add(word));
        }
    }
    errors.finish().map(|()| found)
}

impl Attribute {
    fn add(&mut self, Word { name, expression }: Word) -> syn::Result<()> {
        let (text, span) = (name.to_string(), name.span());
        if text == "value" {
            let is_second = self.value.replace(needed(expression, &text, span)?).is_some();
            return if is_second { Err(Error::new(span, "a second value: one is allowed")) } else { Ok(()) };
        }
        let horizon = match (text.as_str(), expression) {
            ("due", None) => Horizon::Due,
            ("due", Some(expression)) => {
                return Err(Error::new_spanned(expression, "`due` has no horizon: use `age = ..`"));
            }
            ("age", expression) => Horizon::Age(needed(expression, &text, span)?),
            ("grid", expression) => Horizon::Grid(needed(expression, &text, span)?),
            ("within", expression) => Horizon::Within(needed(expression, &text, span)?),
            ("each", expression) => Horizon::Each(needed(expression, &text, span)?),
            _ => return Err(Error::new(span, format!("unknown word `{name}`; known are {KNOWN}"))),
        };
        match self.horizon.replace(horizon) {
            Some(_) => Err(Error::new(span, "a second horizon: one is allowed")),
            None => Ok(()),
        }
    }
}

fn needed(expression: Option<Expr>, word: &str, span: Span) -> syn::Result<Expr> {
    expression.ok_or_else(|| Error::new(span, format!("its expression is missing: `{word} = ..`")))
}
