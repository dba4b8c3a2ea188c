//! The modules of the crate are layers: each names only those below it. Each object is declared in one of them.

mod arrows;
mod indices;

use std::path::Path;

use arrows::{Source, offences};
use indices::repeated;

/// From the ground floor up.
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
    assert_eq!(offences(&Source::new("pdo/transmit.rs", text), &LAYERS), [""; 0]);
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
        let sources = [Source::new("heartbeat/objects.rs", home), Source::new("node/rules.rs", form)];
        let expected = format!("node/rules.rs:1: {index:04X}h has its home in heartbeat/objects.rs:1");
        assert_eq!(repeated(&sources), [expected], "{form}");
    }
}

#[test]
fn other_numbers_and_words_in_comments_are_no_indices() {
    let home = Source::new("heartbeat/objects.rs", "struct S { #[object(0x1016, rw)] a: u32 }");
    let text = r#"
        //! Object 0x1016.
        /// Nor here: 0x1016.
        const FLAG: u32 = 0x1016_0000;
        const OTHER: [u32; 3] = [0x1017, 0x3016, 4118];
        fn f(object: u8) { println!("0x1016 {object}") }
    "#;
    assert_eq!(repeated(&[home, Source::new("node/rules.rs", text)]), [""; 0]);
    let home = Source::new("node/objects.rs", "struct S { #[object(0x1000, ro)] a: u32 }");
    let codes = Source::new("emcy/code.rs", "enum ErrorCode { Generic = 0x1000 }");
    assert_eq!(repeated(&[home, codes]), [""; 0]);
}
