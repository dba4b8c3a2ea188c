//! The words in `#[object(..)]` and `#[sub(..)]`.

use proc_macro2::{Delimiter, Group, Span, TokenStream, TokenTree};
use quote::{quote, quote_spanned};
use syn::ext::IdentExt;
use syn::parse::{Parse, ParseStream};
use syn::{Error, Expr, ExprGroup, ExprLit, ExprParen, ExprUnary, Ident, Lit, LitInt, Token, Type, UnOp};

use crate::errors::Errors;
use crate::path;

/// Every word that may follow the number.
const KNOWN: &str =
    "ro, wo, rw, rwr, rww, constant, record, array, pdo, optional, keep, volatile, low, high, default";

/// Layout of the value of a field.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A single value.
    Var,
    /// Values of one type, sub-indices 1 and up.
    Array,
    /// A struct with `derive(Record)`. With `record, array` EDS and DCF describe it as an ARRAY: its entries are
    /// of one type.
    Record {
        /// `true`: EDS and DCF describe the record as an ARRAY.
        as_array: bool,
    },
}

/// The attribute of a value.
pub struct Attribute {
    /// Index or sub-index.
    pub number: LitInt,
    /// Several values with consecutive numbers, from [`Attribute::number`] on.
    pub in_a_row: bool,
    /// Layout of the value.
    pub shape: Shape,
    /// Access right. `None` for a record: each of its entries has its own.
    pub access: Option<Ident>,
    /// Place of the word `pdo`: PDOs may carry it.
    pub pdo: Option<Span>,
    /// A frame of a receive PDO may end before this value.
    pub optional: bool,
    /// Place of the word `keep`: "save" stores this DOMAIN.
    pub keep: Option<Span>,
    /// Place of the word `volatile`: "save" does not store this value.
    pub volatile: Option<Span>,
    /// Least value that a client may write.
    pub low: Option<Expr>,
    /// Greatest value that a client may write.
    pub high: Option<Expr>,
    /// Value at power-on.
    pub default: Option<Expr>,
}

impl Attribute {
    /// Returns the index or sub-index as a number. `most`: the greatest one that is allowed.
    pub fn value(&self, most: u16) -> syn::Result<u16> {
        let value = self.number.base10_parse().ok().filter(|value| *value <= most);
        let range =
            if most == u16::MAX { "an index is at most 0xFFFF" } else { "a sub-index is at most 254" };
        value.ok_or_else(|| Error::new(self.number.span(), range))
    }

    /// Returns the limits as an expression.
    pub fn limits(&self) -> TokenStream {
        let krate = path::canopen();
        let bound = |bound: &Option<Expr>| match bound {
            Some(value) => quote!(::core::option::Option::Some(#value)),
            None => quote!(::core::option::Option::None),
        };
        if !self.is_limited() {
            return quote!(::core::option::Option::None);
        }
        let (low, high) = (bound(&self.low), bound(&self.high));
        quote!(::core::option::Option::Some(const { &#krate::od::Limits::new(#low, #high) }))
    }

    /// Returns the access right of the value as an expression.
    pub fn required_access(&self) -> syn::Result<TokenStream> {
        let krate = path::canopen();
        let message = "missing access right: add `ro`, `wo`, `rw`, `rwr`, `rww` or `constant`";
        let access = self.access.as_ref().ok_or_else(|| Error::new(self.number.span(), message))?;
        Ok(quote!(#krate::od::Access::#access))
    }

    /// Returns two types that say what SDO clients may do: read and write. A declaration with an error allows both.
    pub fn access_types(&self) -> TokenStream {
        let krate = path::canopen();
        let is = |right: &str| self.access.as_ref().is_some_and(|own| own == right);
        let read = if is("Wo") { quote!(NotReadable) } else { quote!(Readable) };
        let write = if is("Ro") || is("Const") { quote!(NotWritable) } else { quote!(Writable) };
        quote!(#krate::od::#read, #krate::od::#write)
    }

    /// Returns whether SDO clients may write the value.
    pub fn is_writable(&self) -> bool {
        self.access.as_ref().is_some_and(|own| own != "Ro" && own != "Const")
    }

    /// Returns whether the value has a least or a greatest one.
    pub fn is_limited(&self) -> bool {
        self.low.is_some() || self.high.is_some()
    }

    /// Adds to the expression `entry` all that the attribute declares beside type and access right. `of` is the type
    /// of the field.
    pub fn qualified(&self, of: &Type, entry: TokenStream) -> TokenStream {
        let krate = path::canopen();
        let mut entry = entry;
        // Constants find the errors of these, which stand at the words.
        if let Some(word) = self.pdo {
            let krate = path::canopen_at(word);
            let pdo = if self.optional { quote!(Optional) } else { quote!(Required) };
            entry = quote_spanned!(word=> #krate::od::Entry::for_pdo(#entry, #krate::od::PdoUse::#pdo));
        }
        if self.is_limited() {
            let (low, high, limits) = (&self.low, &self.high, self.limits());
            let function = quote!(#krate::od::Entry::within);
            entry = call_at(quote!(#low #high), function, quote!(#entry, #limits));
        }
        if let Some(value) = self.default.as_ref().filter(|_| self.is_limited()) {
            let number = &self.number;
            let range = quote!({
                #[allow(unused_imports)]
                use #krate::od::NoNumbers as _;
                #krate::od::Numbers::<#of, Self, #number>::RANGE
            });
            let function = quote!(#krate::od::Entry::initially);
            entry = call_at(quote!(#value), function, quote!(#entry, #range));
        }
        if let Some(word) = self.keep {
            let krate = path::canopen_at(word);
            entry = quote_spanned!(word=> #krate::od::Entry::keep(#entry));
        }
        if let Some(word) = self.volatile {
            let krate = path::canopen_at(word);
            entry = quote_spanned!(word=> #krate::od::Entry::volatile(#entry));
        }
        entry
    }

    /// Returns two flags: transmit PDOs may carry the value, and receive PDOs may carry it.
    pub fn directions(&self) -> (bool, bool) {
        let is_among = |rights: &[&str]| {
            self.pdo.is_some()
                && self.access.as_ref().is_some_and(|own| rights.iter().any(|right| own == right))
        };
        (is_among(&["Ro", "Rw", "Rwr", "Const"]), is_among(&["Wo", "Rw", "Rww"]))
    }

    /// Reads a word and the value behind it.
    fn word(&mut self, word: &Ident, input: ParseStream) -> syn::Result<()> {
        let span = word.span();
        match word.to_string().as_str() {
            "record" => self.shape = Shape::Record { as_array: false },
            "array" if self.shape != Shape::Var => self.shape = Shape::Record { as_array: true },
            "array" => self.shape = Shape::Array,
            "pdo" => self.pdo = Some(span),
            "optional" => self.optional = true,
            "keep" => self.keep = Some(span),
            "volatile" => self.volatile = Some(span),
            "low" => self.low = Some(assigned(input)?),
            "high" => self.high = Some(assigned(input)?),
            "default" => self.default = Some(assigned(input)?),
            right => {
                let Some(right) = access(right, span) else {
                    // A value behind it belongs to it.
                    if input.peek(Token![=]) {
                        assigned(input)?;
                    }
                    return Err(Error::new(span, format!("unknown word `{word}`; known are {KNOWN}")));
                };
                if self.access.replace(right).is_some() {
                    return Err(Error::new(span, "a second access right: one is allowed"));
                }
            }
        }
        Ok(())
    }

    /// Refuses words that have no meaning beside the others.
    fn check(&self, words: &[Ident], errors: &mut Errors) {
        for (nth, word) in words.iter().enumerate() {
            let is_record = matches!(self.shape, Shape::Record { .. });
            let text = word.to_string();
            let message = match text.as_str() {
                _ if words.iter().take(nth).any(|other| *other == text) => "this word stands here twice",
                "record" | "array" | "default" => continue,
                _ if is_record => "the fields of the record say this: move it to their `#[sub(..)]`",
                "volatile" if self.keep.is_some() => "`keep` and `volatile` exclude each other",
                "optional" if self.pdo.is_none() => "`optional` is for values that PDOs may carry: add `pdo`",
                _ => continue,
            };
            errors.add(Error::new(word.span(), message));
        }
        self.check_numbers(errors);
    }

    /// Refuses limits and a default that exclude each other, as far as they are plain numbers: one error, where an erroneous constant would
    /// be followed by a note at each use of the object. Constants find those of other expressions.
    fn check_numbers(&self, errors: &mut Errors) {
        let number = |value: &Option<Expr>| value.as_ref().and_then(number);
        let (low, high) = (number(&self.low), number(&self.high));
        if let (Some(low), Some(high)) = (low, high)
            && low > high
        {
            let (first, last) = (&self.low, &self.high);
            let message = format!("`low = {low}` is above `high = {high}`: no value is allowed");
            return errors.add(Error::new_spanned(quote!(#first #last), message));
        }
        let Some(default) = number(&self.default) else { return };
        let message = match (low, high) {
            (_, Some(high)) if default > high => format!("default {default} is above `high = {high}`"),
            (Some(low), _) if default < low => format!("default {default} is below `low = {low}`"),
            _ => return,
        };
        errors.add(Error::new_spanned(&self.default, message));
    }
}

impl Parse for Attribute {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let mut errors = Errors::default();
        let attribute = Attribute::read(input, &mut errors);
        errors.finish().map(|()| attribute)
    }
}

impl Attribute {
    /// Reads an attribute to its end. What cannot be read is left out, with an error.
    pub fn read(input: ParseStream, errors: &mut Errors) -> Self {
        let number = errors.take(input.parse());
        let mut attribute = Attribute::of(number.clone(), input.peek(Token![..]));
        errors.take(input.parse::<Option<Token![..]>>());
        // After an error nothing is said of what stands before the next comma.
        let (mut is_lost, mut words) = (number.is_none(), Vec::new());
        while !input.is_empty() {
            match input.parse::<Option<Token![,]>>() {
                Ok(Some(_)) => is_lost = false,
                _ if !is_lost => {
                    errors.add(input.error("a comma is missing"));
                    is_lost = true;
                }
                _ => {}
            }
            if input.is_empty() {
                break;
            }
            if is_lost && !input.peek(Ident::peek_any) {
                errors.take(input.parse::<TokenTree>());
                continue;
            }
            let word = errors.take(input.call(Ident::parse_any));
            match word.and_then(|word| errors.take(attribute.word(&word, input)).map(|()| word)) {
                Some(word) => words.push(word),
                None => is_lost = true,
            }
        }
        attribute.check(&words, errors);
        attribute
    }

    /// Makes the attribute of a value with this number and no word. `None`: it has no number that can be read.
    pub fn of(number: Option<LitInt>, in_a_row: bool) -> Self {
        Attribute {
            number: number.unwrap_or_else(|| LitInt::new("0xFFFF", Span::call_site())),
            in_a_row,
            shape: Shape::Var,
            access: None,
            pdo: None,
            optional: false,
            keep: None,
            volatile: None,
            low: None,
            high: None,
            default: None,
        }
    }
}

/// Returns a call whose errors the compiler reports at `place`: from its first to its last token.
fn call_at(place: TokenStream, function: TokenStream, arguments: TokenStream) -> TokenStream {
    let mut spans = place.into_iter().map(|token| token.span());
    let first = spans.next().unwrap_or_else(Span::call_site);
    let function = function.into_iter().map(|mut token| {
        token.set_span(first);
        token
    });
    let mut arguments = Group::new(Delimiter::Parenthesis, arguments);
    arguments.set_span(spans.last().unwrap_or(first));
    function.chain([arguments.into()]).collect()
}

/// The value of a plain number, `None` for any other expression.
fn number(value: &Expr) -> Option<i128> {
    match value {
        Expr::Lit(ExprLit { lit: Lit::Int(value), .. }) => value.base10_parse().ok(),
        Expr::Unary(ExprUnary { op: UnOp::Neg(_), expr, .. }) => number(expr).map(|value| -value),
        Expr::Paren(ExprParen { expr, .. }) | Expr::Group(ExprGroup { expr, .. }) => number(expr),
        _ => None,
    }
}

fn assigned(input: ParseStream) -> syn::Result<Expr> {
    input.parse::<Token![=]>()?;
    input.parse()
}

/// The variant of `Access`.
fn access(right: &str, span: Span) -> Option<Ident> {
    let name = match right {
        "ro" => "Ro",
        "wo" => "Wo",
        "rw" => "Rw",
        "rwr" => "Rwr",
        "rww" => "Rww",
        "constant" => "Const",
        _ => return None,
    };
    Some(Ident::new(name, span))
}
