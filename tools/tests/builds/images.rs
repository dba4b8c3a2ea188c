//! The images are ELF files for ARM with any toolchain.

use std::fs;

/// `e_machine` of ARM (ELF for the ARM Architecture, table 4-1).
const EM_ARM: [u8; 2] = [40, 0];

#[test]
fn the_images_of_all_boards_are_arm_executables() {
    for board in ["pyboard-v11", "nucleo-f446re"] {
        let images = ecss_can_cli::images::build(board, "librecube").expect("the images build");
        let minimal = ecss_can_cli::images::build_minimal(board, "librecube", ecss_can_cli::images::LOG);
        for path in [images.master, images.slave, minimal.expect("the image builds")] {
            let elf = fs::read(&path).expect("the image is where the builder says");
            assert_eq!(elf[..4], *b"\x7FELF", "{}", path.display());
            assert_eq!(elf[18..20], EM_ARM, "{}", path.display());
        }
    }
}

#[test]
fn an_unknown_board_is_an_error() {
    let error =
        ecss_can_cli::images::build("no-such-board", "librecube").expect_err("there is no such board");
    assert!(matches!(error, ecss_can_cli::images::Error::Failed(..)), "{error}");
}
