//! Measures the time per emulated instruction of a loop of mixed instructions.
//!
//! ```sh
//! cargo run --release -p twin-core --example speed [instructions]
//! ```

use std::time::Instant;

use twin_core::{Bus, BusError, Config, Core, Width};

const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0000;
const SIZE: usize = 0x1000;
const INSTRUCTIONS: u64 = 100_000_000;

/// A loop of 21 instructions as compilers write them: loads, stores, arithmetic, a call, an IT block.
const PROGRAM: [u16; 27] = [
    0x6802, // LDR r2, [r0]
    0x3201, // ADDS r2, #1
    0x6002, // STR r2, [r0]
    0xEA82, 0x0343, // EOR r3, r2, r3, LSL #1
    0x7881, // LDRB r1, [r0, #2]
    0x4419, // ADD r1, r3
    0xF3C1, 0x1407, // UBFX r4, r1, #4, #8
    0x2C80, // CMP r4, #128
    0xBFC8, // IT GT
    0x3C01, // SUBGT r4, #1
    0xF000, 0xF807, // BL the function
    0x8085, // STRH r5, [r0, #4]
    0xFB04, 0xF605, // MUL r6, r4, r5
    0x3F01, // SUBS r7, #1
    0xD0EC, // BEQ the beginning
    0xE7EB, // B the beginning
    0xBF00, // NOP
    0xB510, // the function: PUSH {r4, lr}
    0x0065, // LSLS r5, r4, #1
    0x1B2D, // SUBS r5, r5, r4
    0xEA45, 0x1503, // ORR r5, r5, r3, LSL #4
    0xBD10, // POP {r4, pc}
];

struct Memory {
    flash: Vec<u8>,
    ram: Vec<u8>,
}

impl Memory {
    #[inline]
    fn bytes(&mut self, address: u32, width: Width) -> Result<&mut [u8], BusError> {
        let (base, bytes) = if address >= RAM { (RAM, &mut self.ram) } else { (FLASH, &mut self.flash) };
        let at = address.wrapping_sub(base) as usize;
        bytes.get_mut(at..at + width.bytes() as usize).ok_or(BusError)
    }
}

impl Bus for Memory {
    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        self.load(address, Width::Half).map(|half| half as u16)
    }

    #[inline]
    fn load(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        let bytes = self.bytes(address, width)?;
        Ok(match *bytes {
            [a] => u32::from(a),
            [a, b] => u32::from_le_bytes([a, b, 0, 0]),
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            _ => return Err(BusError),
        })
    }

    #[inline]
    fn store(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        self.bytes(address, width)?.copy_from_slice(&value.to_le_bytes()[..width.bytes() as usize]);
        Ok(())
    }
}

fn main() {
    let mut memory = Memory { flash: vec![0; SIZE], ram: vec![0; SIZE] };
    let words = [RAM + SIZE as u32, FLASH + 0x101];
    let code = words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    memory.flash[..8].copy_from_slice(&code);
    let code = PROGRAM.iter().flat_map(|half| half.to_le_bytes()).collect::<Vec<u8>>();
    memory.flash[0x100..0x100 + code.len()].copy_from_slice(&code);
    let mut core = Core::new(Config::stm32f4(SIZE as u32));
    core.step(&mut memory).expect("the reset sequence");
    let mut registers = core.registers();
    registers.r[0] = RAM + 0x100;
    core.set_registers(&registers);

    let count = std::env::args().nth(1).map_or(INSTRUCTIONS, |count| count.parse().expect("a number"));
    let begun = Instant::now();
    let mut steps = 0;
    while steps < count {
        let run = core.run(&mut memory, 100_000);
        assert_eq!(run.stop, None, "the loop has no end");
        steps += run.steps;
    }
    let elapsed = begun.elapsed();
    println!(
        "{steps} instructions, {} cycles in {:.2} s: {:.2} ns per instruction",
        core.cycle(),
        elapsed.as_secs_f64(),
        elapsed.as_nanos() as f64 / steps as f64
    );
}
