//! Division of 64-bit numbers by the functions of the image, `boards/runtime/src/division.rs`, instruction by instruction.

use std::sync::Arc;

use can_twin::board::EmulatedBoard;
use can_twin::image::Image;
use can_twin::wire::time::Time;
use flight::{PYBOARD_V11, STANDARD, bare};

const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0000;

/// Returns numerators and denominators: combinations of limits of words and signs, and random ones of every length.
fn cases() -> Vec<[u64; 2]> {
    let near = |power: u32| [(1 << power) - 1, 1 << power, (1 << power) + 1];
    let edges: Vec<u64> =
        [0, 1, 2, 3, 10, 84, 1_000, 1_000_000, 0xFFFF_FFFF_0000_0000, u64::MAX - 1, u64::MAX]
            .into_iter()
            .chain([16, 31, 32, 33, 62, 63].into_iter().flat_map(near))
            .collect();
    let edges = edges.iter().flat_map(|numerator| edges.iter().map(|denominator| [*numerator, *denominator]));
    let mut random = fastrand::Rng::with_seed(11);
    let mut number = || random.u64(..) >> random.u32(..64);
    let lengths = std::iter::from_fn(|| Some([number(), number()])).take(2_000);
    edges.chain(lengths).filter(|[_, denominator]| *denominator != 0).collect()
}

/// Returns the image with another reset vector. A program after it divides all operands, and stores the results in r0
/// to r3.
fn dividing(image: &Image, function: &str, cases: &[[u64; 2]]) -> Image {
    let function = image.symbol(function).unwrap().address;
    let mut flash = image.flash().to_vec();
    flash.resize(flash.len().next_multiple_of(4), 0xFF);
    let program = FLASH + flash.len() as u32;
    let operands = program + 36;
    // LDR r4 to r7 from the four literals; LDMIA r7!, {r0-r3}; BLX r4; STMIA r6!, {r0-r3}; CMP r7, r5; BNE .-8; B .
    for opcode in [0x4C04u16, 0x4D05, 0x4E05, 0x4F06, 0xCF0F, 0x47A0, 0xC60F, 0x42AF, 0xD1FA, 0xE7FE] {
        flash.extend(opcode.to_le_bytes());
    }
    for literal in [function | 1, operands + 16 * cases.len() as u32, RAM, operands] {
        flash.extend(literal.to_le_bytes());
    }
    flash.extend(cases.iter().flatten().flat_map(|number| number.to_le_bytes()));
    flash[..8].copy_from_slice(&[(RAM + 0x2_0000).to_le_bytes(), (program | 1).to_le_bytes()].concat());
    Image::from_flash(flash)
}

/// Returns quotient and remainder of a function of the image for each pair of operands. The RAM of a board holds the
/// results of some thousand at once.
fn divided(function: &str, cases: &[[u64; 2]]) -> Vec<[u64; 2]> {
    cases.chunks(4_000).flat_map(|cases| run(function, cases)).collect()
}

fn run(function: &str, cases: &[[u64; 2]]) -> Vec<[u64; 2]> {
    let image = Arc::new(dividing(&STANDARD[1], function, cases));
    let mut board = EmulatedBoard::new(bare(PYBOARD_V11, image), 0);
    board.power(true);
    // 64 rounds of 16 cycles at 16 MHz.
    board.run_until(Time::from_us(70 * cases.len() as u64 + 1_000)).unwrap();

    let returned = board.read_memory(RAM, 16 * cases.len()).unwrap();
    let number = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().unwrap());
    returned.as_chunks::<16>().0.iter().map(|row| [number(&row[..8]), number(&row[8..])]).collect()
}

#[test]
fn division_of_the_image_agrees_with_the_hosts() {
    let cases = cases();
    for ([numerator, denominator], found) in cases.iter().zip(divided("__aeabi_uldivmod", &cases)) {
        let expected = [numerator / denominator, numerator % denominator];
        assert_eq!(found, expected, "{numerator:#X} / {denominator:#X}");
    }
}

#[test]
fn signed_division_of_the_image_agrees_with_the_hosts() {
    let negated = |numbers: &[u64; 2], signs: [bool; 2]| {
        [0, 1].map(|nth| if signs[nth] { numbers[nth].wrapping_neg() } else { numbers[nth] })
    };
    let signs = [[false, true], [true, false], [true, true]];
    let positive = cases();
    let signed = signs.iter().flat_map(|signs| positive.iter().map(|numbers| negated(numbers, *signs)));
    let cases: Vec<[u64; 2]> = positive.iter().copied().chain(signed).collect();
    for ([numerator, denominator], found) in cases.iter().zip(divided("__aeabi_ldivmod", &cases)) {
        let [numerator, denominator] = [*numerator as i64, *denominator as i64];
        // The least number by minus one, which Rust checks before, does not fit.
        let expected = [numerator.wrapping_div(denominator), numerator.wrapping_rem(denominator)];
        assert_eq!(found.map(|half| half as i64), expected, "{numerator} / {denominator}");
    }
}
