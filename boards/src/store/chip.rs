//! The chip's flash under the log.

use core::ptr::addr_of;

use ecss_can::store::StoreError;
use embassy_stm32::flash::{Blocking, Error, FLASH_BASE, Flash};
use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::vals::Psize;
use embassy_stm32::{Peri, peripherals};
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

use super::{Opened, ParameterLog};

/// Opens the parameter store. Before the controllers join their buses: where it has to erase, the chip stands still for
/// one second, two at most, and so does whoever would feed a watchdog.
///
/// # Errors
/// [`StoreError::Hardware`] when the flash fails.
pub fn open(
    flash: Peri<'static, peripherals::FLASH>,
) -> Result<(ParameterLog<ChipFlash>, Opened), StoreError> {
    // The memory map of the chip (`memory/*.x`) says where the two sectors are.
    unsafe extern "C" {
        static __store_start: u8;
    }
    let start = addr_of!(__store_start) as u32;
    ParameterLog::open(ChipFlash(Flash::new_blocking(flash)), start - FLASH_BASE as u32)
}

/// The HAL's driver, erasing as fast as 3.3 V allow; addresses are offsets from the start of flash.
pub struct ChipFlash(Flash<'static, Blocking>);

impl ErrorType for ChipFlash {
    type Error = Error;
}

impl ReadNorFlash for ChipFlash {
    const READ_SIZE: usize = <Flash<'static, Blocking> as ReadNorFlash>::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        self.0.blocking_read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for ChipFlash {
    const WRITE_SIZE: usize = <Flash<'static, Blocking> as NorFlash>::WRITE_SIZE;
    const ERASE_SIZE: usize = <Flash<'static, Blocking> as NorFlash>::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        // The driver leaves PSIZE as it finds it, which is x8 and takes twice as long (DS8626, flash programming).
        FLASH.keyr().write_value(0x4567_0123);
        FLASH.keyr().write_value(0xCDEF_89AB);
        FLASH.cr().modify(|w| w.set_psize(Psize::PSIZE32));
        let outcome = self.0.blocking_erase(from, to);
        // What the data cache holds of the sector is past (RM0090 3.5.4); it is reset while it is off.
        if FLASH.acr().read().dcen() {
            FLASH.acr().modify(|w| w.set_dcen(false));
            FLASH.acr().modify(|w| w.set_dcrst(true));
            FLASH.acr().modify(|w| w.set_dcrst(false));
            FLASH.acr().modify(|w| w.set_dcen(true));
        }
        outcome
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.0.blocking_write(offset, bytes)
    }
}
