//! Declarations that do not compile, and what the compiler says: `tests/refused/*.rs`, each with its `.stderr`.
//!
//! `TRYBUILD=overwrite cargo test -p declarations --test declarations` writes the texts anew.

#[test]
fn wrong_declarations_are_refused_with_a_reason() {
    let cases = trybuild::TestCases::new();
    // With one that compiles, the others are built, too: some errors are found when a constructor is used.
    cases.pass("tests/accepted/*.rs");
    cases.compile_fail("tests/refused/*.rs");
}
