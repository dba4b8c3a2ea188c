//! Linker scripts of a bare-metal image: vector table and sections, log symbols.

/// Merges equal functions and constants: no code compares their addresses. The seal is written after linking.
const MERGE: [&str; 3] = ["--icf=all", "--ignore-data-address-equality", "--keep-unique=__program_seal"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"].iter().chain(&MERGE) {
            println!("cargo:rustc-link-arg-bins={argument}");
        }
    }
}
