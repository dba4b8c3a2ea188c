//! Memory protection: which addresses the program may read, write and execute.
//!
//! | addresses | use | rights |
//! | --- | --- | --- |
//! | from 0800 0000h | program | read, execute |
//! | last 256 KiB of flash | parameter store | read, write |
//! | 1000 0000h, 64 KiB | CCM | read, write |
//! | 1FFF 0000h, 32 KiB | system memory: unique ID | read |
//! | 2000 0000h to the end of SRAM | data | read, write |
//! | 4000 0000h, 512 KiB | APB1, APB2, AHB1 | read, write |
//! | 5000 0000h, 512 KiB | AHB2 | read, write |
//!
//! Any other access ends the program by a fault, with its record: by a null pointer, to the alias of flash at address 0, and
//! to the bit-band aliases. The private peripheral bus is always accessible. Region 7 is free: an application with external
//! memory sets it. The handlers of HardFault and NMI run without protection.

use core::ptr::addr_of;

use cortex_m::peripheral::MPU;

const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0000;
const KIB: u32 = 1 << 10;
const STORE_BYTES: u32 = 256 * KIB;

// Rights of privileged code in RASR.
const READ: u32 = 0b101 << 24;
const WRITE: u32 = 0b001 << 24;
const NO_EXECUTION: u32 = 1 << 28;
// Memory types as in the default map (ARMv7-M, B3.1). Not shareable: the chip has no global monitor for STREX.
const WRITE_THROUGH: u32 = 0b0_00010 << 16;
const WRITE_BACK: u32 = 0b0_01011 << 16;
const DEVICE: u32 = 0b0_10000 << 16;
/// RBAR: the lowest bits are the number of the region.
const VALID: u32 = 1 << 4;
/// RASR and CTRL. The background region stays off: addresses outside of all regions are not accessible.
const ENABLE: u32 = 1;

const DATA: u32 = WRITE | NO_EXECUTION | WRITE_BACK;
const PERIPHERALS: u32 = WRITE | NO_EXECUTION | DEVICE;

unsafe extern "C" {
    static __store_start: u8;
    static _ram_end: u8;
}

/// RASR of a region of 2^`exponent` bytes.
const fn of_size(exponent: u32, attributes: u32) -> u32 {
    attributes | (exponent - 1) << 1 | ENABLE
}

/// Bits of RASR that leave out the eighths of a region from `bytes` on. An eighth has 2^`exponent` bytes.
const fn up_to(bytes: u32, exponent: u32) -> u32 {
    (0xFF << (bytes >> exponent) & 0xFF) << 8
}

/// Switches the protection on.
pub(crate) fn start() {
    let (store, end_of_ram) = (addr_of!(__store_start) as u32, addr_of!(_ram_end) as u32);
    let regions = [
        // 2 MiB in eighths of 256 KiB: all sizes of flash are multiples.
        (FLASH, of_size(21, READ | WRITE_THROUGH) | up_to(store - FLASH, 18)),
        (store, const { of_size(STORE_BYTES.ilog2(), WRITE | NO_EXECUTION | WRITE_THROUGH) }),
        (0x1000_0000, const { of_size(16, DATA) }),
        (0x1FFF_0000, const { of_size(15, READ | NO_EXECUTION | WRITE_THROUGH) }),
        // 512 KiB in eighths of 64 KiB: all sizes of SRAM are multiples.
        (RAM, of_size(19, DATA) | up_to(end_of_ram - RAM, 16)),
        (0x4000_0000, const { of_size(19, PERIPHERALS) }),
        (0x5000_0000, const { of_size(19, PERIPHERALS) }),
    ];
    // SAFETY: no other part of the program uses the MPU. The regions contain all memories and peripherals of the program.
    unsafe {
        let mpu = &*MPU::PTR;
        for (number, (base, attributes)) in (0..).zip(regions) {
            mpu.rbar.write(base | VALID | number);
            mpu.rasr.write(attributes);
        }
        mpu.ctrl.write(ENABLE);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
