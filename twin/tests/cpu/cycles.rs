//! Cycles of each class of instructions against the tables of the technical reference manual, with P = 2.

use crate::board::*;

/// Cycles of the first instruction of a program. r0 points to RAM, r1 is 4, LR and the words of RAM are addresses of code.
fn cycles(program: &[u16]) -> u32 {
    let mut board = Board::new(program);
    board.store(CPACR, FPU_FOR_ALL);
    for word in 0..64 {
        board.bus.memory.poke(RAM + 0x100 + 4 * word, can_twin::cpu::Width::Word, CODE + 0x101);
    }
    board.set(|registers| {
        registers.r[0] = RAM + 0x100;
        registers.r[1] = 4;
        registers.r[2] = 0x7000_0000;
        registers.r[13] = RAM + 0x140;
        registers.r[14] = CODE + 0x101;
    });
    board.step().cycles
}

#[test]
fn classes_take_what_the_tables_say() {
    let cases: [(&str, &[u16], u32); 47] = [
        ("ADDS r0, r0, r1", &[0x1840], 1),
        ("MOVW r7, #0xE100", &[0xF24E, 0x1700], 1),
        ("MUL r2, r0, r1", &[0xFB00, 0xF201], 1),
        ("UMULL r2, r3, r0, r1", &[0xFBA0, 0x2301], 1),
        ("SMLABB r2, r0, r1, r3", &[0xFB10, 0x3201], 1),
        ("SMUAD r2, r0, r1", &[0xFB20, 0xF201], 1),
        ("QADD r2, r0, r1", &[0xFA81, 0xF280], 1),
        ("UDIV r3, r1, r2: quotient 0", &[0xFBB1, 0xF3F2], 2),
        ("UDIV r3, r2, r1: quotient of 29 bits", &[0xFBB2, 0xF3F1], 12),
        ("LDR r2, [r0]", &[0x6802], 2),
        ("LDRH r2, [r0]", &[0x8802], 2),
        ("STR r1, [r0]", &[0x6001], 2),
        ("LDR pc, [r0]", &[0xF8D0, 0xF000], 4),
        ("LDM r0!, {r1-r4}", &[0xC81E], 5),
        ("STMDB r0!, {r4, r5}", &[0xE920, 0x0030], 3),
        ("PUSH {r4, lr}", &[0xB510], 3),
        ("POP {r4, pc}", &[0xBD10], 5),
        ("LDRD r2, r3, [r0]", &[0xE9D0, 0x2300], 3),
        ("LDREX r2, [r0]", &[0xE850, 0x2F00], 2),
        ("STREX r3, r1, [r0], not exclusive", &[0xE840, 0x1300], 2),
        ("CLREX", &[0xF3BF, 0x8F2F], 1),
        ("B .+4", &[0xE000], 3),
        ("BL", &[0xF000, 0xF802], 3),
        ("BX lr", &[0x4770], 3),
        ("BLX lr", &[0x47F0], 3),
        ("BEQ, not taken", &[0xD001], 1),
        ("BNE, taken", &[0xD101], 3),
        ("CBZ r0, not taken", &[0xB108], 1),
        ("CBNZ r0, taken", &[0xB908], 3),
        ("TBB [r0, r1]", &[0xE8D0, 0xF001], 4),
        ("MOV pc, lr", &[0x46F7], 3),
        ("IT EQ", &[0xBF08], 1),
        ("NOP", &[0xBF00], 1),
        ("MRS r2, primask", &[0xF3EF, 0x8210], 1),
        ("CPSID i", &[0xB672], 1),
        ("ISB", &[0xF3BF, 0x8F6F], 1),
        ("VADD.F32 s0, s1, s2", &[0xEE30, 0x0A81], 1),
        ("VMOV r2, s0", &[0xEE10, 0x2A10], 1),
        ("VMOV r2, r3, s0, s1", &[0xEC53, 0x2A10], 2),
        ("VMRS r2, fpscr", &[0xEEF1, 0x2A10], 1),
        ("VCMP.F32 s0, s1", &[0xEEB4, 0x0A60], 1),
        ("VMLA.F32 s0, s1, s2", &[0xEE00, 0x0A81], 3),
        ("VFMA.F32 s0, s1, s2", &[0xEEA0, 0x0A81], 3),
        ("VDIV.F32 s0, s1, s2", &[0xEE80, 0x0A81], 14),
        ("VSQRT.F32 s0, s1", &[0xEEB1, 0x0AE0], 14),
        ("VLDR s4, [r0]", &[0xED90, 0x2A00], 2),
        ("VPUSH {s0-s3}", &[0xED2D, 0x0A04], 5),
    ];
    for (name, program, expected) in cases {
        assert_eq!(cycles(program), expected, "{name}");
    }
}
