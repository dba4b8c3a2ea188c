//! Data processing, bit fields, saturation, parallel arithmetic and multiplies: one line for each (DDI 0403E chapter A7).

use crate::board::*;

/// Content of r3 before the instruction.
const BEFORE: u32 = 0xAAAA_5555;
const GE_SHIFT: u32 = 16;

/// Text, encoding, r0, r1, then r3 and flags afterwards. r2 is 100; C is set before.
type Case = (&'static str, &'static [u16], u32, u32, u32, u32);

const CASES: [Case; 49] = [
    ("ADCS r3, r0, r1", &[0xEB50, 0x0301], u32::MAX, 0, 0, Z | C),
    ("SBCS r3, r0, r1", &[0xEB70, 0x0301], 5, 5, 0, Z | C),
    ("RSBS r3, r0, #0", &[0x4243], 1, 0, u32::MAX, N),
    ("ADDS r3, r0, #0xFF00FF00", &[0xF110, 0x23FF], 0x00FF_0100, 0, 0, Z | C),
    ("ANDS r3, r0, #0x80000000", &[0xF010, 0x4300], u32::MAX, 0, 0x8000_0000, N | C),
    ("BICS r3, r0, r1, LSR #4", &[0xEA30, 0x1311], u32::MAX, 0xFF8, 0xFFFF_FF00, N | C),
    ("ORN r3, r0, r1", &[0xEA60, 0x0301], 0x0F, 0xFFFF_FF00, 0xFF, C),
    ("EORS r3, r0, r1, ROR #8", &[0xEA90, 0x2331], 0x1234_5678, 0x3456_7812, 0, Z),
    ("MVNS r3, r0", &[0x43C3], 0, 0, u32::MAX, N | C),
    ("RRXS r3, r0", &[0xEA5F, 0x0330], 1, 0, 0x8000_0000, N | C),
    ("LSLS r3, r0, r1", &[0xFA10, 0xF301], 1, 32, 0, Z | C),
    ("ASRS r3, r0, r1", &[0xFA50, 0xF301], 0x8000_0000, 40, u32::MAX, N | C),
    ("TST r0, r1", &[0x4208], 0xF0, 0x0F, BEFORE, Z | C),
    ("TEQ r0, r1", &[0xEA90, 0x0F01], 7, 7, BEFORE, Z | C),
    ("CMN r0, r1", &[0x42C8], 0x7FFF_FFFF, 1, BEFORE, N | V),
    ("MOVT r3, #0x1234", &[0xF2C1, 0x2334], 0, 0, 0x1234_5555, C),
    ("BFI r3, r0, #4, #8", &[0xF360, 0x130B], 0xFF, 0, 0xAAAA_5FF5, C),
    ("BFC r3, #8, #16", &[0xF36F, 0x2317], 0, 0, 0xAA00_0055, C),
    ("SBFX r3, r0, #4, #8", &[0xF340, 0x1307], 0xF80, 0, 0xFFFF_FFF8, C),
    ("UBFX r3, r0, #28, #4", &[0xF3C0, 0x7303], 0xA000_0000, 0, 0xA, C),
    ("SSAT r3, #8, r0", &[0xF300, 0x0307], 300, 0, 127, Q | C),
    ("USAT r3, #8, r0, ASR #4", &[0xF3A0, 0x1308], 0xFFFF_FFF0, 0, 0, Q | C),
    ("SSAT16 r3, #4, r0", &[0xF320, 0x0303], 0x0008_FFF0, 0, 0x0007_FFF8, Q | C),
    ("UXTAB r3, r0, r1, ROR #8", &[0xFA50, 0xF391], 0x100, 0xAB00, 0x1AB, C),
    ("SXTB16 r3, r0", &[0xFA2F, 0xF380], 0x0080_0080, 0, 0xFF80_FF80, C),
    ("REV16 r3, r0", &[0xBA43], 0x1122_3344, 0, 0x2211_4433, C),
    ("REVSH r3, r0", &[0xBAC3], 0x80, 0, 0xFFFF_8000, C),
    ("RBIT r3, r0", &[0xFA90, 0xF3A0], 1, 0, 0x8000_0000, C),
    ("CLZ r3, r0", &[0xFAB0, 0xF380], 0x0001_0000, 0, 15, C),
    ("SADD16 r3, r0, r1", &[0xFA90, 0xF301], 0x7FFF_8000, 0x0001_8000, 0x8000_0000, C | 0b1100 << GE_SHIFT),
    ("UQSUB8 r3, r0, r1", &[0xFAC0, 0xF351], 0x0102_0304, 0x0201_0404, 0x0001_0000, C),
    ("SHASX r3, r0, r1", &[0xFAA0, 0xF321], 0x0004_0002, 0x0006_0008, 0x0006_FFFE, C),
    ("USUB8 r3, r0, r1", &[0xFAC0, 0xF341], 0x0500_0180, 0x0401_0180, 0x01FF_0000, C | 0b1011 << GE_SHIFT),
    ("QADD r3, r0, r1", &[0xFA81, 0xF380], 0x7FFF_FFFF, 1, 0x7FFF_FFFF, Q | C),
    ("QDSUB r3, r0, r1", &[0xFA81, 0xF3B0], 0, 0x6000_0000, 0x8000_0001, Q | C),
    ("PKHBT r3, r0, r1, LSL #16", &[0xEAC0, 0x4301], 0x1111_AAAA, 0x2222_BBBB, 0xBBBB_AAAA, C),
    ("PKHTB r3, r0, r1, ASR #16", &[0xEAC0, 0x4321], 0x1111_AAAA, 0x8222_BBBB, 0x1111_8222, C),
    ("USADA8 r3, r0, r1, r2", &[0xFB70, 0x2301], 0x0102_0304, 0x0403_0201, 108, C),
    ("MLA r3, r0, r1, r2", &[0xFB00, 0x2301], 7, 6, 142, C),
    ("MLS r3, r0, r1, r2", &[0xFB00, 0x2311], 7, 6, 58, C),
    ("SMLABT r3, r0, r1, r2", &[0xFB10, 0x2311], 0xFFFF, 0x0005_0000, 95, C),
    ("SMLAWB r3, r0, r1, r2", &[0xFB30, 0x2301], 0x0002_0000, 3, 106, C),
    ("SMLADX r3, r0, r1, r2", &[0xFB20, 0x2311], 0x0002_0003, 0x0005_0007, 129, C),
    ("SMLSD r3, r0, r1, r2", &[0xFB40, 0x2301], 0x0002_0003, 0x0005_0007, 111, C),
    ("SMMLAR r3, r0, r1, r2", &[0xFB50, 0x2311], 0x4000_0000, 2, 101, C),
    ("SMULL r3, r4, r0, r1", &[0xFB80, 0x3401], u32::MAX, 2, 0xFFFF_FFFE, C),
    ("SDIV r3, r0, r1", &[0xFB90, 0xF3F1], 0xFFFF_FFF9, 2, 0xFFFF_FFFD, C),
    ("SDIV r3, r0, r1: the one overflow", &[0xFB90, 0xF3F1], 0x8000_0000, u32::MAX, 0x8000_0000, C),
    ("UDIV r3, r0, r1: by zero", &[0xFBB0, 0xF3F1], 7, 0, 0, C),
];

#[test]
fn instructions_give_results_and_flags() {
    for (name, program, r0, r1, r3, flags) in CASES {
        let mut board = Board::new(program);
        board.set(|registers| {
            registers.r[..4].copy_from_slice(&[r0, r1, 100, BEFORE]);
            registers.xpsr = C | 1 << 24;
        });
        let registers = board.steps(1);
        assert_eq!((registers.r[3], registers.xpsr), (r3, flags | 1 << 24), "{name}");
    }
}

/// The sum of the products alone is 2^31; with the third operand the sum fits (A7.7, SMLAD).
#[test]
fn smlad_sets_q_by_the_whole_sum() {
    // SMLAD, SMLADX r3, r0, r1, r2
    for (third, result, flags) in [(u32::MAX, 0x7FFF_FFFF, 0), (0, 0x8000_0000, Q)] {
        for program in [[0xFB20, 0x2301], [0xFB20, 0x2311]] {
            let mut board = Board::new(&program);
            board.set(|registers| registers.r[..3].copy_from_slice(&[0x8000_8000, 0x8000_8000, third]));
            let registers = board.steps(1);
            assert_eq!((registers.r[3], registers.xpsr & Q), (result, flags), "{third:08X}");
        }
    }
}
