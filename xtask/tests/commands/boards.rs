//! Boards of the user by a description alone: mistakes in it, and a description without the crate of its board.

use second::programs::boards::description;

use crate::XTASK;

/// Given a mistake in a description, then each command that has `--board` refuses it and names field, value and what is allowed.
#[test]
fn mistakes_in_a_description_are_refused() {
    let (_folder, path) = description(&[("PA6", "PA99")]);
    for command in [&["selftest"][..], &["clippy"]] {
        XTASK.refuses(&[command, &["--board", &path]].concat(), &["straps.parity", "PA99", "PA0 to PK15"]);
    }
}

/// Given a good description without the crate of its board beside it, then commands that would build images refuse it and say what
/// they can build for.
#[test]
fn images_are_not_built_for_a_board_without_crate() {
    let (folder, path) = description(&[("pyboard-v11", "mine")]);
    let folder = folder.path().to_str().expect("UTF-8");
    for board in [&path, folder] {
        let said = ["no Cargo.toml", folder, "pyboard-v11, nucleo-f446re", "Cargo.toml and board.toml"];
        XTASK.refuses(&["selftest", "--board", board], &said);
    }
    let said = ["'mine'", "its own boards", "pyboard-v11, nucleo-f446re"];
    XTASK.refuses(&["clippy", "--board", &path], &said);
}
