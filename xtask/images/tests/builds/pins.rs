//! A board takes its own peripherals and leaves the rest with the application.

use std::fs;
use std::path::Path;

use firmware_images::Package;

const MANIFEST: &str = r#"
[package]
name = "pins"
version = "0.1.0"
edition = "2024"

[features]
pyboard-v11 = ["boards/pyboard-v11"]
nucleo-f446re = ["boards/nucleo-f446re"]

[dependencies]
boards = { path = "ROOT/boards" }

[workspace]
"#;

/// The compiler's errors in a package outside the workspace that does this behind the board's start.
fn refusals(board: &str, statements: &str) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("a workspace");
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).expect("a file");
    fs::create_dir(folder.path().join("src")).expect("a folder");
    fs::copy(root.join("Cargo.lock"), folder.path().join("Cargo.lock")).expect("a lock");
    write("Cargo.toml", MANIFEST.replace("ROOT", &root.display().to_string()));
    write(
        "src/lib.rs",
        format!(
            "#![no_std]\npub fn start() {{\n    let p = boards::start();\n    \
            let _board = boards::take!(p);\n    {statements}\n}}\n"
        ),
    );
    let package = Package { name: "pins".into(), manifest: folder.path().join("Cargo.toml") };
    package.refusals(board).expect("it is compiled")
}

/// E0382: use of a moved value.
#[test]
fn a_pin_that_the_board_has_taken_cannot_be_taken_again() {
    let twice = "let (_a, _b, _c, _d, _e) = (p.PB12, p.PA0, p.TIM5, p.TIM3, p.CAN2);";
    assert_eq!(refusals("pyboard-v11", &format!("{twice} let _strap = p.PA2;")), ["E0382"; 6]);
    assert_eq!(refusals("nucleo-f446re", &format!("{twice} let _strap = p.PC0;")), ["E0382"; 6]);
}

#[test]
fn what_the_board_does_not_use_stays_with_the_application() {
    let rest = "let _mine = (p.ADC1, p.PC4, p.TIM4, p.USART2, p.DMA2_CH0, p.I2C1);";
    for board in ["pyboard-v11", "nucleo-f446re"] {
        assert_eq!(refusals(board, rest), [""; 0], "{board}");
    }
}
