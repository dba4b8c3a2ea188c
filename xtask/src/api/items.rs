//! The public items of a crate, by the module in which they are counted.

use std::collections::BTreeMap;

use rustdoc_types::{Crate, Id, Item, ItemEnum, StructKind, VariantKind};

/// Module that re-exports names of other modules.
const PRELUDE: &str = "prelude";

/// A public module.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Module {
    /// Path without the name of the crate; empty for its root.
    pub path: String,
    /// First sentence of its documentation.
    pub purpose: String,
    /// Names of types, traits and macros.
    pub types: Vec<String>,
    /// Names of functions and constants.
    pub functions: Vec<String>,
    /// Number of items: those named above, with their fields, variants, methods, and associated types and constants.
    pub items: usize,
}

impl Module {
    /// Returns whether it has parts for nodes of another kind and for tests.
    pub fn is_extension(&self) -> bool {
        self.path.split("::").any(|name| matches!(name, "extend" | "machine"))
    }
}

/// Returns the public modules of a crate in alphabetic order, its root first. Each item is counted in one of them.
pub fn modules(krate: &Crate) -> Vec<Module> {
    let mut walk = Walk { krate, modules: Vec::new(), places: BTreeMap::new() };
    if let Some(root) = krate.index.get(&krate.root) {
        walk.module(root, "");
    }
    let Walk { mut modules, places, .. } = walk;
    for (id, places) in places {
        let home = places.iter().find(|(nth, _)| modules[*nth].path != PRELUDE).or(places.first());
        let Some((nth, name)) = home else { continue };
        let module = &mut modules[*nth];
        let item = krate.index.get(&id);
        module.items += 1 + item.map_or(0, |item| members(krate, item));
        match item.map(|item| &item.inner) {
            Some(ItemEnum::Function(_) | ItemEnum::Constant { .. } | ItemEnum::Static(_)) => {
                module.functions.push(name.clone());
            }
            _ => module.types.push(name.clone()),
        }
    }
    for module in &mut modules {
        module.types.sort();
        module.types.dedup();
        module.functions.sort();
    }
    modules.sort_by(|one, other| one.path.cmp(&other.path));
    modules
}

struct Walk<'a> {
    krate: &'a Crate,
    modules: Vec<Module>,
    /// The modules in which each item has a name, in the order in which they are declared.
    places: BTreeMap<Id, Vec<(usize, String)>>,
}

impl<'a> Walk<'a> {
    fn module(&mut self, item: &'a Item, path: &str) {
        let nth = self.modules.len();
        let purpose = first_sentence(item.docs.as_deref().unwrap_or_default());
        self.modules.push(Module { path: path.to_owned(), purpose, ..Module::default() });
        self.contents(item, nth, path);
    }

    fn contents(&mut self, item: &'a Item, nth: usize, path: &str) {
        let ItemEnum::Module(module) = &item.inner else { return };
        let krate = self.krate;
        for item in module.items.iter().filter_map(|id| krate.index.get(id)) {
            match &item.inner {
                ItemEnum::Module(_) => {
                    let name = item.name.as_deref().unwrap_or_default();
                    self.module(item, format!("{path}::{name}").trim_start_matches("::"));
                }
                ItemEnum::Use(reexport) => {
                    let target = reexport.id.and_then(|id| krate.index.get(&id));
                    match (reexport.id, target) {
                        (_, Some(target)) if reexport.is_glob => self.contents(target, nth, path),
                        (Some(id), Some(_)) => self.place(id, nth, &reexport.name),
                        (Some(id), None) if self.is_of_derive(id) && path != PRELUDE => {
                            self.place(id, nth, &reexport.name);
                        }
                        _ => {}
                    }
                }
                _ => self.place(item.id, nth, item.name.as_deref().unwrap_or_default()),
            }
        }
    }

    /// Returns whether an item is of the crate of the derive macros, which users access only by a re-export.
    fn is_of_derive(&self, id: Id) -> bool {
        let summary = self.krate.paths.get(&id);
        let krate = summary.and_then(|summary| self.krate.external_crates.get(&summary.crate_id));
        krate.is_some_and(|krate| krate.name == "async_canopen_derive")
    }

    fn place(&mut self, id: Id, nth: usize, name: &str) {
        self.places.entry(id).or_default().push((nth, name.to_owned()));
    }
}

/// Returns the number of public fields, variants, methods, and associated types and constants of an item.
fn members(krate: &Crate, item: &Item) -> usize {
    let fields = |kind: &StructKind| match kind {
        StructKind::Unit => 0,
        StructKind::Tuple(fields) => fields.iter().flatten().count(),
        StructKind::Plain { fields, .. } => fields.len(),
    };
    match &item.inner {
        ItemEnum::Struct(kind) => fields(&kind.kind) + inherent(krate, &kind.impls),
        ItemEnum::Union(union) => union.fields.len() + inherent(krate, &union.impls),
        ItemEnum::Enum(kind) => {
            let of_variants = kind.variants.iter().filter_map(|id| match &krate.index.get(id)?.inner {
                ItemEnum::Variant(variant) => match &variant.kind {
                    VariantKind::Struct { fields, .. } => Some(fields.len()),
                    VariantKind::Plain | VariantKind::Tuple(_) => Some(0),
                },
                _ => None,
            });
            kind.variants.len() + of_variants.sum::<usize>() + inherent(krate, &kind.impls)
        }
        ItemEnum::Trait(kind) => kind.items.len(),
        _ => 0,
    }
}

/// Returns the number of public items in the inherent ones of these implementations.
fn inherent(krate: &Crate, impls: &[Id]) -> usize {
    let of_each = impls.iter().filter_map(|id| match &krate.index.get(id)?.inner {
        ItemEnum::Impl(block) if block.trait_.is_none() => {
            Some(block.items.iter().filter(|id| krate.index.contains_key(id)).count())
        }
        _ => None,
    });
    of_each.sum()
}

/// Returns the first sentence of a documentation in one line, without links.
fn first_sentence(docs: &str) -> String {
    let paragraph =
        docs.split("\n\n").next().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
    let end = paragraph.find(". ").unwrap_or(paragraph.len());
    let mut sentence = paragraph[..end].trim_end_matches('.').replace('|', "\\|");
    while let Some(start) = sentence.find("](") {
        let Some(length) = sentence[start..].find(')') else { break };
        sentence.replace_range(start + 1..=start + length, "");
    }
    sentence.replace(['[', ']'], "")
}
