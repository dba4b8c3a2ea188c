//! Declarations that do not compile, and what the compiler says: `tests/refused/*.rs`, each with its `.stderr`.
//!
//! `TRYBUILD=overwrite cargo test -p declarations --test declarations` writes the texts anew.

use std::fs;
use std::path::Path;

/// Copies the data sheets of the cases into the folder of the package that trybuild makes: `eds!` finds them there.
fn copy_data_sheets() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("the target folder");
    let package = target.join("tests/trybuild").join(env!("CARGO_PKG_NAME"));
    fs::create_dir_all(&package).unwrap();
    let sheets = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds");
    for sheet in fs::read_dir(sheets).unwrap() {
        let sheet = sheet.unwrap().path();
        fs::copy(&sheet, package.join(sheet.file_name().unwrap())).unwrap();
    }
}

#[test]
fn wrong_declarations_are_refused_with_a_reason() {
    copy_data_sheets();
    let cases = trybuild::TestCases::new();
    // With one that compiles, the others are built, too: some errors are found when a constructor is used.
    cases.pass("tests/accepted/*.rs");
    cases.compile_fail("tests/refused/*.rs");
}
