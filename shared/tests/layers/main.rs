//! The modules of the crate are layers: each names only those below it.

mod arrows;

use std::path::Path;

use arrows::{Source, offences};

/// From the ground floor up.
const LAYERS: [&str; 17] = [
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
    "store",
    "redundancy",
    "boot",
    "profile",
    "node",
    "runner",
    "prelude",
];

fn sources() -> Vec<Source> {
    let mut found = Vec::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
                found.push(Source::new(&name, &std::fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found
}

#[test]
fn modules_name_only_modules_below_them() {
    let sources = sources();
    assert!(sources.len() > 100, "the sources are not where they are expected");
    let offences: Vec<String> = sources.iter().flat_map(|source| offences(source, &LAYERS)).collect();
    assert!(offences.is_empty(), "{}", offences.join("\n"));
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
        "use ecss_can::{od::Run, node::Slave};",
        "fn f() { crate::node::Slave::new() }",
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
        let found = offences(&Source::new("pdo/mapping.rs", form), &LAYERS);
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
        let found = offences(&Source::new("pdo/mapping.rs", form), &LAYERS);
        assert_eq!(found, [format!("pdo/mapping.rs:1: {reason}")], "{form}");
    }
}

/// Given two modules that name each other, when both are read, then one of the two arrows is an offence.
#[test]
fn a_circle_is_found() {
    let circle = [("sdo/mod.rs", "use crate::pdo::Layout;"), ("pdo/mod.rs", "use crate::sdo::Client;")];
    let found: Vec<String> =
        circle.iter().flat_map(|(name, text)| offences(&Source::new(name, text), &LAYERS)).collect();
    assert_eq!(found, ["sdo/mod.rs:1: sdo names pdo, which is above it"]);
}

#[test]
fn a_module_without_a_layer_is_refused() {
    let found = offences(&Source::new("attic.rs", ""), &LAYERS);
    assert_eq!(found, ["attic.rs:1: attic has no layer"]);
}

#[test]
fn arrows_down_and_words_in_comments_and_strings_are_no_offences() {
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
    assert_eq!(offences(&Source::new("pdo/transmit.rs", text), &LAYERS), [""; 0]);
}
