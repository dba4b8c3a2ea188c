//! The chip's flash under the log.
//!
//! It accesses the registers directly: the HAL's driver supports every sector of every chip and takes three times the
//! memory.

use core::ptr::{self, addr_of};

use ecss_can::store::StoreError;
use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::regs::{Cr, Sr};
use embassy_stm32::pac::flash::vals::Psize;
use embassy_stm32::{Peri, peripherals};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

use super::{Opened, ParameterLog};

/// First address of the flash in all chips.
const BASE: u32 = 0x0800_0000;
/// Size of a sector of the store, in bytes.
const SECTOR: u32 = 128 * 1024;
const SECTORS: u32 = 2;
/// A chip with 2 MiB has two banks.
const BANK: u32 = 1 << 20;

/// Opens the parameter store. Call it before the controllers join their buses: an erase stalls the chip for one second,
/// two at most, and the watchdog is not fed meanwhile.
///
/// # Errors
/// [`StoreError::Hardware`] when the flash fails.
pub fn open(
    flash: Peri<'static, peripherals::FLASH>,
) -> Result<(ParameterLog<ChipFlash>, Opened), StoreError> {
    ParameterLog::open(ChipFlash(flash), start())
}

/// Returns the first sector of the store by the memory map of the chip (`ecss-can-memory`). It is an offset from the
/// start of flash, as all addresses in this module.
fn start() -> u32 {
    unsafe extern "C" {
        static __store_start: u8;
    }
    addr_of!(__store_start) as u32 - BASE
}

/// Flash that is programmed by words and erased by sectors of 128 KiB.
pub struct ChipFlash(
    #[allow(dead_code, reason = "held so that no other driver takes the flash")]
    Peri<'static, peripherals::FLASH>,
);

impl ErrorType for ChipFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for ChipFlash {
    const READ_SIZE: usize = 1;

    #[inline(never)]
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check(offset, bytes.len())?;
        // SAFETY: the area is flash of the store, which is always readable, and nothing programs it meanwhile.
        unsafe { ptr::copy_nonoverlapping((BASE + offset) as *const u8, bytes.as_mut_ptr(), bytes.len()) };
        Ok(())
    }

    fn capacity(&self) -> usize {
        (start() + SECTORS * SECTOR) as usize
    }
}

impl NorFlash for ChipFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check(from, to.saturating_sub(from) as usize)?;
        for at in (from..to).step_by(SECTOR as usize) {
            // A bank of 1 MiB has four sectors of 16 KiB and one of 64 before those of the store. Numbers of the second bank begin
            // at 16 (RM0090 3.9.8).
            let number = (at / BANK * 16 + at % BANK / SECTOR + 4) as u8;
            unlock(|w| {
                w.set_ser(true);
                w.set_snb(number);
            });
            FLASH.cr().modify(|w| w.set_strt(true));
            finish()?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check(offset, bytes.len())?;
        let (words, rest) = bytes.as_chunks();
        if !offset.is_multiple_of(4) || !rest.is_empty() {
            return Err(NorFlashErrorKind::NotAligned);
        }
        let mut at = (BASE + offset) as *mut u32;
        for word in words {
            unlock(|w| w.set_pg(true));
            // SAFETY: flash of the store, at an address that is a multiple of four; it takes writes while PG is set.
            unsafe { at.write_volatile(u32::from_le_bytes(*word)) };
            finish()?;
            at = at.wrapping_add(1);
        }
        Ok(())
    }
}

/// Checks that an area is in the store.
fn check(offset: u32, len: usize) -> Result<(), NorFlashErrorKind> {
    let before = offset.checked_sub(start()).ok_or(NorFlashErrorKind::OutOfBounds)?;
    let room = (SECTORS * SECTOR).checked_sub(before).ok_or(NorFlashErrorKind::OutOfBounds)?;
    if len <= room as usize { Ok(()) } else { Err(NorFlashErrorKind::OutOfBounds) }
}

/// Flags of FLASH_SR that are cleared by writing one: EOP, OPERR, WRPERR, PGAERR, PGPERR, PGSERR.
const FLAGS: Sr = Sr(0xF3);

/// Unlocks the flash and sets it to an operation (RM0090 3.6). Programs words of 32 bits, the widest access at 3.3 V.
/// Clears the flags first: flags of an earlier operation, as one of a debug probe, would count as errors of this one.
fn unlock(operation: impl FnOnce(&mut Cr)) {
    FLASH.sr().write_value(FLAGS);
    FLASH.keyr().write_value(0x4567_0123);
    FLASH.keyr().write_value(0xCDEF_89AB);
    FLASH.cr().write(|w| {
        w.set_psize(Psize::PSIZE32);
        operation(w);
    });
}

/// Waits for the end of an operation that was started, locks the flash and empties the data cache.
///
/// After an erase the data cache still holds the old content of the sector. After programming it holds the word that
/// was written, which may differ from the word in flash (RM0090 3.6.4). Either would be read instead of the flash.
#[inline(never)] // from two places
fn finish() -> Result<(), NorFlashErrorKind> {
    cortex_m::asm::dsb();
    while FLASH.sr().read().bsy() {}
    FLASH.cr().write(|w| w.set_lock(true));
    // The cache may be reset only while it is off, and the supervisor would mend that.
    cortex_m::interrupt::free(|_| {
        let acr = FLASH.acr().read();
        let mut off = acr;
        off.set_dcen(false);
        FLASH.acr().write_value(off);
        let mut reset = off;
        reset.set_dcrst(true);
        FLASH.acr().write_value(reset);
        FLASH.acr().write_value(off);
        FLASH.acr().write_value(acr);
    });
    let status = FLASH.sr().read();
    let failed = status.pgserr() || status.pgperr() || status.pgaerr() || status.wrperr();
    if failed { Err(NorFlashErrorKind::Other) } else { Ok(()) }
}
