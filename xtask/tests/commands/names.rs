//! Names of tests are short enough for a line of a report.

use std::fs;
use std::path::{Path, PathBuf};

use crate::docs::root;

/// Longest name of a test.
const LONGEST_NAME: usize = 60;

/// Returns the names of functions with the attribute `test` that are too long.
fn long_names(source: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut is_test = false;
    for line in source.lines().map(str::trim) {
        if line == "#[test]" {
            is_test = true;
        } else if let Some(rest) = line.strip_prefix("fn ")
            && std::mem::take(&mut is_test)
        {
            let name = rest.split('(').next().unwrap_or_default();
            if name.len() > LONGEST_NAME {
                found.push(name.to_owned());
            }
        }
    }
    found
}

/// Returns the Rust sources below `folder`, without build results and hidden folders.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

#[test]
fn names_of_tests_are_short() {
    let text = |source| fs::read_to_string(source).expect("a text");
    let found: Vec<_> = sources(&root()).iter().flat_map(|source| long_names(&text(source))).collect();
    assert!(found.is_empty(), "{} names to shorten:\n{}", found.len(), found.join("\n"));
}

#[test]
fn a_long_name_of_a_test_is_found() {
    let long = "a".repeat(61);
    let source = |attribute: &str, name: &str| format!("{attribute}\nfn {name}() {{}}\n");
    assert_eq!(long_names(&source("#[test]", &long)), std::slice::from_ref(&long));
    assert_eq!(long_names(&source("#[test]\n#[should_panic]", &long)), std::slice::from_ref(&long));
    assert_eq!(long_names(&source("#[test]", &long[1..])), [""; 0]);
    assert_eq!(long_names(&source("#[inline]", &long)), [""; 0]);
}
