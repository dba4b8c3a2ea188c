//! Limits of the length of examples.

use crate::docs::text;

/// Largest number of lines of an example, including comments.
const MOST: usize = 99;

fn lines(path: &str) -> usize {
    text(path).lines().count()
}

#[test]
fn examples_of_the_protocol_are_below_a_hundred_lines() {
    for name in ["slave", "master", "two_nodes"] {
        let path = format!("shared/examples/{name}.rs");
        assert!(lines(&path) <= MOST, "{path}: {} lines", lines(&path));
    }
}

/// Start and main; objects, formulas and application are in the library.
#[test]
fn example_images_are_below_a_hundred_lines() {
    for package in ["thermometer", "thermometer-master"] {
        let files = ["app.rs", "main.rs"].map(|file| format!("firmware/examples/{package}/src/{file}"));
        let count: usize = files.iter().map(|path| lines(path)).sum();
        assert!(count <= MOST, "{package}: {count} lines");
    }
}
