// Included by build scripts: puts the linker's memory map of the chosen board where the linker looks for it.

/// Board feature as cargo passes it, or how it begins; memory map.
const MAPS: [(&str, &str); 2] =
    [("CARGO_FEATURE_PYBOARD_V11", "stm32f405rg.x"), ("CARGO_FEATURE_NUCLEO_F446RE", "stm32f446re.x")];

/// Copies it from `folder`. Returns whether the image is for a board.
fn place_map(folder: &str) -> bool {
    println!("cargo:rerun-if-changed={folder}");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return false;
    }
    let is_chosen = |feature: &str| std::env::vars_os().any(|(name, _)| name.to_string_lossy().starts_with(feature));
    let Some((_, map)) = MAPS.iter().find(|(feature, _)| is_chosen(feature)) else { return false };
    let out = std::path::PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    std::fs::copy(std::path::Path::new(folder).join(map), out.join("memory.x")).expect("OUT_DIR is writable");
    println!("cargo:rustc-link-search={}", out.display());
    true
}
