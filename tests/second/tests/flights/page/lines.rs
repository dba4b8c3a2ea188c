//! Lines of the board and of the slave of the page.

use std::fs;
use std::path::Path;

/// Largest number of source lines of a board, as stated on the page.
const MOST: usize = 70;

/// Prints the lines of the board and of the slave.
pub fn report(top: &Path) {
    let count = |files: &[&str]| -> usize { files.iter().map(|file| lines(&top.join(file))).sum() };
    let board = count(&["h405/src/lib.rs"]);
    let rest = count(&["h405/Cargo.toml", "h405/build.rs", "h405/board.toml"]);
    let slave = count(&["heater/src/lib.rs", "heater/src/main.rs", "heater/src/app.rs"]);
    println!(
        "board h405: {board} lines in src, {rest} in its other files; slave heater: {slave} lines in src"
    );
    assert!(board <= MOST, "the board has {board} lines");
}

/// Lines that are neither blank nor comments of Rust: the other files of the page have no comments.
fn lines(path: &Path) -> usize {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let is_code = |line: &&str| !line.is_empty() && !line.starts_with("//");
    text.lines().map(str::trim).filter(is_code).count()
}
