//! A board takes its own peripherals and leaves the rest to the application.

use ecss_can_cli::images::Refusal;

use crate::scratch;

/// Returns the compiler's errors in a package with these statements after the start of a board.
fn refusals(board: &str, statements: &str) -> Vec<Refusal> {
    let manifest = format!(
        "[dependencies]\necss-can-stm32f4 = {{ path = \"ROOT/boards/stm32f4\" }}\n\
         board = {{ package = \"ecss-can-{board}\", path = \"ROOT/boards/{board}\" }}\n"
    );
    let program = format!(
        "#![no_std]\npub fn start() {{\n    let p = ecss_can_stm32f4::start::<board::Spec>();\n    \
         let _board = board::take!(p);\n    {statements}\n}}\n"
    );
    scratch::refusals(&manifest, &[("src/lib.rs", &program)])
}

/// E0382: use of a moved value.
#[test]
fn a_pin_that_the_board_has_taken_cannot_be_taken_again() {
    let twice = "let (_a, _b, _c, _d, _e) = (p.PB12, p.PA0, p.TIM5, p.TIM3, p.CAN2);";
    for (board, strap) in [("pyboard-v11", "PA2"), ("nucleo-f446re", "PC0")] {
        let refusals = refusals(board, &format!("{twice} let _strap = p.{strap};"));
        let codes: Vec<_> = refusals.iter().map(|refusal| refusal.code.as_deref()).collect();
        assert_eq!(codes, [Some("E0382"); 6], "{board}: {refusals:?}");
    }
}

#[test]
fn what_the_board_does_not_use_stays_with_the_application() {
    let rest = "let _mine = (p.ADC1, p.PC4, p.TIM4, p.USART2, p.DMA2_CH0, p.I2C1);";
    for board in ["pyboard-v11", "nucleo-f446re"] {
        assert_eq!(refusals(board, rest), [], "{board}");
    }
}
