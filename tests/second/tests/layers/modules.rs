//! Modules with the same parent form no circle, in each target of each package.
//!
//! Shared parts of two modules belong in a module below both.

use crate::circles::circles;
use crate::paths::Source;
use crate::rooms::metadata;
use crate::targets::Target;
use crate::workspace;

#[test]
fn modules_with_one_parent_form_no_circle() {
    let root = workspace();
    let (mut found, mut modules) = (Vec::new(), 0);
    for package in metadata(&root).packages {
        for target in &package.targets {
            let read = Target::read(target.src_path.as_std_path(), &root);
            modules += read.modules();
            let circles = circles(&read.arrows()).into_iter();
            found.extend(circles.map(|circle| format!("{}, {}: {circle}", package.name, target.name)));
        }
    }
    assert!(modules > 1_000, "the sources are not where they are expected");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Returns the circles of a target of these files.
fn found(files: &[(&[&str], &str)]) -> Vec<String> {
    let mut target = Target::default();
    for (module, text) in files {
        let name = if module.is_empty() { "lib.rs".to_owned() } else { format!("{}.rs", module.join("/")) };
        target.add(&Source::new(&name, module.iter().map(|name| (*name).to_owned()).collect(), text), None);
    }
    circles(&target.arrows())
}

/// Given a module that names another one, when that one names it in any form that Rust has, then the circle is found.
#[test]
fn every_form_of_a_circle_is_found() {
    let forms = [
        "use crate::a::X;",
        "use super::a::X;",
        "use super::a;",
        "use super::a as other;",
        "use crate::{a::X, c};",
        "use {crate::a::X, std::fmt};",
        "use crate::a::*;",
        "pub use super::a::X;",
        "fn f() { crate::a::x() }",
        "fn f(x: &super::a::X) {}",
        "fn f() { assert!(super::a::x(), \"no\") }",
        "macro_rules! m { () => { $crate::a::X } }",
        "#[attribute(default = crate::a::X)] struct S;",
        "mod inner { use super::super::a::X; }",
        "mod inner { fn f() { crate::a::x() } }",
        // The root has the name, and another module declares it.
        "use crate::X;",
        "use super::Renamed;",
        "use crate::Chain;",
        "fn f(x: crate::X) {}",
        "fn f(x: super::X::<u8>) {}",
        "use crate::all::X;",
        // All names of the root.
        "use crate::*;",
        "use super::*;",
    ];
    let root =
        "mod a; mod b; mod c; pub use a::X; use crate::a::Y as Renamed; pub use c::Chain; pub use a as all;";
    for form in forms {
        let files: [(&[&str], &str); 4] =
            [(&[], root), (&["a"], "use crate::b::Z;"), (&["b"], form), (&["c"], "pub use crate::a::Chain;")];
        let found = found(&files);
        assert_eq!(found.len(), 1, "{form}: {found:?}");
        assert!(found[0].contains("\n  a.rs:1: a names b"), "{form}: {found:?}");
        assert!(found[0].contains("\n  b.rs:1: b names "), "{form}: {found:?}");
    }
}

/// Given a root that has all names of a module, when a name of the root is no item there, then it is one of that module.
#[test]
fn name_that_the_root_has_by_a_glob_is_an_arrow() {
    let root = "mod a; mod b; pub use a::*;";
    let files: [(&[&str], &str); 3] = [(&[], root), (&["a"], "use crate::b::Z;"), (&["b"], "use crate::X;")];
    assert_eq!(found(&files), ["circle of a, b:\n  a.rs:1: a names b\n  b.rs:1: b names a"]);
}

#[test]
fn circle_of_three_is_found_with_its_arrows_alone() {
    let files: [(&[&str], &str); 5] = [
        (&[], "mod a; mod b; mod c; mod d;"),
        (&["a"], "use super::b;\nuse super::d;"),
        (&["b"], "\nuse super::c;"),
        (&["c"], "use super::a;"),
        (&["d"], ""),
    ];
    let lines = ["circle of a, b, c:", "  a.rs:1: a names b", "  b.rs:2: b names c", "  c.rs:1: c names a"];
    assert_eq!(found(&files), [lines.join("\n")]);
}

#[test]
fn circle_within_a_folder_is_found() {
    let files: [(&[&str], &str); 4] = [
        (&[], "mod report;"),
        (&["report"], "mod flags; mod lanes;"),
        (&["report", "flags"], "use super::lanes::Lanes;"),
        (&["report", "lanes"], "use crate::report::flags::Flags;"),
    ];
    let found = found(&files);
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("circle of report::flags, report::lanes:"), "{found:?}");
}

#[test]
fn arrows_one_way_and_unit_tests_form_no_circle() {
    let tests = "
        #[cfg(test)] use super::b::X;
        #[cfg(test)] mod tests { use crate::b::X; mod inner { use crate::b::Y; } }
        #[cfg(test)] mod file;
        #[cfg(test)] fn f() { super::b::x() }
    ";
    let files: [(&[&str], &str); 4] = [
        (&[], "mod a; mod b; pub const ROOT: u8 = 1; use std::fmt; use fmt::fmt; fn f() { a::x(); b::x() }"),
        (&["a"], tests),
        (
            &["b"],
            "use crate::a::{self, X}; use super::ROOT; use super::fmt; mod inner { use super::X; use crate::b; }",
        ),
        (&["b", "inner"], "//! crate::b\nfn f() { println!(\"crate::b\") }"),
    ];
    assert_eq!(found(&files), [""; 0]);
}

/// Given code behind a unit test, when it names a module, then that is an arrow again.
#[test]
fn code_behind_a_unit_test_is_read() {
    let after = "#[cfg(test)] mod tests { use crate::b::X; }\n#[cfg(test)] use std::fmt;\nuse crate::b::X;";
    let files: [(&[&str], &str); 3] = [(&[], "mod a; mod b;"), (&["a"], after), (&["b"], "use super::a;")];
    assert_eq!(found(&files), ["circle of a, b:\n  a.rs:3: a names b\n  b.rs:1: b names a"]);
}

/// Given a target on disk, when its modules are in files of each kind, then all are read.
#[test]
fn files_of_all_modules_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, text).unwrap();
    };
    write(
        "src/lib.rs",
        "extern crate self as own;\nmod a;\nmod b;\nmod inline { mod deep; }\n#[path = \"y.rs\"]\nmod named;",
    );
    write("src/a.rs", "mod child;");
    write("src/a/child.rs", "use own::b::B;");
    write("src/b/mod.rs", "mod child;");
    write("src/b/child.rs", "use crate::inline::deep::D;");
    write("src/inline/deep.rs", "use crate::named::N;");
    write("src/y.rs", "use crate::a::A;");
    let target = Target::read(&folder.path().join("src/lib.rs"), folder.path());
    assert_eq!(target.modules(), 7);
    let expected = [
        "circle of a, b, inline, named:",
        "  src/a/child.rs:1: a names b",
        "  src/b/child.rs:1: b names inline",
        "  src/inline/deep.rs:1: inline names named",
        "  src/y.rs:1: named names a",
    ];
    let mut found: Vec<String> =
        circles(&target.arrows()).iter().flat_map(|circle| circle.lines()).map(str::to_owned).collect();
    found.sort_by_key(|line| (!line.starts_with("circle"), line.clone()));
    assert_eq!(found, expected);
}
