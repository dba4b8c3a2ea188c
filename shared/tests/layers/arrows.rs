//! Paths of a source file that lead into another module of the crate.
//!
//! Reads tokens, not items: a path in a macro or in an attribute is a path like any other.

use std::iter::Peekable;

use proc_macro2::token_stream::IntoIter;
use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

type Tokens = Peekable<IntoIter>;

/// A file of the crate.
pub struct Source {
    pub name: String,
    /// Module that the file is, from the root of the crate.
    module: Vec<String>,
    pub tokens: TokenStream,
}

impl Source {
    /// `name`: below `src`, with slashes.
    pub fn new(name: &str, text: &str) -> Source {
        let mut module: Vec<String> = name.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
        if module.last().is_some_and(|last| last == "mod" || last == "lib") {
            module.pop();
        }
        let tokens = text.parse().unwrap_or_else(|error| panic!("{name}: {error}"));
        Source { name: name.to_owned(), module, tokens }
    }
}

/// Paths of `source` that break the rules, each with file and line. The root of the crate may name all.
pub fn offences(source: &Source, layers: &[&str]) -> Vec<String> {
    let Some(own) = source.module.first() else { return Vec::new() };
    let layer = |name: &String| layers.iter().position(|layer| layer == name);
    let Some(height) = layer(own) else { return vec![format!("{}:1: {own} has no layer", source.name)] };
    let mut reader = Reader { paths: Vec::new() };
    reader.read(source.tokens.clone(), &source.module);
    let mut found = Vec::new();
    for path in reader.paths {
        let reason = match path.segments.first() {
            None => "the root of the crate is no module".to_owned(),
            Some(target) => match layer(target) {
                None => format!("{target} is no module"),
                Some(other) if other > height => format!("{own} names {target}, which is above it"),
                Some(other) if other < height && path.is_exported && own != "prelude" => {
                    format!("a name of {target} is exported once more")
                }
                Some(_) => continue,
            },
        };
        found.push(format!("{}:{}: {reason}", source.name, path.line));
    }
    found.dedup();
    found
}

/// A path from the root of the crate.
struct Path {
    line: usize,
    /// Empty: the root itself, or all that it has.
    segments: Vec<String>,
    /// Part of a `pub use`, whatever its visibility.
    is_exported: bool,
}

/// Where a path stands.
#[derive(Clone, Copy)]
struct Context {
    line: usize,
    is_use: bool,
    is_exported: bool,
}

struct Reader {
    paths: Vec<Path>,
}

impl Reader {
    /// Reads tokens that stand in `module`.
    fn read(&mut self, tokens: TokenStream, module: &[String]) {
        let mut tokens = tokens.into_iter().peekable();
        let mut context = Context { line: 0, is_use: false, is_exported: false };
        let (mut is_public, mut inner) = (false, None);
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Group(group) => {
                    let mut nested = module.to_vec();
                    if group.delimiter() == Delimiter::Brace {
                        nested.extend(inner.take());
                    }
                    self.read(group.stream(), &nested);
                    // `pub(crate) use` is public here, too.
                    is_public &= group.delimiter() == Delimiter::Parenthesis;
                }
                TokenTree::Ident(ident) => {
                    let name = ident.to_string();
                    context.line = ident.span().start().line;
                    match name.as_str() {
                        "use" => (context.is_use, context.is_exported) = (true, is_public),
                        "mod" => inner = tokens.peek().map(TokenTree::to_string),
                        "crate" | "ecss_can" => self.follow(&mut tokens, Vec::new(), context),
                        "self" => self.follow(&mut tokens, module.to_vec(), context),
                        "super" => self.follow(&mut tokens, parent(module), context),
                        _ => {}
                    }
                    is_public = name == "pub";
                }
                TokenTree::Punct(punct) if punct.as_char() == ';' => {
                    (context.is_use, context.is_exported, inner) = (false, false, None);
                }
                _ => {}
            }
        }
    }

    /// Reads on behind the root of a path, which is `path` so far.
    fn follow(&mut self, tokens: &mut Tokens, mut path: Vec<String>, context: Context) {
        let mut is_path = context.is_use;
        while skip_colons(tokens) {
            is_path = true;
            match tokens.peek() {
                Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                    let group = group.clone();
                    tokens.next();
                    return self.branches(&group, &path, context);
                }
                Some(TokenTree::Ident(ident)) => {
                    step(&mut path, &ident.to_string());
                    tokens.next();
                }
                // `*`, or the generic arguments of a path.
                _ => break,
            }
        }
        if is_path {
            self.paths.push(Path { line: context.line, segments: path, is_exported: context.is_exported });
        }
    }

    /// Reads the branches of a `use` tree behind `path`.
    fn branches(&mut self, group: &Group, path: &[String], context: Context) {
        let mut tokens = group.stream().into_iter().peekable();
        while let Some(token) = tokens.next() {
            let line = token.span().start().line;
            let mut branch = path.to_vec();
            if let TokenTree::Ident(ident) = &token {
                step(&mut branch, &ident.to_string());
            }
            self.follow(&mut tokens, branch, Context { line, is_use: true, ..context });
            // `as` and the other name.
            while tokens.next().is_some_and(|token| token.to_string() != ",") {}
        }
    }
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

/// Whether a `::` was next.
fn skip_colons(tokens: &mut Tokens) -> bool {
    let mut is_colon = || tokens.next_if(|token| token.to_string() == ":").is_some();
    is_colon() && is_colon()
}
