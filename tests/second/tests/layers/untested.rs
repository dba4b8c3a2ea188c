//! Targets that are not built for tests (`test = false`, `doctest = false`) have no tests.

use cargo_metadata::{Target, TargetKind};
use second::tools::files;

use crate::rooms::metadata;

fn has_test(source: &str) -> bool {
    source.lines().any(|line| line.trim_start() == "#[test]")
}

/// Returns whether the documentation has a block of code that is compiled.
fn has_example(source: &str) -> bool {
    let mut is_inside = false;
    source
        .lines()
        .filter_map(|line| line.trim_start().get(3..).filter(|_| line.trim_start().starts_with("//")))
        .any(|text| {
            let Some(language) = text.trim_start().strip_prefix("```") else { return false };
            is_inside = !is_inside;
            is_inside && matches!(language, "" | "rust" | "no_run" | "should_panic" | "compile_fail")
        })
}

/// Returns the tests of a target that are not run.
fn forgotten(target: &Target) -> Vec<&'static str> {
    let folder = target.src_path.parent().unwrap().as_std_path();
    let is_of_package = target.is_kind(TargetKind::Lib) || target.is_kind(TargetKind::Bin);
    if !is_of_package || (target.test && target.doctest) {
        return Vec::new();
    }
    let sources = files(folder, "rs");
    let tests = (!target.test && sources.iter().any(|(_, source)| has_test(source))).then_some("a test");
    let is_silent = target.is_kind(TargetKind::Lib) && !target.doctest;
    let examples =
        (is_silent && sources.iter().any(|(_, source)| has_example(source))).then_some("an example");
    tests.into_iter().chain(examples).collect()
}

#[test]
fn no_test_is_forgotten() {
    let workspace = metadata(&crate::workspace());
    let forgotten: Vec<String> = workspace
        .packages
        .iter()
        .flat_map(|package| package.targets.iter().map(move |target| (package, target)))
        // A program beside a library shares its folder: the library's tests are the library's.
        .filter(|(package, target)| {
            target.is_kind(TargetKind::Lib)
                || !package.targets.iter().any(|other| other.is_kind(TargetKind::Lib))
        })
        .flat_map(|(package, target)| {
            forgotten(target).into_iter().map(move |what| format!("{}: {what}", package.name))
        })
        .collect();
    assert!(forgotten.is_empty(), "not run, because the manifest says so: {forgotten:?}");
}

#[test]
fn tests_and_examples_are_seen() {
    assert!(has_test("    #[test]\n    fn f() {}") && !has_test("#[tested]"));
    assert!(has_example("/// Text:\n/// ```\n/// f();\n/// ```"));
    assert!(!has_example("//! ```text\n//! a\n//! ```"));
}
