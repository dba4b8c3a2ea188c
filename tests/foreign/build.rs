//! Memory map of the chosen board and linker scripts of a bare-metal image: vector table and sections, log symbols. Of both images.

include!("../../boards/memory/map.rs");

fn main() {
    println!("cargo:rerun-if-changed=../build.rs");
    if place_map("../../../boards/memory") {
        for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
            println!("cargo:rustc-link-arg-bins={argument}");
        }
    }
}
