//! Declarations that need another crate, and what the compiler says: `tests/refused/*.rs`, each with its `.stderr`.
//!
//! `ecss-can` has the other declarations that do not compile: `shared/tests/refused`.
//! `TRYBUILD=overwrite cargo test -p async-canopen --test refused` writes the texts anew.

#[test]
fn a_device_without_its_crate_is_refused_with_a_reason() {
    let cases = trybuild::TestCases::new();
    cases.compile_fail("tests/refused/*.rs");
}
