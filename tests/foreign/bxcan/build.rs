//! Memory map of the chosen board and linker scripts of a bare-metal image: vector table and sections, log symbols.

use std::path::PathBuf;
use std::{env, fs};

/// Board feature as cargo passes it, memory map.
const MAPS: [(&str, &str); 2] = [
    ("CARGO_FEATURE_PYBOARD_V11", "../../../boards/memory/stm32f405rg.x"),
    ("CARGO_FEATURE_NUCLEO_F446RE", "../../../boards/memory/stm32f446re.x"),
];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../../../boards/memory");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let Some((_, map)) = MAPS.iter().find(|(feature, _)| env::var_os(feature).is_some()) else { return };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy(map, out.join("memory.x")).expect("OUT_DIR is writable");
    println!("cargo:rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
