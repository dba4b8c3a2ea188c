//! Runs a small program on the core for a number of instructions. `cargo xtask bench --only twin` counts the instructions of the host
//! that it needs.
//!
//!     programs integers|floats|checksums INSTRUCTIONS

use can_twin::cpu::{Bus, BusError, Config, Core, Width};

const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0000;
/// Bytes of flash, and of RAM.
const SIZE: u32 = 1024;

/// Switches the FPU on by CPACR and sets r1 to the start of RAM.
///
/// ```text
/// movw r0, #0xED88; movt r0, #0xE000; mov.w r2, #0xF00000; str r2, [r0]; movs r1, #32; lsls r1, r1, #24
/// ```
const START: &[u16] = &[0xF64E, 0x5088, 0xF2CE, 0x0000, 0xF44F, 0x0270, 0x6002, 0x2120, 0x0609];

/// Additions, shifts, a store and a load in a loop.
///
/// ```text
/// 1: adds r2, r2, r3; eors r3, r2; lsls r4, r3, #3; str r4, [r1]; ldr r5, [r1]; add r2, r5, r4, ror #7; subs r0, #1; bne 1b; b 1b
/// ```
const INTEGERS: &[u16] = &[0x18D2, 0x4053, 0x00DC, 0x600C, 0x680D, 0xEB05, 0x12F4, 0x3801, 0xD1F6, 0xE7F5];

/// Square roots by Newton's method: 12 of the 14 instructions of the loop are those of the FPU.
///
/// ```text
///    vmov.f32 s0, #2.0; vmov.f32 s1, #1.0; vmov.f32 s2, #0.5; vmov.f32 s6, s1
/// 1: vdiv.f32 s3, s0, s1; vadd.f32 s3, s3, s1; vmul.f32 s1, s3, s2
///    vmov.f32 s4, s0; vfms.f32 s4, s1, s1; vabs.f32 s4, s4; vcmp.f32 s4, s2; vmrs APSR_nzcv, fpscr
///    vcvt.s32.f32 s5, s1; vstr s5, [r1]; vldr s5, [r1]; it lt; vaddlt.f32 s0, s0, s6; b 1b
/// ```
const FLOATS: &[u16] = &[
    0xEEB0, 0x0A00, 0xEEF7, 0x0A00, 0xEEB6, 0x1A00, 0xEEB0, 0x3A60, 0xEEC0, 0x1A20, 0xEE71, 0x1AA0, 0xEE61,
    0x0A81, 0xEEB0, 0x2A40, 0xEEA0, 0x2AE0, 0xEEB0, 0x2AC2, 0xEEB4, 0x2A41, 0xEEF1, 0xFA10, 0xEEFD, 0x2AE0,
    0xEDC1, 0x2A00, 0xEDD1, 0x2A00, 0xBFB8, 0xEE30, 0x0A03, 0xE7E5,
];

/// CRC-16 of 16 bytes by a function that is called again and again, bit by bit.
///
/// ```text
///    mov r4, r1; movs r5, #0
/// 1: bl 2f; str r0, [r4, r5]; adds r5, #4; and r5, r5, #60; b 1b
/// 2: push {r4, r5, r6, lr}; movs r2, #16; movw r3, #0x1021; mov r0, r2
/// 3: ldrb r6, [r4], #1; eor r0, r0, r6, lsl #8; movs r5, #8
/// 4: lsls r0, r0, #1; tst r0, #0x10000; it ne; eorne r0, r0, r3; subs r5, #1; bne 4b
///    uxth r0, r0; subs r2, #1; bne 3b; pop {r4, r5, r6, pc}
/// ```
const CHECKSUMS: &[u16] = &[
    0x460C, 0x2500, 0xF000, 0xF805, 0x5160, 0x3504, 0xF005, 0x053C, 0xE7F8, 0xB570, 0x2210, 0xF241, 0x0321,
    0x4610, 0xF814, 0x6B01, 0xEA80, 0x2006, 0x2508, 0x0040, 0xF410, 0x3F80, 0xBF18, 0x4058, 0x3D01, 0xD1F8,
    0xB280, 0x3A01, 0xD1F0, 0xBD70,
];

/// Flash and RAM.
struct Memory {
    flash: Vec<u8>,
    ram: Vec<u8>,
}

impl Memory {
    fn at(&mut self, address: u32, width: Width) -> Result<&mut [u8], BusError> {
        let (memory, from) = if address < RAM { (&mut self.flash, FLASH) } else { (&mut self.ram, RAM) };
        let start = address.wrapping_sub(from) as usize;
        memory.get_mut(start..start + width.bytes() as usize).ok_or(BusError)
    }
}

impl Bus for Memory {
    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        Ok(self.load(address, Width::Half)? as u16)
    }

    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        Ok(self.at(address, width)?.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte)))
    }

    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        let bytes = value.to_le_bytes();
        self.at(address, width)?.copy_from_slice(&bytes[..width.bytes() as usize]);
        Ok(())
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (program, count) = match &arguments[..] {
        [name, count] => (name.as_str(), count.parse::<u64>().expect("INSTRUCTIONS is a whole number")),
        _ => panic!("usage: programs integers|floats|checksums INSTRUCTIONS"),
    };
    let program = match program {
        "integers" => INTEGERS,
        "floats" => FLOATS,
        "checksums" => CHECKSUMS,
        other => panic!("no program {other:?}; allowed are integers, floats and checksums"),
    };

    let mut memory = Memory { flash: vec![0; SIZE as usize], ram: vec![0; SIZE as usize] };
    let start = FLASH + 0x100;
    let mut poke = |address, width, value| memory.store(address, width, value).expect("memory");
    poke(FLASH, Width::Word, RAM + SIZE); // initial stack pointer
    poke(FLASH + 4, Width::Word, start | 1); // first instruction, Thumb
    for (address, &half) in (start..).step_by(2).zip(START.iter().chain(program)) {
        poke(address, Width::Half, half.into());
    }

    let mut core = Core::new(Config::stm32f4(SIZE));
    core.step(&mut memory).expect("the reset sequence");
    for _ in 0..count {
        core.step(&mut memory).expect("the program goes on");
    }
}
