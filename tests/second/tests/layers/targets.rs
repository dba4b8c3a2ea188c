//! The modules of a target, and the arrows between them.
//!
//! Unit tests (`#[cfg(test)]`) may name everything, like all tests. So their paths are no arrows.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::circles::Arrow;
use crate::paths::{Binds, Module, Source};

type Name = Vec<String>;

/// A target of a package: its first file and all modules of it.
#[derive(Default)]
pub struct Target {
    modules: BTreeSet<Name>,
    uses: Vec<Use>,
    /// Names that a module declares by `use`.
    aliases: BTreeMap<(Name, String), Name>,
    /// Modules whose names another one declares by `use ..::*`.
    globs: BTreeMap<Name, Vec<Name>>,
}

/// A path of a source file.
struct Use {
    place: String,
    from: Name,
    to: Name,
    is_glob: bool,
}

impl Target {
    /// Reads the target whose first file is `root`. Files are shown from `folder`.
    pub fn read(root: &Path, folder: &Path) -> Target {
        let mut target = Target::default();
        let mut files = vec![(root.to_owned(), Name::new())];
        let mut own_name = None;
        while let Some((file, module)) = files.pop() {
            let text =
                fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            let shown = file.strip_prefix(folder).unwrap_or(&file).display().to_string();
            let source = Source::new(&shown, module, &text);
            if source.module.is_empty() {
                own_name = other_name(&source.tokens.to_string());
            }
            for module in target.add(&source, own_name.as_deref()) {
                files.push((file_of(&module, &source.module, &file), module.path));
            }
        }
        target
    }

    /// Adds a file, and returns modules that have files of their own.
    pub fn add(&mut self, source: &Source, own_name: Option<&str>) -> Vec<Module> {
        let found = source.read(own_name);
        self.modules.extend(found.modules.iter().map(|module| module.path.clone()));
        for path in found.paths.into_iter().filter(|path| !path.is_test) {
            match &path.binds {
                Binds::Name(name) => {
                    self.aliases.insert((path.module.clone(), name.clone()), path.segments.clone());
                }
                Binds::All => self.globs.entry(path.module.clone()).or_default().push(path.segments.clone()),
                Binds::Nothing => {}
            }
            let place = format!("{}:{}", source.name, path.line);
            self.uses.push(Use {
                place,
                from: path.module,
                to: path.segments,
                is_glob: path.binds == Binds::All,
            });
        }
        found.modules.into_iter().filter(|module| module.has_file && !module.is_test).collect()
    }

    pub fn modules(&self) -> usize {
        self.modules.len()
    }

    /// Returns arrows between modules with the same parent.
    pub fn arrows(&self) -> Vec<Arrow> {
        let arrows_of = |path: &Use| {
            let found = self.siblings(&path.from, &path.to, path.is_glob, &mut BTreeSet::new());
            let arrow = |(from, to): (Name, Name)| Arrow {
                from: from.join("::"),
                to: to.join("::"),
                place: path.place.clone(),
            };
            found.into_iter().map(arrow).collect::<Vec<_>>()
        };
        self.uses.iter().flat_map(arrows_of).collect()
    }

    /// Two modules with the same parent, of which the first has `from` in it and names the second by `to`. Several: the
    /// path names all that an ancestor has. `seen`: names that were followed.
    fn siblings(
        &self,
        from: &Name,
        to: &Name,
        is_glob: bool,
        seen: &mut BTreeSet<Name>,
    ) -> Vec<(Name, Name)> {
        let common = from.iter().zip(to).take_while(|(one, other)| one == other).count();
        if common == from.len() {
            return Vec::new();
        }
        let (ancestor, rest) = to.split_at(common);
        let child = to.get(..=common);
        match child {
            Some(child) if self.modules.contains(child) => {
                return vec![(from[..=common].to_vec(), child.to_vec())];
            }
            // An item of the ancestor, under its own name or another one.
            Some(child) if !seen.insert(child.to_vec()) => return Vec::new(),
            None if !is_glob || !seen.insert([ancestor, &["*".to_owned()]].concat()) => return Vec::new(),
            _ => {}
        }
        let alias = |name: &String| self.aliases.get(&(ancestor.to_vec(), name.clone()));
        let mut ahead: Vec<Name> = match rest.split_first() {
            Some((name, rest)) => alias(name).map(|path| [path, rest].concat()).into_iter().collect(),
            None => self
                .aliases
                .iter()
                .filter(|((module, _), _)| module == ancestor)
                .map(|(_, path)| path.clone())
                .collect(),
        };
        if ahead.is_empty() || rest.is_empty() {
            ahead.extend(self.globs.get(ancestor).into_iter().flatten().cloned());
        }
        ahead.iter().flat_map(|path| self.siblings(from, path, true, seen)).collect()
    }
}

/// Returns the own name of a crate.
fn other_name(root: &str) -> Option<String> {
    let name = root.split_once("extern crate self as ")?.1;
    Some(name.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect())
}

/// File of a module; `around`: module that `declaring` is.
fn file_of(module: &Module, around: &Name, declaring: &Path) -> PathBuf {
    if let Some(file) = &module.file {
        return declaring.with_file_name(file);
    }
    let is_folder = around.is_empty() || declaring.ends_with("mod.rs");
    let mut folder = if is_folder { declaring.with_file_name("") } else { declaring.with_extension("") };
    // Modules in braces are folders.
    folder.extend(&module.path[around.len()..]);
    let file = folder.with_extension("rs");
    if file.exists() { file } else { folder.join("mod.rs") }
}
