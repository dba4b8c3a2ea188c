//! The templates of `ecss-can new`, each from an empty folder to a flight.

use std::fs;

use second::page::{self, Folder, Step};

/// Kinds of projects, and names that no page uses: their builds stay in one target directory.
const PROJECTS: [(&str, &str); 3] = [("slave", "heater-2"), ("master", "ground-2"), ("board", "board-2")];

/// Given an empty folder, when a project is made from a template, then its tests pass and its mission is flown at once.
#[test]
fn each_template_is_tested_and_flown_at_once() {
    let top = page::fresh_folder("ecss-can-new").unwrap_or_else(|failure| panic!("{failure:#}"));
    for (kind, name) in PROJECTS {
        let mut folder = Folder::new(&top).unwrap_or_else(|failure| panic!("{failure:#}"));
        let commands = [
            format!("ecss-can new {kind} {name}\ncd {name}"),
            "cargo test --quiet".to_owned(),
            "ecss-can fly --out flight".to_owned(),
        ];
        for command in commands {
            folder.follow(&Step::Run(command)).unwrap_or_else(|failure| panic!("{kind}: {failure:#}"));
        }
        assert!(top.join(name).join("flight/report.html").is_file(), "{kind}");
    }
    fs::remove_dir_all(&*top).expect("the folder goes");
}
