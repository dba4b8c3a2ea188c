//! Memory map of the chip of the chosen board, and linker scripts of a bare-metal image: vector table and sections, log symbols.
//! Of both images.

use std::path::PathBuf;
use std::{env, fs};

use ecss_can_memory::Chip;

/// Board feature as cargo passes it, or how it begins; chip.
const CHIPS: [(&str, &str); 2] =
    [("CARGO_FEATURE_PYBOARD_V11", "stm32f405rg"), ("CARGO_FEATURE_NUCLEO_F446RE", "stm32f446re")];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let is_chosen =
        |feature: &str| env::vars_os().any(|(name, _)| name.to_string_lossy().starts_with(feature));
    let chip = CHIPS.iter().find(|(feature, _)| is_chosen(feature));
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let Some((_, chip)) = chip else { return };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let map = Chip::named(chip).expect("it is supported").memory_map();
    fs::write(out.join("memory.x"), map).expect("OUT_DIR is writable");
    println!("cargo:rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
