//! Public documentation of the protocol crate, pages and names of tests are plain English: the rules that a program can
//! check.
//!
//! The check reads every public item of `shared/src`, `shared/canopen/src` and `shared/derive/src`, also in private modules, because these export
//! items. It judges words alone: a sentence that passes can still be hard to read.

use std::fs;
use std::path::{Path, PathBuf};

use syn::spanned::Spanned;
use syn::{Attribute, Expr, Fields, ImplItem, Item, Lit, Meta, TraitItem, Visibility};

/// First words of a question, or of an addition to the name. The first words have to say what the item is or does.
const OPENINGS: [&str; 6] = ["What", "Whether", "Which", "Who", "Of", "By"];

/// Words in place of the verb of the field: send, receive, report, raise, abort.
const VAGUE: [&str; 4] = ["told", "tell", "tells", "nobody"];

/// Least number of words. A shorter text repeats the name of the item.
const LEAST_WORDS: usize = 3;

/// Longest name of a test.
const LONGEST_NAME: usize = 60;

/// A documentation comment and where it begins.
struct Doc {
    line: usize,
    item: String,
    text: String,
    /// The first line is the name of an object in its data sheet, and may be short.
    is_titled: bool,
}

/// A documentation comment that breaks a rule.
#[derive(Debug, PartialEq, Eq)]
struct Fault {
    line: usize,
    item: String,
    rule: Rule,
}

/// The rules, each with the advice that it gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// Begin with a verb or with the thing itself.
    Opening,
    /// Give meaning, unit and range.
    Short,
    /// Use the verb of the field, and name the actor.
    Vague,
}

/// Returns the faults of the public documentation in `source`.
fn faults(source: &str) -> Vec<Fault> {
    let file = syn::parse_file(source).expect("a source");
    let mut docs = Vec::new();
    note(&mut docs, "the module", &file.attrs);
    items(&mut docs, &file.items);
    let mut found = Vec::new();
    for doc in docs {
        let mut fault = |rule| found.push(Fault { line: doc.line, item: doc.item.clone(), rule });
        if OPENINGS.contains(&words(&doc.text).next().unwrap_or_default()) {
            fault(Rule::Opening);
        }
        if !doc.is_titled && words(&doc.text).count() < LEAST_WORDS {
            fault(Rule::Short);
        }
        if is_vague(&doc.text) {
            fault(Rule::Vague);
        }
    }
    found
}

/// Returns the words of `text` without punctuation. An identifier is one word.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !letter.is_alphanumeric() && letter != '_').filter(|word| !word.is_empty())
}

/// Returns whether one of the vague words is in `text`.
fn is_vague(text: &str) -> bool {
    words(text).any(|word| VAGUE.contains(&word.to_lowercase().as_str()))
}

/// Collects the documentation of the public items among `list`, and what is public in them.
fn items(docs: &mut Vec<Doc>, list: &[Item]) {
    for item in list {
        match item {
            Item::Mod(module) if !is_test(&module.attrs) => {
                if is_public(&module.vis) {
                    note(docs, &module.ident, &module.attrs);
                }
                module.content.iter().for_each(|(_, inner)| items(docs, inner));
            }
            Item::Struct(item) if is_public(&item.vis) => {
                note(docs, &item.ident, &item.attrs);
                fields(docs, &item.ident, &item.fields, is_public);
            }
            Item::Enum(item) if is_public(&item.vis) => {
                note(docs, &item.ident, &item.attrs);
                for variant in &item.variants {
                    let name = format!("{}::{}", item.ident, variant.ident);
                    note(docs, &name, &variant.attrs);
                    fields(docs, &name, &variant.fields, |_| true);
                }
            }
            Item::Trait(item) if is_public(&item.vis) => {
                note(docs, &item.ident, &item.attrs);
                for inner in &item.items {
                    match inner {
                        TraitItem::Fn(inner) => {
                            note(docs, &format!("{}::{}", item.ident, inner.sig.ident), &inner.attrs);
                        }
                        TraitItem::Const(inner) => {
                            note(docs, &format!("{}::{}", item.ident, inner.ident), &inner.attrs);
                        }
                        TraitItem::Type(inner) => {
                            note(docs, &format!("{}::{}", item.ident, inner.ident), &inner.attrs);
                        }
                        _ => {}
                    }
                }
            }
            Item::Impl(item) if item.trait_.is_none() && !is_test(&item.attrs) => {
                for inner in &item.items {
                    match inner {
                        ImplItem::Fn(inner) if is_public(&inner.vis) => {
                            note(docs, &inner.sig.ident, &inner.attrs);
                        }
                        ImplItem::Const(inner) if is_public(&inner.vis) => {
                            note(docs, &inner.ident, &inner.attrs);
                        }
                        _ => {}
                    }
                }
            }
            Item::Fn(item) if is_public(&item.vis) => note(docs, &item.sig.ident, &item.attrs),
            Item::Const(item) if is_public(&item.vis) => note(docs, &item.ident, &item.attrs),
            Item::Static(item) if is_public(&item.vis) => note(docs, &item.ident, &item.attrs),
            Item::Type(item) if is_public(&item.vis) => note(docs, &item.ident, &item.attrs),
            Item::Macro(item) => {
                if let Some(name) = &item.ident {
                    note(docs, name, &item.attrs);
                }
            }
            _ => {}
        }
    }
}

fn fields(docs: &mut Vec<Doc>, of: &impl ToString, list: &Fields, counts: impl Fn(&Visibility) -> bool) {
    for (place, field) in list.iter().enumerate().filter(|(_, field)| counts(&field.vis)) {
        let name = field.ident.as_ref().map_or(place.to_string(), ToString::to_string);
        note(docs, &format!("{}.{name}", of.to_string()), &field.attrs);
    }
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string() == "test",
        _ => false,
    })
}

/// Adds the documentation among `attributes`, if there is one.
fn note(docs: &mut Vec<Doc>, item: &(impl ToString + ?Sized), attributes: &[Attribute]) {
    let lines: Vec<_> =
        attributes.iter().filter_map(|attribute| Some((attribute.span(), line(attribute)?))).collect();
    let Some((first, _)) = lines.first() else { return };
    docs.push(Doc {
        line: first.start().line,
        item: item.to_string(),
        text: lines.iter().map(|(_, line)| line.as_str()).collect::<Vec<_>>().join("\n"),
        is_titled: attributes
            .iter()
            .any(|attribute| ["object", "sub"].iter().any(|name| attribute.path().is_ident(name))),
    });
}

/// Returns the text of an attribute that is a line of documentation.
fn line(attribute: &Attribute) -> Option<String> {
    match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(literal) => match &literal.lit {
                Lit::Str(text) => Some(text.value()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    }
}

/// Returns the names of functions with the attribute `test` that are too long.
fn long_names(source: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut is_test = false;
    for line in source.lines().map(str::trim) {
        if line == "#[test]" {
            is_test = true;
        } else if let Some(rest) = line.strip_prefix("fn ")
            && std::mem::take(&mut is_test)
        {
            let name = rest.split('(').next().unwrap_or_default();
            if name.len() > LONGEST_NAME {
                found.push(name.to_owned());
            }
        }
    }
    found
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace").to_owned()
}

/// Returns the files below `folder` with this extension, without build results and hidden folders.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|found| found == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn text(file: &Path) -> String {
    fs::read_to_string(file).expect("a text")
}

/// Public documentation says what an item is or does, in the words of the field.
#[test]
fn public_docs_are_plain_english() {
    let sources: Vec<_> = ["shared/src", "shared/canopen/src", "shared/derive/src"]
        .iter()
        .flat_map(|folder| files(&root().join(folder), "rs"))
        .collect();
    assert!(sources.len() > 150, "{}", sources.len());
    let mut found = Vec::new();
    for source in sources {
        for Fault { line, item, rule } in faults(&text(&source)) {
            found.push(format!(
                "{}:{line}: {item}: {rule:?}",
                source.strip_prefix(root()).expect("below").display()
            ));
        }
    }
    assert!(found.is_empty(), "{} docs to rewrite:\n{}", found.len(), found.join("\n"));
}

/// The faults of a source, without their lines.
fn rules(source: &str) -> Vec<(String, Rule)> {
    faults(source).into_iter().map(|fault| (fault.item, fault.rule)).collect()
}

#[test]
fn an_opening_that_asks_is_found_in_each_kind_of_item() {
    let openings =
        ["What it is.", "Whether it is.", "Which of them.", "Who sends it.", "Of the bus.", "By the one."];
    for opening in openings {
        let kinds = [
            (format!("//! {opening}"), "the module"),
            (format!("/// {opening}\npub mod m {{}}"), "m"),
            (format!("mod m {{\n/// {opening}\npub fn f() {{}}\n}}"), "f"),
            (format!("/// {opening}\npub struct S;"), "S"),
            (format!("pub struct S {{\n/// {opening}\npub a: u8 }}"), "S.a"),
            (format!("pub struct S(\n/// {opening}\npub u8);"), "S.0"),
            (format!("pub enum E {{\n/// {opening}\nA }}"), "E::A"),
            (format!("pub enum E {{ A {{\n/// {opening}\na: u8 }} }}"), "E::A.a"),
            (format!("pub trait T {{\n/// {opening}\nfn f(); }}"), "T::f"),
            (format!("pub trait T {{\n/// {opening}\nconst C: u8; }}"), "T::C"),
            (format!("pub trait T {{\n/// {opening}\ntype A; }}"), "T::A"),
            (format!("impl S {{\n/// {opening}\npub fn f() {{}} }}"), "f"),
            (format!("impl S {{\n/// {opening}\npub const C: u8 = 0; }}"), "C"),
            (format!("/// {opening}\npub const C: u8 = 0;"), "C"),
            (format!("/// {opening}\npub type A = u8;"), "A"),
            (format!("#[cfg(feature = \"x\")]\n/// {opening}\n#[must_use]\npub fn f() {{}}"), "f"),
        ];
        for (source, item) in kinds {
            assert_eq!(rules(&source), [(item.to_owned(), Rule::Opening)], "{source}");
        }
    }
}

#[test]
fn a_text_of_two_words_is_found() {
    let short = |item: &str| vec![(item.to_owned(), Rule::Short)];
    assert_eq!(rules("/// The bus.\npub fn f() {}"), short("f"));
    assert_eq!(rules("/// Which bus.\npub fn f() {}").len(), 2, "short, and an opening that asks");
    assert_eq!(rules("/// Bus of the node.\npub fn f() {}"), []);
    // The first line of an object is its name in EDS and DCF.
    assert_eq!(rules("pub struct S {\n/// Rate\n#[sub(1, ro)]\npub rate: u8 }"), []);
    assert_eq!(rules("pub struct S {\n/// Rate\n#[skip]\npub rate: u8 }"), short("S.rate"));
}

#[test]
fn a_vague_word_is_found_in_every_line() {
    for word in ["told", "tell", "tells", "nobody", "Nobody"] {
        let source =
            format!("/// Takes an event.\n///\n/// # Errors\n/// When {word} does.\npub fn f() {{}}");
        assert_eq!(rules(&source), [("f".to_owned(), Rule::Vague)], "{source}");
    }
    assert_eq!(rules("/// Writes the word diagnostics, and is_told as well.\npub fn f() {}"), []);
}

#[test]
fn items_that_are_not_public_are_ignored() {
    let sources = [
        "/// What.\nfn f() {}",
        "/// What.\npub(crate) fn f() {}",
        "struct S {\n/// What.\npub a: u8 }",
        "pub struct S {\n/// What.\na: u8 }",
        "impl T for S {\n/// What.\nfn f() {} }",
        "#[cfg(test)]\nmod tests {\n/// What.\npub fn f() {} }",
        "// What.\npub fn f() {}",
    ];
    for source in sources {
        assert_eq!(rules(source), [], "{source}");
    }
}

#[test]
fn a_fault_has_the_line_of_its_comment() {
    let source =
        "//! A module of this crate.\n\npub struct S;\n\n/// Of a slave.\n#[inline]\npub fn f() {}\n";
    assert_eq!(faults(source), [Fault { line: 5, item: "f".to_owned(), rule: Rule::Opening }]);
}

/// The pages use the verbs of the field.
#[test]
fn pages_are_plain_english() {
    let mut pages = files(&root().join("docs"), "md");
    pages.extend(["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|name| root().join(name)));
    let mut found = Vec::new();
    for page in pages {
        for (line, text) in (1..).zip(text(&page).lines()) {
            if is_vague(text) {
                found.push(format!("{}:{line}: {text}", page.strip_prefix(root()).expect("below").display()));
            }
        }
    }
    assert!(found.is_empty(), "{} lines to rewrite:\n{}", found.len(), found.join("\n"));
}

#[test]
fn names_of_tests_are_short() {
    let sources = files(&root(), "rs");
    let found: Vec<_> = sources.iter().flat_map(|source| long_names(&text(source))).collect();
    assert!(found.is_empty(), "{} names to shorten:\n{}", found.len(), found.join("\n"));
}

#[test]
fn a_long_name_of_a_test_is_found() {
    let long = "a".repeat(61);
    let source = |attribute: &str, name: &str| format!("{attribute}\nfn {name}() {{}}\n");
    assert_eq!(long_names(&source("#[test]", &long)), std::slice::from_ref(&long));
    assert_eq!(long_names(&source("#[test]\n#[should_panic]", &long)), std::slice::from_ref(&long));
    assert_eq!(long_names(&source("#[test]", &long[1..])), [""; 0]);
    assert_eq!(long_names(&source("#[inline]", &long)), [""; 0]);
}
