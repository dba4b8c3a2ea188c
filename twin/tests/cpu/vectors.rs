//! Replays instructions from random states and compares with the answers of Unicorn (`judge/README.md`).

use can_twin::cpu::{Config, Core, Registers};

use crate::board::{CPACR, FLASH, Memory, RAM, Random, T};

const VECTORS: &[u8] = include_bytes!("../vectors/unicorn.bin");
/// Names another file of vectors.
const OTHER_VECTORS: &str = "TWIN_CORE_VECTORS";
const SIZE: usize = 0x1000;
const CODE: u32 = FLASH + 0x800;
const STACK: u32 = RAM + 0x800;
const FPSCR_BITS: u32 = 0xF7C0_009F;
const RMODE: u32 = 3 << 22;
/// Conditions on a state: an aligned base, rounding to nearest, the address of Thumb code in a register.
const ALIGNED: u8 = 1;
const TO_NEAREST: u8 = 2;
const TARGET: u8 = 4;
const APSR: u32 = 0xF80F_0000;
const SPECIALS: [u32; 16] = [
    0,
    0x8000_0000,
    1,
    0x8000_0001,
    0x007F_FFFF,
    0x0080_0000,
    0x3F80_0000,
    0xBF80_0000,
    0x7F7F_FFFF,
    0xFF7F_FFFF,
    0x7F80_0000,
    0xFF80_0000,
    0x7FC0_0001,
    0xFFC1_2345,
    0x7F80_0001,
    0xFFA0_0000,
];

/// Random numbers of a vector or of a memory.
fn seeded(index: u64) -> Random {
    Random((index + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15))
}

fn content(index: u64) -> Vec<u8> {
    let mut random = seeded(index);
    (0..SIZE / 4).flat_map(|_| random.next().to_le_bytes()).collect()
}

/// Reads the file.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    fn number(&mut self, bytes: usize) -> u64 {
        self.take(bytes).iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte))
    }

    fn word(&mut self) -> u32 {
        self.number(4) as u32
    }

    /// The words that a mask names replace those of `values`.
    fn changes(&mut self, mask: u32, values: &mut [u32]) {
        for (index, value) in values.iter_mut().enumerate() {
            if mask >> index & 1 == 1 {
                *value = self.word();
            }
        }
    }
}

fn state(index: u64, base: u8, register: u8, shape: u8) -> Registers {
    let mut random = seeded(index);
    let mut registers = Registers::default();
    for core in &mut registers.r[..15] {
        let (kind, value) = (random.next() % 8, random.next());
        *core = match kind {
            1 => value % 64,
            2 => 0x8000_0000,
            3 => 0xFFFF_FFFF,
            4 => 0x7FFF_FFFF,
            5 => 0,
            _ => value,
        };
    }
    registers.r[13] = STACK;
    let (place, offset) = (random.next(), random.next());
    if let Some(core) = registers.r.get_mut(usize::from(base)) {
        *core = (RAM + 0x600 + place % 0x200) & if shape & ALIGNED != 0 { !3 } else { !0 };
    }
    if let Some(core) = registers.r.get_mut(usize::from(register)) {
        *core = if shape & TARGET != 0 { offset & 0x1FFF_FFFF | 1 } else { offset % 0x40 };
    }
    registers.xpsr = random.next() & APSR | T;
    for single in &mut registers.s {
        let (kind, value, other) = (random.next() % 8, random.next(), random.next());
        *single = match kind {
            0 => SPECIALS[other as usize % 16],
            1 => value & 0x807F_FFFF,
            2 => value,
            3 => value & 0x807F_FFFF | (other % 254 + 1) << 23,
            _ => value & 0x807F_FFFF | (other % 24 + 116) << 23,
        };
    }
    let (kind, value) = (random.next() % 2, random.next());
    registers.fpscr = if kind == 1 { value & FPSCR_BITS } else { 0 };
    if shape & TO_NEAREST != 0 {
        registers.fpscr &= !RMODE;
    }
    registers.r[15] = CODE;
    registers
}

/// A core that may use its FPU, in memory without a program.
fn fresh(memory: &mut Memory) -> Core {
    let mut core = Core::new(Config { code: FLASH..FLASH, ..Config::stm32f4(0) });
    // MOV.W r0, #0xF00000; STR r0, [r1]: CPACR. VMRS r2, FPSCR: the context has used the FPU.
    memory.poke_code(CODE, &[0xF44F, 0x0070, 0x6008, 0xEEF1, 0x2A10]);
    let mut registers = Registers { xpsr: T, ..Registers::default() };
    (registers.r[1], registers.r[15]) = (CPACR, CODE);
    core.set_registers(&registers);
    for _ in 0..3 {
        core.step(memory).unwrap();
    }
    core
}

#[test]
fn instructions_answer_as_unicorn_does() {
    let other = std::env::var_os(OTHER_VECTORS).map(|path| std::fs::read(path).expect("a file of vectors"));
    let mut reader = Reader(other.as_deref().unwrap_or(VECTORS));
    let (count, seed) = (reader.word(), reader.number(8));
    let initial = Memory::writable([(FLASH, content(1 << 32)), (RAM, content(1 << 33))]);
    let core = fresh(&mut initial.clone());
    let mut differences = Vec::new();
    for index in 0..count {
        let [halves, steps, base, register, shape] = *reader.take(5) else { unreachable!() };
        let code = reader.take(2 * usize::from(halves));
        let before = state(seed << 40 | u64::from(index), base, register, shape);
        let mut expected = before;
        let mask = reader.number(2) as u32;
        reader.changes(mask, &mut expected.r[..15]);
        let mask = reader.word();
        reader.changes(mask, &mut expected.s);
        (expected.r[15], expected.xpsr, expected.fpscr) = (reader.word(), reader.word() | T, reader.word());
        let mut expected_ram = initial.0[1].content.clone();
        for _ in 0..reader.number(1) {
            let (at, length) = (reader.number(2) as usize, reader.number(1) as usize);
            expected_ram[at..at + length].copy_from_slice(reader.take(length));
        }

        let mut memory = initial.clone();
        memory.0[0].content[0x800..0x800 + code.len()].copy_from_slice(code);
        let mut core = core.clone();
        core.set_registers(&before);
        let mut outcome = Ok(());
        for _ in 0..steps {
            outcome = outcome.and(core.step(&mut memory).map(|_| ()));
        }
        let actual = core.registers();
        if outcome.is_err() || actual != expected || memory.0[1].content != expected_ram {
            let code: Vec<String> =
                code.chunks(2).map(|half| format!("{:02X}{:02X}", half[1], half[0])).collect();
            differences.push(format!(
                "vector {index}, {}: {outcome:?}{}",
                code.join(" "),
                describe(&before, &actual, &expected)
            ));
        }
    }
    assert!(reader.0.is_empty());
    let shown = differences.iter().take(40).cloned().collect::<Vec<_>>().join("\n");
    assert!(differences.is_empty(), "{} of {count} differ:\n{shown}", differences.len());
}

fn describe(before: &Registers, actual: &Registers, expected: &Registers) -> String {
    let mut text = String::new();
    let mut note = |name: String, before: u32, actual: u32, expected: u32| {
        if actual != expected {
            text += &format!("; {name} was {before:08X}, is {actual:08X}, expected {expected:08X}");
        }
    };
    for k in 0..16 {
        note(format!("r{k}"), before.r[k], actual.r[k], expected.r[k]);
    }
    for k in 0..32 {
        note(format!("s{k}"), before.s[k], actual.s[k], expected.s[k]);
    }
    note("xpsr".into(), before.xpsr, actual.xpsr, expected.xpsr);
    note("fpscr".into(), before.fpscr, actual.fpscr, expected.fpscr);
    text
}
