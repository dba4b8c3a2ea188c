//! Places of the chip's name in a manifest, and manifests that are refused.

use ecss_can_memory::{chip_of_board, chip_of_manifest};

fn refusal(manifest: &str) -> String {
    chip_of_manifest(manifest).unwrap_err().to_string()
}

#[test]
fn chip_is_found_in_each_table_of_dependencies() {
    let manifests = [
        "[dependencies]\nembassy-stm32 = { workspace = true, features = ['time-driver-tim2', 'stm32f407vg'] }",
        "[dependencies.embassy-stm32]\nversion = '=0.6.0'\nfeatures = ['stm32f407vg']",
        "[target.'cfg(target_os = \"none\")'.dependencies]\nembassy-stm32 = { features = ['stm32f407vg'] }",
        "[target.thumbv7em-none-eabihf.dependencies]\nembassy-stm32 = { features = ['stm32f407vg'] }",
        "[dependencies]\nhal = { package = 'embassy-stm32', features = ['stm32f407vg'] }",
    ];
    for manifest in manifests {
        assert_eq!(chip_of_manifest(manifest).unwrap().name(), "stm32f407vg", "{manifest}");
    }
}

/// Given the same chip in two tables, when the manifest is read, then it is one chip.
#[test]
fn chip_that_is_named_twice_is_one_chip() {
    let manifest = "[dependencies]\nembassy-stm32 = { features = ['stm32f407vg'] }\n\
                    [target.'cfg(target_os = \"none\")'.dependencies]\nembassy-stm32 = { features = ['stm32f407vg'] }";
    assert_eq!(chip_of_manifest(manifest).unwrap().name(), "stm32f407vg");
}

#[test]
fn manifest_without_chip_is_refused_with_what_to_write() {
    let manifests = [
        "",
        "[dependencies]\nembassy-stm32 = '0.6'",
        "[dependencies]\nembassy-stm32 = { features = ['stm32-hrtim', 'rt'] }",
        "[dependencies]\nother = { features = ['stm32f407vg'] }",
        "[dependencies]\nembassy-stm32 = { package = 'other', features = ['stm32f407vg'] }",
        "[dev-dependencies]\nembassy-stm32 = { features = ['stm32f407vg'] }",
        "[build-dependencies]\nembassy-stm32 = { features = ['stm32f407vg'] }",
    ];
    for manifest in manifests {
        assert_eq!(
            refusal(manifest),
            "Cargo.toml: embassy-stm32 has no feature that names a chip: add the chip of the board to its features, as in \
             `features = [\"stm32f405rg\"]`",
            "{manifest}"
        );
    }
}

#[test]
fn manifest_with_several_chips_is_refused_with_all_of_them() {
    let manifest = "[dependencies]\nembassy-stm32 = { features = ['stm32f446re', 'rt'] }\n\
                    [target.'cfg(target_os = \"none\")'.dependencies]\nembassy-stm32 = { features = ['stm32f405rg'] }";
    assert_eq!(
        refusal(manifest),
        "Cargo.toml: embassy-stm32 has features of several chips, stm32f405rg and stm32f446re: keep the chip of the board, \
         as in `features = [\"stm32f405rg\"]`"
    );
}

#[test]
fn chip_that_is_not_supported_is_refused_with_its_name() {
    let error = refusal("[dependencies]\nembassy-stm32 = { features = ['stm32h743zi'] }");
    assert!(error.starts_with("stm32h743zi is not supported: it is no STM32F4"), "{error}");
}

#[test]
fn text_that_is_no_toml_is_refused_with_file_and_line() {
    let error = refusal("[dependencies\n");
    assert!(error.starts_with("Cargo.toml: ") && error.contains("line 1"), "{error}");
    let error = chip_of_board("chip = \n").unwrap_err().to_string();
    assert!(error.starts_with("board.toml: ") && error.contains("line 1"), "{error}");
}

#[test]
fn description_without_chip_is_refused() {
    for description in ["name = 'mine'", "chip = 405"] {
        assert_eq!(
            chip_of_board(description).unwrap_err().to_string(),
            "board.toml: no chip: add the chip of the board, as in `chip = \"STM32F405RG\"`"
        );
    }
    assert_eq!(chip_of_board("chip = 'STM32F446RETx'").unwrap(), "STM32F446RETx");
}
