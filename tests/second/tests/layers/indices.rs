//! Indices of objects that a source file writes as numbers.
//!
//! The index of an object is declared once, at the field with `#[object(0x....)]`. Code reaches its index by the
//! constant that the derive makes of the field.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use proc_macro2::{Delimiter, Literal, TokenStream, TokenTree};

use crate::paths::Source;
use crate::protocol::{source, sources};

/// Communication profile and the objects of the ECSS standard.
const INDICES: std::ops::RangeInclusive<u32> = 0x1000..=0x2FFF;

/// Files whose numbers are no indices: emergency error codes (CiA 301 table 26) begin at 1000h, too. And the table of the
/// standard that says which objects a minimal slave may have: it names those of all services.
const OTHER_NUMBERS: [&str; 2] = ["emcy/code.rs", "node/minimal/objects.rs"];

/// Place of a number.
#[derive(Clone)]
struct Place<'a> {
    file: &'a str,
    line: usize,
}

/// Each literal that repeats the index of an object, with file and line: another declaration, the number itself, or a word
/// for a PDO mapping.
fn repeated(sources: &[Source]) -> Vec<String> {
    let mut homes = BTreeMap::<u32, Place<'_>>::new();
    let mut others = Vec::new();
    for source in sources {
        let mut found = Found::default();
        found.read(source.tokens.clone());
        let place = |line| Place { file: &source.name, line };
        for (line, index) in found.declared {
            match homes.entry(index) {
                Entry::Vacant(home) => _ = home.insert(place(line)),
                Entry::Occupied(_) => others.push((place(line), index)),
            }
        }
        if !OTHER_NUMBERS.contains(&source.name.as_str()) {
            others.extend(found.others.into_iter().map(|(line, number)| (place(line), number)));
        }
    }
    let offence = |(place, index): (Place<'_>, u32)| {
        let home = homes.get(&index)?;
        let Place { file, line } = place;
        Some(format!("{file}:{line}: {index:04X}h has its home in {}:{}", home.file, home.line))
    };
    others.into_iter().filter_map(offence).collect()
}

/// Hexadecimal numbers of a file with their lines.
#[derive(Default)]
struct Found {
    /// First argument of `#[object]`.
    declared: Vec<(usize, u32)>,
    others: Vec<(usize, u32)>,
}

impl Found {
    fn read(&mut self, tokens: TokenStream) {
        let mut tokens = tokens.into_iter().peekable();
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Ident(ident) if ident == "object" => {
                    if let Some(TokenTree::Group(group)) = tokens.peek()
                        && group.delimiter() == Delimiter::Parenthesis
                        && let Some(TokenTree::Literal(literal)) = group.stream().into_iter().next()
                    {
                        self.declared.extend(index(&literal).map(|index| (line(&literal), index)));
                        let rest = group.stream().into_iter().skip(1).collect();
                        tokens.next();
                        self.read(rest);
                    }
                }
                TokenTree::Group(group) => self.read(group.stream()),
                TokenTree::Literal(literal) => {
                    self.others.extend(index(&literal).map(|index| (line(&literal), index)));
                }
                TokenTree::Ident(_) | TokenTree::Punct(_) => {}
            }
        }
    }
}

fn line(literal: &Literal) -> usize {
    literal.span().start().line
}

/// The index that a hexadecimal number is, or that is the upper half of a mapping word: sub-index and 1 to 64 bits below.
fn index(literal: &Literal) -> Option<u32> {
    let text = literal.to_string().replace('_', "");
    let digits = text.strip_prefix("0x")?;
    let digits = ["u16", "u32", "usize"].iter().find_map(|kind| digits.strip_suffix(kind)).unwrap_or(digits);
    let number = u32::from_str_radix(digits, 16).ok()?;
    let is_word = number > 0xFFFF && (1..=64).contains(&(number & 0xFF));
    let index = if is_word { number >> 16 } else { number };
    Some(index).filter(|index| INDICES.contains(index))
}

#[test]
fn each_index_is_written_once() {
    let offences = repeated(&sources());
    assert!(offences.is_empty(), "{}", offences.join("\n"));
}

/// Given an object and its row, when another file repeats the index in any form that code has, then that is found.
#[test]
fn every_form_of_a_repeated_index_is_found() {
    let home = "struct S { #[object(0x1016, array, rw)] a: [u32; 8], #[object(0x1400.., record)] b: [R; 4] }";
    let forms = [
        ("const AT: u16 = 0x1016;", 0x1016),
        ("const AT: u32 = 0x1016_u32;", 0x1016),
        ("const AT: Address = Address::new(0x10_16, 3);", 0x1016),
        ("fn f() { match index { 0x1000..=0x1016 => {} } }", 0x1016),
        ("fn f() { assert!(index == 0x1016, \"other\") }", 0x1016),
        ("const WORD: u32 = 0x1016_0120;", 0x1016),
        ("const RPDO: u16 = 0x1400;", 0x1400),
        ("struct T { #[object(0x1016, ro)] a: u8 }", 0x1016),
        ("struct T { #[object(0x6000, rw, default = 0x1016)] a: u16 }", 0x1016),
        ("macro_rules! m { () => { 0x1016 } }", 0x1016),
    ];
    for (form, index) in forms {
        let sources = [source("heartbeat/objects.rs", home), source("node/rules.rs", form)];
        let expected = format!("node/rules.rs:1: {index:04X}h has its home in heartbeat/objects.rs:1");
        assert_eq!(repeated(&sources), [expected], "{form}");
    }
}

#[test]
fn other_numbers_and_words_in_comments_are_no_indices() {
    let home = source("heartbeat/objects.rs", "struct S { #[object(0x1016, rw)] a: u32 }");
    let text = r#"
        //! Object 0x1016.
        /// Nor here: 0x1016.
        const FLAG: u32 = 0x1016_0000;
        const OTHER: [u32; 3] = [0x1017, 0x3016, 4118];
        fn f(object: u8) { println!("0x1016 {object}") }
    "#;
    assert_eq!(repeated(&[home, source("node/rules.rs", text)]), [""; 0]);
    let home = source("node/objects.rs", "struct S { #[object(0x1000, ro)] a: u32 }");
    let codes = source("emcy/code.rs", "enum ErrorCode { Generic = 0x1000 }");
    assert_eq!(repeated(&[home, codes]), [""; 0]);
}
