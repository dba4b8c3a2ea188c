use std::process::Command;

use super::*;

/// A crate with one item of each kind, and the number that each public one counts as.
const SOURCE: &str = "
//! A crate.
pub mod machine {
    mod private {
        pub struct Wheel { pub teeth: u8, oil: u8 } // 2
        impl Wheel {
            pub const LEAST: u8 = 3; // 1
            pub fn turn(&self) -> u8 { self.hidden() } // 1
            fn hidden(&self) -> u8 { self.oil }
        }
        impl Clone for Wheel { fn clone(&self) -> Wheel { Wheel { teeth: 0, oil: 0 } } }
        pub struct Unseen;
    }
    pub use private::Wheel;
    pub enum State { Idle, Busy(u8), Broken { since: u8 } } // 5
    pub trait Part { type Unit; fn weight(&self) -> u8; } // 3
    pub struct Pair(pub u8, u8); // 2
    pub fn start() {} // 1
    pub const MOST: u8 = 4; // 1
}
pub mod prelude { pub use crate::machine::Wheel; }
pub mod extend { pub struct Tool; }
";

fn described(source: &str) -> Vec<items::Module> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("described.rs");
    fs::write(&file, source).expect("a file");
    let mut rustdoc = Command::new("rustdoc");
    ecss_can_cli::images::clean(&mut rustdoc).env("RUSTC_BOOTSTRAP", "1").current_dir(project::path(""));
    rustdoc.args(["-Z", "unstable-options", "--output-format", "json", "--edition", "2024"]);
    rustdoc.args(["--allow", "rustdoc::broken-intra-doc-links"]);
    let status = rustdoc.arg("--out-dir").arg(folder.path()).arg(&file).status().expect("rustdoc runs");
    assert!(status.success());
    let json = fs::read_to_string(folder.path().join("described.json")).expect("its output");
    modules(&serde_json::from_str(&json).expect("the pinned format"))
}

/// Given an item of each kind, a re-export and a private module, then each public name counts once and has its module.
#[test]
fn items_count_once_in_their_module() {
    let modules = described(SOURCE);
    let counts: Vec<_> = modules.iter().map(|module| (module.path.as_str(), module.items)).collect();
    assert_eq!(counts, [("", 0), ("extend", 1), ("machine", 16), ("prelude", 0)]);
    assert_eq!(modules[2].types, ["Pair", "Part", "State", "Wheel"]);
    assert_eq!(modules[2].functions, ["MOST", "start"]);
    assert_eq!(
        modules.iter().map(|module| module.is_extension()).collect::<Vec<_>>(),
        [false, true, true, false]
    );
}

#[test]
fn purpose_of_a_module_is_its_first_sentence_without_links() {
    assert_eq!(
        described("pub mod a {\n//! Turns a [`Wheel`](b) and\n//! [c](d). More.\n}")[1].purpose,
        "Turns a `Wheel` and c"
    );
}

#[test]
fn first_difference_is_the_pair_of_lines_that_differ() {
    assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
    assert_eq!(first_difference("a\nb\nd\n", "a\nc\nd\n"), Some(("b", "c")));
    assert_eq!(first_difference("", "a\n"), Some(("", "a")));
    assert_eq!(first_difference("a\nb", "a"), Some(("b", "")));
}
