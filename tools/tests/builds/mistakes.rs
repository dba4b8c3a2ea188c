//! Mistakes in the crate of a board: each stops the build with a message that names it.

use std::fs;

use ecss_can_cli::images::Refusal;

use crate::scratch;

/// Returns the errors of the pyboard's crate with `from` replaced by `to`, and with a call that starts the board.
fn refusals(from: &str, to: &str) -> Vec<Refusal> {
    let pyboard =
        fs::read_to_string(scratch::root().join("boards/pyboard-v11/src/lib.rs")).expect("the pyboard");
    assert_eq!(pyboard.matches(from).count(), 1, "{from}");
    let program =
        pyboard.replace(from, to) + "\npub fn start() {\n    ecss_can_stm32f4::start::<Spec>();\n}\n";
    let manifest = "[dependencies]\n\
        ecss-can-stm32f4 = { path = \"ROOT/boards/stm32f4\", default-features = false }\n\
        embassy-stm32 = { version = \"=0.6.0\", default-features = false, features = [\"stm32f405rg\"] }\n";
    scratch::refusals(manifest, &[("src/lib.rs", &program)])
}

/// Checks that one of the errors has this code and all these parts of its text.
fn assert_names(refusals: &[Refusal], code: Option<&str>, parts: &[&str]) {
    let is_it = |refusal: &&Refusal| parts.iter().all(|part| refusal.text.contains(part));
    let found = refusals.iter().find(is_it);
    assert_eq!(found.map(|refusal| refusal.code.as_deref()), Some(code), "{parts:?} in {refusals:#?}");
}

/// E0080: the evaluation of a constant panicked.
#[test]
fn oscillator_without_settings_is_named_with_its_frequency() {
    let refusals = refusals("crystal(12_000_000)", "crystal(8_100_000)");
    let said =
        "oscillator of 8100000 Hz does not give HCLK of 168000000 Hz exactly, take a whole number of MHz";
    assert_names(&refusals, Some("E0080"), &[said]);
}

#[test]
fn clock_of_the_core_that_is_not_allowed_is_named() {
    let refusals = refusals("    nominal_rx:", "    hclk: 180_000_000,\n    nominal_rx:");
    let said = "HCLK of 180000000 Hz, allowed 168000000 or 84000000 Hz";
    assert_names(&refusals, Some("E0080"), &[said]);
}

/// E0277: PB7 is no transmit pin of CAN1 (DS8626 table 9).
#[test]
fn pin_that_the_controller_does_not_have_is_named() {
    let refusals = refusals("nominal_tx: PB9", "nominal_tx: PB7");
    assert_names(&refusals, Some("E0277"), &["PB7", "TxPin<", "CAN1"]);
}

/// E0277: the stream of another channel, and one of no channel of TIM5 (RM0090 table 42).
#[test]
fn dma_stream_of_another_pin_is_named_with_the_right_ones() {
    for (from, to, pin) in
        [("DMA1_CH2", "DMA1_CH1", "Ch1"), ("DMA1_CH2", "DMA1_CH5", "Ch1"), ("DMA1_CH4", "DMA1_CH0", "Ch2")]
    {
        let refusals = refusals(from, to);
        let (said, channel) =
            (format!("`{to}` does not move what channel"), format!("{pin}` of TIM5 captures"));
        let entries = "`nominal_stream` belongs to `nominal_edges`, `redundant_stream` to `redundant_edges`";
        let streams = "PA0 has DMA1_CH2, PA1 has DMA1_CH4, PA2 has DMA1_CH0, PA3 has DMA1_CH1";
        assert_names(&refusals, Some("E0277"), &[&said, &channel, entries, streams]);
        assert_eq!(refusals.len(), 1, "{refusals:#?}");
    }
}

/// E0124: a field is declared twice.
#[test]
fn pin_that_is_listed_twice_is_named() {
    let refusals = refusals("strap_1: PA3", "strap_1: PA2");
    assert_names(&refusals, Some("E0124"), &["PA2", "already declared"]);
}

/// The errors of a package for `chip` with the description of the pyboard, without a program: the build script reads the manifest, where
/// the HAL is optional, so that it is not compiled.
fn refusals_of_chip(chip: &str, board_chip: &str) -> Vec<Refusal> {
    let manifest = format!(
        "[dependencies]\nembassy-stm32 = {{ version = \"=0.6.0\", optional = true, features = [\"{chip}\"] }}\n\
         [build-dependencies]\necss-can-memory = {{ path = \"ROOT/boards/memory\" }}\n"
    );
    let board = scratch::root().join("boards/pyboard-v11");
    let read = |name: &str| fs::read_to_string(board.join(name)).expect("the pyboard");
    let description = read("board.toml").replace("STM32F405RG", board_chip);
    let files =
        [("src/lib.rs", "#![no_std]\n"), ("build.rs", &read("build.rs")), ("board.toml", &description)];
    scratch::refusals(&manifest, &files)
}

#[test]
fn chips_that_differ_are_both_named() {
    let refusals = refusals_of_chip("stm32f407vg", "STM32F405RG");
    let said = ["Cargo.toml has the chip stm32f407vg", "board.toml has the chip STM32F405RG"];
    assert_names(&refusals, None, &said);
}

#[test]
fn chip_that_is_too_slow_is_refused_with_the_reason() {
    let refusals = refusals_of_chip("stm32f412rg", "STM32F412RG");
    assert_names(&refusals, None, &["stm32f412rg is not supported", "100 MHz"]);
}
