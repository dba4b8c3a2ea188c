//! Linker scripts of a bare-metal image: vector table and sections, log symbols.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        // Merges equal functions: no code compares their addresses.
        for argument in ["--nmagic", "--icf=all", "-Tlink.x", "-Tdefmt.x"] {
            println!("cargo:rustc-link-arg-bins={argument}");
        }
    }
}
