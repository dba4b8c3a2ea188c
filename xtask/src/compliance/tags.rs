//! Tags in a source file: `Verifies:` and `Notices:` lines of doc comments, and the functions that they stand on.
//!
//! Reads tokens, not items: a test in a macro is a test like any other.

use std::path::{Path, PathBuf};

use anyhow::Context;
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// What a doc comment says is verified, and by what.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tag {
    /// From the root of the repository.
    pub file: String,
    /// Of the first such line.
    pub line: usize,
    /// The function; empty: the comment is not on a function.
    pub function: String,
    /// Modules around the function, from the root of its target.
    pub modules: Vec<String>,
    /// The target that compiles it.
    pub target: Target,
    /// Whether it is a test that `cargo test` runs.
    pub runs: bool,
    /// Requirements, ranges resolved; as written where they cannot be.
    pub ids: Vec<String>,
    /// Those that the comment of a module (`//!`) names: its tests verify them together.
    pub of_module: Vec<String>,
    /// Those of a `Notices:` line: the test fails when a slip violates the requirement.
    pub noticed: Vec<String>,
}

impl Tag {
    /// Returns whether the test, or its module, names a requirement.
    pub fn names(&self, id: &str) -> bool {
        self.ids.iter().chain(&self.of_module).any(|own| own == id)
    }

    /// Returns the name of the test as libtest prints it: `device::saving::save_is_answered`.
    pub fn test(&self) -> String {
        self.modules.iter().chain([&self.function]).map(String::as_str).collect::<Vec<_>>().join("::")
    }
}

/// A target of a package, as options of `cargo test` select it. The default is no target.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Target {
    /// Name of the package.
    pub package: String,
    /// Folder of the package, from the root of the repository.
    pub folder: String,
    /// Options that select it within the package: `--lib`, or `--test` and a name.
    pub options: Vec<String>,
    /// Place of the package among those that `cargo test` runs; `None`: it runs in a later tier.
    pub place: Option<usize>,
}

/// A source that is read.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// From the root of the repository.
    pub file: String,
    /// Part of a target whose tests are run.
    pub is_tested: bool,
    /// The target that compiles it.
    pub target: Target,
    /// Modules that lead to it, from the root of its target.
    pub modules: Vec<String>,
}

/// What a source has.
pub struct Source {
    /// In their order.
    pub tags: Vec<Tag>,
    /// Modules in files of their own.
    pub modules: Vec<Module>,
}

/// `mod name;`
pub struct Module {
    /// Modules in braces around it.
    around: Vec<String>,
    name: String,
    /// By a `path` attribute.
    path: Option<String>,
}

impl Module {
    /// Modules that lead to it from its target; `of`: those that lead to the file that declares it.
    pub fn names(&self, of: &[String]) -> Vec<String> {
        of.iter().chain(&self.around).chain([&self.name]).cloned().collect()
    }

    /// Its file; `of`: the file that declares it, `folder`: where modules of that file are.
    pub fn file(&self, of: &Path, folder: &Path) -> PathBuf {
        if let Some(path) = &self.path {
            return of.with_file_name(path);
        }
        let folder = self.around.iter().fold(folder.to_owned(), |folder, module| folder.join(module));
        let file = folder.join(format!("{}.rs", self.name));
        if file.exists() { file } else { folder.join(&self.name).join("mod.rs") }
    }
}

/// Tags and modules of a source.
///
/// # Errors
/// When it is not Rust.
pub fn read(text: &str, reading: &Reading) -> anyhow::Result<Source> {
    let tokens: TokenStream =
        text.parse().map_err(|error| anyhow::anyhow!("{error}")).with_context(|| reading.file.clone())?;
    let mut reader = Reader::default();
    reader.read(tokens);
    // A comment that is no doc comment is not among the tokens.
    for (line, text) in (1..).zip(text.lines()) {
        if is_tag_comment(text) && !reader.documented.contains(&line) {
            reader.tags.push(Tag { line, ids: ids(text), ..Tag::default() });
        }
    }
    for tag in &mut reader.tags {
        tag.file.clone_from(&reading.file);
        tag.target.clone_from(&reading.target);
        tag.modules.splice(..0, reading.modules.iter().cloned());
        tag.runs &= reading.is_tested;
    }
    Ok(Source { tags: reader.tags, modules: reader.modules })
}

fn is_tag_comment(line: &str) -> bool {
    let line = line.trim_start();
    line.starts_with("//") && line.trim_start_matches(['/', '!']).trim_start().starts_with(MARK)
}

/// Begins the line of a tag.
const MARK: &str = "Verifies:";
/// Begins the line with the slip that a test notices: `Notices: ECSS 8.3.3h: the slave toggles early.`
const SLIP: &str = "Notices:";

#[derive(Default)]
struct Reader {
    tags: Vec<Tag>,
    modules: Vec<Module>,
    around: Vec<String>,
    /// Requirements that the modules around name in their own comments.
    of_modules: Vec<String>,
    /// Lines of doc comments with tags.
    documented: Vec<usize>,
}

/// Attributes before an item.
#[derive(Default)]
struct Attributes {
    lines: Vec<usize>,
    ids: Vec<String>,
    noticed: Vec<String>,
    is_test: bool,
    is_ignored: bool,
    path: Option<String>,
}

impl Reader {
    fn read(&mut self, tokens: TokenStream) {
        let mut attributes = Attributes::default();
        let mut own = Attributes::default();
        let (outer, tags) = (self.of_modules.len(), self.tags.len());
        let mut tokens = tokens.into_iter().peekable();
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Punct(punct) if punct.as_char() == '#' => {
                    let is_inner = matches!(tokens.peek(), Some(TokenTree::Punct(_)));
                    if is_inner {
                        tokens.next();
                    }
                    if let Some(TokenTree::Group(group)) = tokens.next() {
                        if is_inner {
                            let known = own.ids.len();
                            own.add(&group);
                            self.of_modules.extend_from_slice(&own.ids[known..]);
                        } else {
                            attributes.add(&group);
                        }
                    }
                }
                // What may stand before `fn`.
                TokenTree::Ident(word) if WORDS.contains(&word.to_string().as_str()) => {
                    if let Some(TokenTree::Group(group)) = tokens.peek()
                        && group.delimiter() == Delimiter::Parenthesis
                    {
                        tokens.next(); // of `pub(crate)`
                    }
                }
                TokenTree::Ident(word) if word == "fn" => {
                    let name = tokens.next().map(|name| name.to_string()).unwrap_or_default();
                    self.tag(std::mem::take(&mut attributes), name);
                }
                TokenTree::Ident(word) if word == "mod" => {
                    let name = tokens.next().map(|name| name.to_string()).unwrap_or_default();
                    let path = attributes.path.take();
                    self.tag(std::mem::take(&mut attributes), String::new());
                    match tokens.next() {
                        Some(TokenTree::Group(group)) => {
                            self.around.push(name);
                            self.read(group.stream());
                            self.around.pop();
                        }
                        _ => self.modules.push(Module { around: self.around.clone(), name, path }),
                    }
                }
                TokenTree::Group(group) => {
                    self.tag(std::mem::take(&mut attributes), String::new());
                    self.read(group.stream());
                }
                _ => self.tag(std::mem::take(&mut attributes), String::new()),
            }
        }
        self.tag(attributes, String::new());
        self.of_modules.truncate(outer);
        let has_tests = self.tags[tags..].iter().any(|tag| tag.runs);
        self.documented.extend(&own.lines);
        if !own.lines.is_empty() && !has_tests {
            self.tag(Attributes { is_test: false, ..own }, String::new());
        }
    }

    fn tag(&mut self, attributes: Attributes, function: String) {
        let Attributes { lines, ids, noticed, is_test, is_ignored, .. } = attributes;
        let of_module = if is_test { self.of_modules.clone() } else { Vec::new() };
        if lines.is_empty() && of_module.is_empty() {
            return;
        }
        let line = lines.first().copied().unwrap_or(0);
        let runs = is_test && !is_ignored && !function.is_empty();
        self.documented.extend(lines);
        let modules = self.around.clone();
        self.tags.push(Tag { line, function, modules, runs, ids, of_module, noticed, ..Tag::default() });
    }
}

/// Words before `fn`.
const WORDS: [&str; 5] = ["pub", "async", "const", "unsafe", "extern"];

impl Attributes {
    fn add(&mut self, group: &Group) {
        let text = group.stream().to_string();
        match text.as_str() {
            "test" => self.is_test = true,
            _ if text.ends_with(":: test") => self.is_test = true,
            _ if text == "ignore" || text.starts_with("ignore =") => self.is_ignored = true,
            _ => {}
        }
        let mut tokens = group.stream().into_iter();
        let (Some(TokenTree::Ident(name)), Some(_), Some(TokenTree::Literal(value))) =
            (tokens.next(), tokens.next(), tokens.next())
        else {
            return;
        };
        let value_text = value.to_string();
        let quoted = value_text.strip_prefix('r').unwrap_or(&value_text).trim_matches('#');
        let inner = quoted.trim_matches('"');
        if name == "path" {
            self.path = Some(inner.to_owned());
        } else if name == "doc" {
            let first = value.span().start().line;
            for (line, text) in (first..).zip(inner.lines()) {
                if text.trim_start().starts_with(MARK) {
                    self.lines.push(line);
                    self.ids.extend(ids(text));
                } else if text.trim_start().starts_with(SLIP) {
                    self.lines.push(line);
                    self.noticed.push(slip(text));
                }
            }
        }
    }
}

/// Requirements that a line names. `7.1.3a to d` are four.
fn ids(line: &str) -> Vec<String> {
    let Some((_, list)) = line.split_once(MARK) else { return Vec::new() };
    let list = list.trim().trim_end_matches('.');
    list.split(',').flat_map(|part| range(part.trim().trim_start_matches("ECSS ").trim())).collect()
}

/// The requirement of a line with a slip.
fn slip(line: &str) -> String {
    let text = line.split_once(SLIP).map_or("", |(_, text)| text).trim().trim_start_matches("ECSS ");
    text.split(':').next().unwrap_or_default().trim().to_owned()
}

/// The members of `7.1.3a to d`; what is no range stands for itself.
fn range(part: &str) -> Vec<String> {
    let whole = || vec![part.to_owned()];
    let Some((from, to)) = part.split_once(" to ") else { return whole() };
    let (Some(first), Some(last)) = (from.chars().last(), to.chars().last()) else { return whole() };
    let clause = &from[..from.len() - first.len_utf8()];
    if !first.is_ascii_lowercase() || !last.is_ascii_lowercase() || first > last {
        return whole();
    }
    if to.len() > 1 && to[..to.len() - 1] != *clause {
        return whole();
    }
    (first..=last).map(|letter| format!("{clause}{letter}")).collect()
}
