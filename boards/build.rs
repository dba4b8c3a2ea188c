//! Puts the linker's memory map of the chosen board where the linker looks for it, and links the examples.

use std::path::PathBuf;
use std::{env, fs};

/// Board feature as cargo passes it, memory map.
const MAPS: [(&str, &str); 2] = [
    ("CARGO_FEATURE_PYBOARD_V11", "memory/stm32f405rg.x"),
    ("CARGO_FEATURE_NUCLEO_F446RE", "memory/stm32f446re.x"),
];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let Some((_, map)) = MAPS.iter().find(|(feature, _)| env::var_os(feature).is_some()) else { return };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy(map, out.join("memory.x")).expect("OUT_DIR is writable");
    println!("cargo:rustc-link-search={}", out.display());
    // Equal functions are there once: nothing compares their addresses.
    for argument in ["--nmagic", "--icf=all", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-examples={argument}");
    }
}
