//! The modules of the protocol crates are layers: each names only those below it.
//!
//! `ecss-can` exports the modules of `async-canopen`, so both have one order. There a module has the same place under either
//! name of its crate.

use std::path::Path;

use second::tools::files;

use crate::paths::Source;
use crate::workspace;

/// Folders and names of the crates.
const CRATES: [(&str, &str); 2] = [("shared/canopen/src", "async_canopen"), ("shared/src", "ecss_can")];

/// Layers, from the lowest one up.
const LAYERS: [&str; 18] = [
    "types",
    "link",
    "od",
    "time",
    "nmt",
    "heartbeat",
    "sync",
    "emcy",
    "sdo",
    "pdo",
    "redundancy",
    "store",
    "boot",
    "profile",
    "node",
    "runner",
    "prelude",
    "mock",
];

/// Files of both crates, by their names below `src`.
pub fn sources() -> Vec<Source> {
    CRATES.iter().flat_map(|(folder, _)| sources_of(folder)).collect()
}

/// Files of the crate in `src`.
fn sources_of(src: &str) -> Vec<Source> {
    let root = workspace().join(src);
    let name = |path: &Path| path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
    files(&root, "rs").iter().map(|(path, text)| source(&name(path), text)).collect()
}

/// `name`: below `src`, with slashes.
pub fn source(name: &str, text: &str) -> Source {
    let mut module: Vec<String> = name.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if module.last().is_some_and(|last| last == "mod" || last == "lib") {
        module.pop();
    }
    Source::new(name, module, text)
}

/// Paths of `source` from the root of either crate.
fn paths(source: &Source) -> impl Iterator<Item = crate::paths::Path> {
    let all = CRATES.iter().flat_map(|(_, name)| source.read(Some(name)).paths);
    all.filter(|path| !path.is_relative)
}

/// Paths of `source` that break the rules, each with file and line. The root of the crate may name all.
fn offences(source: &Source) -> Vec<String> {
    let Some(own) = source.module.first() else { return Vec::new() };
    let layer = |name: &String| LAYERS.iter().position(|layer| layer == name);
    let Some(height) = layer(own) else { return vec![format!("{}:1: {own} has no layer", source.name)] };
    let mut found = Vec::new();
    for path in paths(source) {
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
    found.sort();
    found.dedup();
    found
}

#[test]
fn modules_name_only_modules_below_them() {
    let sources = sources();
    assert!(sources.len() > 100, "the sources are not where they are expected");
    let offences: Vec<String> = sources.iter().flat_map(offences).collect();
    assert!(offences.is_empty(), "{}", offences.join("\n"));
}

/// Modules in `docs/layers.svg`, with the height of their text from the top.
fn drawn(picture: &str) -> Vec<(u32, usize)> {
    let module = |line: &str| {
        let text = line.strip_prefix("<text ")?;
        let name = text.split_once('>')?.1.split(['<', ':']).next()?;
        let (_, height) = text.split_once(" y=\"")?;
        Some((height.split('"').next()?.parse().ok()?, LAYERS.iter().position(|layer| *layer == name)?))
    };
    picture.lines().filter_map(module).collect()
}

/// Given two modules of the picture, when one stands above the other, then it is above it in the code; in one row, neither names the other.
#[test]
fn picture_shows_the_layers_in_their_order() {
    let picture = std::fs::read_to_string(workspace().join("docs/layers.svg")).unwrap();
    let drawn = drawn(&picture);
    assert_eq!(drawn.len(), LAYERS.len() - ["prelude", "mock"].len());
    for (height, layer) in &drawn {
        for (other_height, other) in &drawn {
            assert!(height >= other_height || layer > other, "{} and {}", LAYERS[*layer], LAYERS[*other]);
        }
    }
    let row = |name: &str| drawn.iter().find(|(_, layer)| LAYERS[*layer] == name).map(|(height, _)| *height);
    for source in sources() {
        let Some(own) = source.module.first() else { continue };
        for target in paths(&source).filter_map(|path| path.segments.into_iter().next()) {
            let is_beside = target != *own && row(own).is_some() && row(own) == row(&target);
            assert!(!is_beside, "{own} names {target}, which is beside it");
        }
    }
}

/// Given a file in the middle of the layers, when it names a module above it in any form that Rust has, then that is found.
#[test]
fn every_form_of_an_upward_arrow_is_found() {
    let forms = [
        "use crate::node::Slave;",
        "use crate::{link::Stamp, node::Slave};",
        "use crate::{od::{Run, Place}, node::{self, Slave as Unit}};",
        "use crate::node as above;",
        "pub(crate) use crate::node::Slave;",
        "use super::super::node::Slave;",
        "use super::super::{node::Slave};",
        "use self::super::super::node::Slave;",
        "use ecss_can::node::Slave;",
        "use ::ecss_can::node::Slave;",
        "use async_canopen::node::Slave;",
        "use ecss_can::{od::Run, node::Slave};",
        "fn f() { crate::node::Slave::builder().build() }",
        "fn f() { ::ecss_can::node::slave() }",
        "fn f(slave: &super::super::node::Slave) {}",
        "struct S<T: crate::node::Node>(T);",
        "impl crate::node::Node for S {}",
        "fn f() { assert!(crate::node::is_up(), \"down\") }",
        "macro_rules! m { () => { $crate::node::Slave } }",
        "#[object(0x2000, default = crate::node::DEFAULT)] struct S;",
        "mod inner { use super::super::super::node::Slave; }",
    ];
    for form in forms {
        let found = offences(&source("pdo/mapping.rs", form));
        assert_eq!(found, ["pdo/mapping.rs:1: pdo names node, which is above it"], "{form}");
    }
}

/// Given names that hide the module they come from, when a file uses them, then they are refused.
#[test]
fn names_without_a_module_are_refused() {
    let forms = [
        ("use crate::Slave;", "Slave is no module"),
        ("use crate::*;", "the root of the crate is no module"),
        ("use super::super::*;", "the root of the crate is no module"),
        ("use crate as all;", "the root of the crate is no module"),
        ("use ecss_can as all;", "the root of the crate is no module"),
        ("use crate::{self as all};", "the root of the crate is no module"),
        ("use crate::prelude::*;", "pdo names prelude, which is above it"),
        ("pub use crate::types::Frame;", "a name of types is exported once more"),
        ("pub use crate::{od::Run};", "a name of od is exported once more"),
    ];
    for (form, reason) in forms {
        let found = offences(&source("pdo/mapping.rs", form));
        assert_eq!(found, [format!("pdo/mapping.rs:1: {reason}")], "{form}");
    }
}

/// Each module that users name in `ecss-can` is in one of the two crates, except a module with parts in both.
#[test]
fn each_module_is_in_one_crate() {
    let modules = |src| {
        let names = sources_of(src).into_iter().filter_map(|source| source.module.first().cloned());
        names.collect::<std::collections::BTreeSet<_>>()
    };
    let [canopen, ecss] = CRATES.map(|(src, _)| modules(src));
    assert_eq!(
        canopen.intersection(&ecss).collect::<Vec<_>>(),
        ["emcy", "mock", "node", "prelude", "runner", "store", "types"]
    );
    let all: Vec<&String> =
        LAYERS.iter().flat_map(|layer| canopen.union(&ecss).find(|name| name == layer)).collect();
    assert_eq!(all.len(), LAYERS.len());
}

/// Given two modules that name each other, when both are read, then one of the two arrows is an offence.
#[test]
fn a_circle_or_a_module_without_a_layer_is_refused() {
    for (name, text, expected) in [
        ("sdo/mod.rs", "use crate::pdo::Layout;", Some("sdo/mod.rs:1: sdo names pdo, which is above it")),
        ("pdo/mod.rs", "use crate::sdo::Client;", None),
        ("attic.rs", "", Some("attic.rs:1: attic has no layer")),
    ] {
        assert_eq!(offences(&source(name, text)), Vec::from_iter(expected));
    }
}

#[test]
fn arrows_down_comments_and_strings_are_no_offences() {
    let text = r#"
        //! Not an arrow: crate::node::Slave.
        use super::Layout;
        use self::inner::X;
        use crate::{od::Run, types::{self, Frame}};
        pub use rules::Rules;
        pub(super) use super::mapping::Layout;
        /// [`Slave`](crate::node::Slave)
        fn f() { crate::link::queue::depth(); println!("crate::node::Slave") }
        mod inner { use super::super::receive::X; use crate::types::Bus; }
    "#;
    assert_eq!(offences(&source("pdo/transmit.rs", text)), [""; 0]);
}
