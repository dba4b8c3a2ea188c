//! Paths of a source file that lead into a module of its own crate.
//!
//! Reads tokens, not items: a path in a macro or in an attribute is a path like any other.

use std::iter::Peekable;

use proc_macro2::token_stream::IntoIter;
use proc_macro2::{Delimiter, Group, Spacing, TokenStream, TokenTree};

type Tokens = Peekable<IntoIter>;

/// A file of a crate.
pub struct Source {
    /// Name in findings.
    pub name: String,
    /// Module of the file, from the root of the crate.
    pub module: Vec<String>,
    pub tokens: TokenStream,
}

impl Source {
    /// `module`: from the root of the crate.
    pub fn new(name: &str, module: Vec<String>, text: &str) -> Source {
        let tokens = text.parse().unwrap_or_else(|error| panic!("{name}: {error}"));
        Source { name: name.to_owned(), module, tokens }
    }

    /// Paths and modules of the file; `own_name`: name by which the crate names itself, besides `crate`.
    pub fn read(&self, own_name: Option<&str>) -> Reading {
        let mut reader = Reader { own_name, found: Reading::default() };
        reader.read(self.tokens.clone(), &self.module, false);
        reader.found
    }
}

/// Contents of a file.
#[derive(Default)]
pub struct Reading {
    pub paths: Vec<Path>,
    pub modules: Vec<Module>,
}

/// `mod name;` or `mod name { .. }`
pub struct Module {
    /// Its path from the root of the crate.
    pub path: Vec<String>,
    pub has_file: bool,
    /// Whether it is compiled only for unit tests.
    pub is_test: bool,
    /// File by a `path` attribute.
    pub file: Option<String>,
}

/// A path from the root of the crate.
#[derive(Clone, Default)]
pub struct Path {
    pub line: usize,
    /// Module that contains the path.
    pub module: Vec<String>,
    /// Empty: the root itself, or all that it has.
    pub segments: Vec<String>,
    /// Whether it is part of a `use`.
    is_use: bool,
    /// Whether it is part of a `pub use` with any visibility.
    pub is_exported: bool,
    /// Whether it starts with neither `crate`, `self` nor `super` but the name of a child module or of another crate.
    pub is_relative: bool,
    /// Whether it is compiled only for unit tests.
    pub is_test: bool,
    pub binds: Binds,
}

/// Name that a `use` declares.
#[derive(Clone, Default, PartialEq, Eq)]
pub enum Binds {
    /// Not a `use`.
    #[default]
    Nothing,
    Name(String),
    /// `*`
    All,
}

struct Reader<'a> {
    own_name: Option<&'a str>,
    found: Reading,
}

impl Reader<'_> {
    /// Reads tokens that stand in `module`.
    fn read(&mut self, tokens: TokenStream, module: &[String], is_test: bool) {
        let mut tokens = tokens.into_iter().peekable();
        let plain = Path { module: module.to_vec(), is_test, ..Path::default() };
        let mut context = plain.clone();
        let (mut is_public, mut inner, mut file) = (false, None, None);
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Group(group) => {
                    let mut nested = module.to_vec();
                    if group.delimiter() == Delimiter::Brace {
                        nested.extend(inner.take());
                    }
                    file = path_attribute(&group).or(file);
                    context.is_test |= is_cfg_test(&group);
                    self.read(group.stream(), &nested, context.is_test);
                    // `pub(crate) use` is public here, too.
                    is_public &= group.delimiter() == Delimiter::Parenthesis;
                    if group.delimiter() == Delimiter::Brace {
                        context.is_test = is_test;
                    }
                }
                TokenTree::Ident(ident) => {
                    let name = ident.to_string();
                    context.line = ident.span().start().line;
                    match name.as_str() {
                        "use" => {
                            (context.is_use, context.is_exported) = (true, is_public);
                            self.relative(&mut tokens, context.clone());
                        }
                        "mod" => inner = self.declared(&mut tokens, &context, file.take()),
                        _ => {
                            if let Some(segments) = self.root(&name, module) {
                                self.follow(&mut tokens, Path { segments, ..context.clone() });
                            }
                        }
                    }
                    is_public = name == "pub";
                }
                TokenTree::Punct(punct) if punct.as_char() == ';' => {
                    (context, inner, file) = (plain.clone(), None, None);
                }
                _ => {}
            }
        }
    }

    /// Returns the module of the first segment of a path, unless the path is relative.
    fn root(&self, name: &str, module: &[String]) -> Option<Vec<String>> {
        match name {
            "crate" => Some(Vec::new()),
            "self" => Some(module.to_vec()),
            "super" => Some(parent(module)),
            _ => (self.own_name == Some(name)).then(Vec::new),
        }
    }

    /// Reads a `use` whose path is relative to the module.
    fn relative(&mut self, tokens: &mut Tokens, context: Path) {
        let mut path = Path { is_relative: true, segments: context.module.clone(), ..context };
        match tokens.peek().cloned() {
            Some(TokenTree::Ident(ident)) if self.root(&ident.to_string(), &path.module).is_none() => {
                tokens.next();
                step(&mut path.segments, &ident.to_string());
                self.follow(tokens, path);
            }
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                tokens.next();
                self.branches(&group, &path);
            }
            _ => {}
        }
    }

    /// Reads on behind `mod`, and returns the name of the module.
    fn declared(&mut self, tokens: &mut Tokens, context: &Path, file: Option<String>) -> Option<String> {
        let name = next_ident(tokens)?;
        let has_file = tokens.peek().is_some_and(|token| token.to_string() == ";");
        let path = [&context.module[..], std::slice::from_ref(&name)].concat();
        self.found.modules.push(Module { path, has_file, is_test: context.is_test, file });
        Some(name)
    }

    /// Reads on behind `path`, which has its root so far.
    fn follow(&mut self, tokens: &mut Tokens, mut path: Path) {
        let mut is_path = path.is_use;
        while skip_colons(tokens) {
            is_path = true;
            match tokens.peek().cloned() {
                Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                    tokens.next();
                    return self.branches(&group, &path);
                }
                Some(TokenTree::Ident(ident)) => {
                    tokens.next();
                    step(&mut path.segments, &ident.to_string());
                }
                // `*`, or the generic arguments of a path.
                _ => break,
            }
        }
        if path.is_use {
            path.binds = binds(tokens, &path.segments);
        }
        self.found.paths.extend(is_path.then_some(path));
    }

    /// Reads the branches of a `use` tree behind `path`.
    fn branches(&mut self, group: &Group, path: &Path) {
        let mut tokens = group.stream().into_iter().peekable();
        while let Some(token) = tokens.peek() {
            let mut branch = Path { line: token.span().start().line, is_use: true, ..path.clone() };
            if let Some(name) = next_ident(&mut tokens) {
                // `use {crate::a, b}`: each branch has a root of its own.
                let is_first = path.is_relative && path.segments == path.module;
                match self.root(&name, &path.module).filter(|_| is_first) {
                    Some(root) => (branch.segments, branch.is_relative) = (root, false),
                    None => step(&mut branch.segments, &name),
                }
            }
            self.follow(&mut tokens, branch);
            while tokens.next().is_some_and(|token| token.to_string() != ",") {}
        }
    }
}

/// Name that the `use` of `path` declares; `tokens` are behind the path.
fn binds(tokens: &mut Tokens, path: &[String]) -> Binds {
    if tokens.peek().is_some_and(|token| token.to_string() == "*") {
        return Binds::All;
    }
    let is_renamed = tokens.next_if(|token| token.to_string() == "as").is_some();
    let name = if is_renamed { next_ident(tokens) } else { path.last().cloned() };
    name.map_or(Binds::Nothing, Binds::Name)
}

/// Value of `[path = ".."]`.
fn path_attribute(group: &Group) -> Option<String> {
    let mut tokens = group.stream().into_iter();
    let is_path = group.delimiter() == Delimiter::Bracket && tokens.next()?.to_string() == "path";
    let is_value =
        is_path && matches!(tokens.next()?, TokenTree::Punct(punct) if punct.spacing() == Spacing::Alone);
    is_value.then(|| tokens.next().map(|literal| literal.to_string().trim_matches('"').to_owned()))?
}

/// Returns whether it is `[cfg(test)]`.
fn is_cfg_test(group: &Group) -> bool {
    group.delimiter() == Delimiter::Bracket && group.stream().to_string().replace(' ', "") == "cfg(test)"
}

/// One segment further.
fn step(path: &mut Vec<String>, segment: &str) {
    match segment {
        "self" => {}
        "super" => *path = parent(path),
        name => path.push(name.to_owned()),
    }
}

fn parent(path: &[String]) -> Vec<String> {
    path.split_last().map_or(Vec::new(), |(_, parent)| parent.to_vec())
}

fn next_ident(tokens: &mut Tokens) -> Option<String> {
    tokens.next_if(|token| matches!(token, TokenTree::Ident(_))).map(|ident| ident.to_string())
}

/// Returns whether a `::` was next.
fn skip_colons(tokens: &mut Tokens) -> bool {
    let mut is_colon = || tokens.next_if(|token| token.to_string() == ":").is_some();
    is_colon() && is_colon()
}
