//! What stands in `#[object(..)]` and `#[sub(..)]`.

use proc_macro2::{Span, TokenStream};
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::{Error, Expr, Ident, LitInt, Token};

/// How the value of a field is laid out.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A single value.
    Var,
    /// Values of one type, sub-indices 1 and up.
    Array,
    /// A struct with `derive(Record)`; `record, array`: its entries are of one type, so that it is told as an array.
    Record {
        /// Whether it is told as an array.
        as_array: bool,
    },
}

/// The attribute of a value.
pub struct Attribute {
    /// Index or sub-index.
    pub number: LitInt,
    /// Several in a row from there on.
    pub in_a_row: bool,
    /// Layout.
    pub shape: Shape,
    /// Access right; none for records, whose entries have their own.
    pub access: Option<Ident>,
    /// PDOs may carry it.
    pub pdo: bool,
    /// A frame of a receive PDO may leave it out.
    pub optional: bool,
    /// "save" keeps it, a DOMAIN.
    pub keep: bool,
    /// Least value.
    pub low: Option<Expr>,
    /// Greatest value.
    pub high: Option<Expr>,
    /// Value at power-on.
    pub default: Option<Expr>,
}

impl Attribute {
    /// The index or sub-index as a number.
    pub fn value(&self) -> syn::Result<u16> {
        self.number.base10_parse()
    }

    /// The limits, as an expression.
    pub fn limits(&self) -> TokenStream {
        let bound = |bound: &Option<Expr>| match bound {
            Some(value) => quote!(::core::option::Option::Some(#value)),
            None => quote!(::core::option::Option::None),
        };
        if self.low.is_none() && self.high.is_none() {
            return quote!(::core::option::Option::None);
        }
        let (low, high) = (bound(&self.low), bound(&self.high));
        quote!(::core::option::Option::Some(&::ecss_can::od::Limits { low: #low, high: #high }))
    }

    /// The access right of a value, as an expression.
    pub fn required_access(&self) -> syn::Result<TokenStream> {
        let message = "who may access it? ro, wo, rw, rwr, rww or constant";
        let access = self.access.as_ref().ok_or_else(|| Error::new(self.number.span(), message))?;
        Ok(quote!(::ecss_can::od::Access::#access))
    }

    /// What is declared beside type and access right, as calls on an `Entry`.
    pub fn qualities(&self) -> TokenStream {
        let limits = self.limits();
        let pdo = match (self.pdo, self.optional) {
            (false, _) => quote!(No),
            (true, false) => quote!(Required),
            (true, true) => quote!(Optional),
        };
        let keep = self.keep.then(|| quote!(.keep()));
        quote!(.for_pdo(::ecss_can::od::PdoUse::#pdo).within(#limits)#keep)
    }

    /// Whether transmit PDOs, and whether receive PDOs may carry it.
    pub fn directions(&self) -> (bool, bool) {
        let is_among = |rights: &[&str]| {
            self.pdo && self.access.as_ref().is_some_and(|own| rights.iter().any(|right| own == right))
        };
        (is_among(&["Ro", "Rw", "Rwr", "Const"]), is_among(&["Wo", "Rw", "Rww"]))
    }
}

impl Parse for Attribute {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let number = input.parse()?;
        let in_a_row = input.parse::<Option<Token![..]>>()?.is_some();
        let mut attribute = Attribute {
            number,
            in_a_row,
            shape: Shape::Var,
            access: None,
            pdo: false,
            optional: false,
            keep: false,
            low: None,
            high: None,
            default: None,
        };
        while input.parse::<Option<Token![,]>>()?.is_some() && !input.is_empty() {
            let word: Ident = input.parse()?;
            match word.to_string().as_str() {
                "record" => attribute.shape = Shape::Record { as_array: false },
                "array" if attribute.shape != Shape::Var => {
                    attribute.shape = Shape::Record { as_array: true }
                }
                "array" => attribute.shape = Shape::Array,
                "pdo" => attribute.pdo = true,
                "optional" => attribute.optional = true,
                "keep" => attribute.keep = true,
                "low" => attribute.low = Some(assigned(input)?),
                "high" => attribute.high = Some(assigned(input)?),
                "default" => attribute.default = Some(assigned(input)?),
                right => attribute.access = Some(access(right, word.span())?),
            }
        }
        if input.is_empty() { Ok(attribute) } else { Err(input.error("a comma is missing")) }
    }
}

fn assigned(input: ParseStream) -> syn::Result<Expr> {
    input.parse::<Token![=]>()?;
    input.parse()
}

/// The variant of `Access`.
fn access(right: &str, span: Span) -> syn::Result<Ident> {
    let name = match right {
        "ro" => "Ro",
        "wo" => "Wo",
        "rw" => "Rw",
        "rwr" => "Rwr",
        "rww" => "Rww",
        "constant" => "Const",
        _ => {
            let known =
                "ro, wo, rw, rwr, rww, constant, record, array, pdo, optional, keep, low, high, default";
            return Err(Error::new(span, format!("unknown word; known are {known}")));
        }
    };
    Ok(Ident::new(name, span))
}
