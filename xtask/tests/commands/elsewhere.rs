//! A board whose crate is in another folder: the self-test is built for it and runs on it.

use second::programs::boards::elsewhere;

use crate::XTASK;

#[test]
fn self_test_flies_on_a_board_elsewhere() {
    let board = elsewhere(env!("CARGO_TARGET_TMPDIR"));
    let (code, stdout, stderr) = XTASK.run(&["selftest", "--twin", "--board", &board]);
    assert_eq!(code, 0, "{stdout}{stderr}");
}
