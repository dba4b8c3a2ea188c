//! Puts the linker's memory map of the chosen board where the linker looks for it, and links the examples.

include!("memory/map.rs");

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if place_map("memory") {
        // Equal functions are there once: nothing compares their addresses.
        for argument in ["--nmagic", "--icf=all", "-Tlink.x", "-Tdefmt.x"] {
            println!("cargo:rustc-link-arg-examples={argument}");
        }
    }
}
