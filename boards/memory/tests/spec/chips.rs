//! Supported chips and their memories.

use ecss_can_memory::Chip;

fn refusal(chip: &str) -> String {
    Chip::named(chip).unwrap_err().to_string()
}

/// Given each line with each of its flash sizes, when it is looked up, then memories and DEV_ID are those of its data sheet.
#[test]
fn each_line_and_flash_size_has_the_memories_of_its_data_sheet() {
    // Name, flash, RAM and CCM in KiB, store, DEV_ID.
    let expected = [
        ("stm32f405oe", 512, 128, 64, 0x0804_0000, 0x413),
        ("stm32f405rg", 1024, 128, 64, 0x080C_0000, 0x413),
        ("stm32f407ve", 512, 128, 64, 0x0804_0000, 0x413),
        ("stm32f407ig", 1024, 128, 64, 0x080C_0000, 0x413),
        ("stm32f415rg", 1024, 128, 64, 0x080C_0000, 0x413),
        ("stm32f417ze", 512, 128, 64, 0x0804_0000, 0x413),
        ("stm32f417zg", 1024, 128, 64, 0x080C_0000, 0x413),
        ("stm32f427vg", 1024, 192, 64, 0x080C_0000, 0x419),
        ("stm32f427ai", 2048, 192, 64, 0x081C_0000, 0x419),
        ("stm32f429ne", 512, 192, 64, 0x0804_0000, 0x419),
        ("stm32f429bg", 1024, 192, 64, 0x080C_0000, 0x419),
        ("stm32f429zi", 2048, 192, 64, 0x081C_0000, 0x419),
        ("stm32f437ig", 1024, 192, 64, 0x080C_0000, 0x419),
        ("stm32f437vi", 2048, 192, 64, 0x081C_0000, 0x419),
        ("stm32f439zg", 1024, 192, 64, 0x080C_0000, 0x419),
        ("stm32f439ni", 2048, 192, 64, 0x081C_0000, 0x419),
        ("stm32f446me", 512, 128, 0, 0x0804_0000, 0x421),
        ("stm32f469ae", 512, 320, 64, 0x0804_0000, 0x434),
        ("stm32f469ng", 1024, 320, 64, 0x080C_0000, 0x434),
        ("stm32f469ni", 2048, 320, 64, 0x081C_0000, 0x434),
        ("stm32f479vg", 1024, 320, 64, 0x080C_0000, 0x434),
        ("stm32f479bi", 2048, 320, 64, 0x081C_0000, 0x434),
    ];
    for (name, flash, ram, ccm, store, device_id) in expected {
        let chip = Chip::named(name).unwrap();
        let found = (chip.flash_kib(), chip.ram_kib(), chip.ccm_kib(), chip.store_start(), chip.device_id());
        assert_eq!(found, (flash, ram, ccm, store, device_id), "{name}");
        assert_eq!(chip.name(), name);
    }
}

#[test]
fn name_in_capitals_is_the_same_chip() {
    assert_eq!(Chip::named("STM32F405RG").unwrap(), Chip::named("stm32f405rg").unwrap());
}

#[test]
fn flash_of_256_kib_is_refused_as_too_small_for_the_store() {
    for chip in ["stm32f446rc", "stm32f446vc", "stm32f446zc", "stm32f446mc"] {
        assert_eq!(
            refusal(chip),
            format!(
                "{chip} is not supported: the parameter store needs two sectors of 128 KiB, and flash of 256 KiB has one; \
                 take a chip with 512 KiB, its last letter is e"
            )
        );
    }
}

#[test]
fn lines_without_can_are_refused() {
    for chip in ["stm32f401re", "stm32f410rb", "stm32f411ce"] {
        let error = refusal(chip);
        let expected =
            format!("{chip} is not supported: this line has no CAN controller; supported are STM32F405, ");
        assert!(error.starts_with(&expected), "{error}");
    }
}

#[test]
fn lines_of_100_mhz_are_refused() {
    let speed = "this line reaches 100 MHz, and boards run at 168 MHz; ";
    let error = refusal("stm32f412zg");
    assert!(error.starts_with(&format!("stm32f412zg is not supported: {speed}supported are ")), "{error}");
    for chip in ["stm32f413zh", "stm32f423ch"] {
        let error = refusal(chip);
        let expected =
            format!("{chip} is not supported: {speed}it has three CAN controllers, and boards drive two; ");
        assert!(error.starts_with(&expected), "{error}");
    }
}

#[test]
fn other_families_are_refused() {
    for chip in ["stm32f105rc", "stm32f207zg", "stm32f767zi", "stm32h743zi-cm7"] {
        let error = refusal(chip);
        let expected = format!(
            "{chip} is not supported: it is no STM32F4, and flash, clocks and CAN controllers of other families differ; "
        );
        assert!(error.starts_with(&expected), "{error}");
    }
}

#[test]
fn unknown_lines_sizes_and_short_names_are_refused() {
    let expected = "stm32f499rg is not supported: its line is unknown; supported are STM32F405, 407, 415, 417, 427, 429, \
                    437, 439, 446, 469 and 479";
    assert_eq!(refusal("stm32f499rg"), expected);
    let expected = "stm32f405ri is not supported: no flash size i of its line is known; known are e (512 KiB), g (1024 KiB)";
    assert_eq!(refusal("stm32f405ri"), expected);
    for chip in ["stm32f405", "stm32f405r", "stm32f405rgt6", "stm32f4é5rg"] {
        let expected = format!(
            "{chip} is not supported: a name has a letter for the package and one for the size of the flash behind the line, \
             as stm32f405rg"
        );
        assert_eq!(refusal(chip), expected);
    }
}
