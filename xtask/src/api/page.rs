//! The page: a table of modules for each crate.

use std::fmt::Write as _;

use super::items::Module;

/// A package, and its modules.
type Package = (&'static str, Vec<Module>);

/// Numbers of items for users and of items for extensions on 30 November 2026, before the first version of this page.
const BEFORE: (usize, usize) = (2_923, 236);

const HEAD: &str = "# Public items

Written by `cargo xtask api`; do not edit. `cargo xtask api --check` fails if the page does not list what is public.

An *item* is a name that a user can write: a type, trait, macro, function or constant, a public field or variant, a method, or an
associated type or constant. Implementations of traits do not count. A re-export does not count: an item counts once, in the
module that documents it. The prelude therefore has no items of its own, and `ecss-can` none of `async-canopen`. All features
are on.

Items of modules named `extend` and `machine` are counted apart. `extend` has parts for crates that build nodes of another kind,
`machine` has the services of a node as plain structs. Such crates and tests use them, an application uses none of them.

";

/// Returns the numbers of items of both kinds in a line.
pub fn summary(packages: &[Package]) -> String {
    let (users, extensions) = totals(packages.iter().flat_map(|(_, modules)| modules));
    format!("{users} public items for users, {extensions} for extensions")
}

/// Returns the complete page.
pub fn write(packages: &[Package]) -> String {
    let (users, extensions) = totals(packages.iter().flat_map(|(_, modules)| modules));
    let mut page = HEAD.to_owned();
    let _ = writeln!(page, "| items | for users | for extensions and tests |\n| --- | ---: | ---: |");
    let _ = writeln!(page, "| 2026-11-30, before this page | {} | {} |", BEFORE.0, BEFORE.1);
    for (package, modules) in packages {
        let (users, extensions) = totals(modules);
        let _ = writeln!(page, "| now, `{package}` | {users} | {extensions} |");
    }
    let _ = writeln!(page, "| now, both | {users} | {extensions} |");
    for (package, modules) in packages {
        let _ = write!(page, "\n## {package}\n");
        let (extensions, users): (Vec<_>, Vec<_>) = modules.iter().partition(|module| module.is_extension());
        table(&mut page, "For users", &users);
        table(&mut page, "For nodes of another kind, and for tests", &extensions);
    }
    page
}

fn table(page: &mut String, title: &str, modules: &[&Module]) {
    if modules.is_empty() {
        return;
    }
    let _ = write!(
        page,
        "\n{title}:\n\n| module | items | purpose | types, traits, macros | functions, constants |\n"
    );
    page.push_str("| --- | ---: | --- | --- | --- |\n");
    for Module { path, purpose, types, functions, items } in
        modules.iter().filter(|module| !module.path.is_empty())
    {
        let (types, functions) = (types.join(", "), functions.join(", "));
        let _ = writeln!(page, "| `{path}` | {items} | {purpose} | {types} | {functions} |");
    }
}

/// Returns the numbers of items for users and of items for extensions.
fn totals<'a>(modules: impl IntoIterator<Item = &'a Module>) -> (usize, usize) {
    modules.into_iter().fold((0, 0), |(users, extensions), module| match module.is_extension() {
        true => (users, extensions + module.items),
        false => (users + module.items, extensions),
    })
}
