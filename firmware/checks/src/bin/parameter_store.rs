//! Saves a numbered set at each start, and reports the set that it found.
//!
//! On a board: press reset and watch the number rise; remove power at any time. The twin removes power at each
//! operation of the flash. With PC0 to ground a start saves a long set before the short one, which fills the page
//! sooner.

#![cfg_attr(target_os = "none", no_std, no_main)]

// The board that the image is built for.
#[cfg(all(target_os = "none", feature = "nucleo-f446re"))]
extern crate nucleo_f446re as board;
#[cfg(all(target_os = "none", feature = "pyboard-v11"))]
extern crate pyboard_v11 as board;
#[cfg(all(target_os = "none", feature = "stm32f4discovery"))]
extern crate stm32f4discovery as board;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is firmware: cargo run -p checks --bin parameter_store --profile firmware \\");
    println!("    --target thumbv7em-none-eabihf --features pyboard-v11");
}

#[cfg(target_os = "none")]
mod firmware {
    use core::sync::atomic::{AtomicU32, Ordering};

    use ecss_can::store::{ParameterStore, StoreError};
    use ecss_can_runtime as _; // log, panics, exceptions
    use ecss_can_stm32f4::store;
    use embassy_stm32::gpio::{Input, Pull};

    const SHORT: usize = 40;
    const LONG: usize = 4000;

    /// State of this start (1 opened and checked, 2 saved, 3 the flash has not taken the set), number found, number saved, sets damaged, sets of bytes that
    /// do not belong together.
    // SAFETY: no other symbol of the image has this name.
    #[unsafe(no_mangle)]
    static REPORT: [AtomicU32; 5] = [const { AtomicU32::new(0) }; 5];

    fn report(at: usize, value: u32) {
        REPORT[at].store(value, Ordering::Relaxed);
    }

    /// Returns bytes of a set from `start` on: the number, then bytes derived from it.
    fn piece(number: u32, start: usize) -> [u8; SHORT] {
        let mut piece = [0; SHORT];
        for (place, byte) in (start..).zip(&mut piece) {
            *byte = (number as u8).wrapping_mul(31).wrapping_add(place as u8);
        }
        if start == 0 {
            piece[..4].copy_from_slice(&number.to_le_bytes());
        }
        piece
    }

    fn save(log: &mut impl ParameterStore, number: u32, len: usize) -> Result<(), StoreError> {
        log.begin(len)?;
        for start in (0..len).step_by(SHORT) {
            log.append(&piece(number, start))?;
        }
        log.commit()
    }

    fn stored(log: &mut impl ParameterStore) -> u32 {
        let mut number = 0;
        for start in (0..log.stored_len()).step_by(SHORT) {
            let mut found = [0; SHORT];
            let read = log.read(start, &mut found);
            if start == 0 {
                number = u32::from_le_bytes([found[0], found[1], found[2], found[3]]);
            }
            if read.is_err() || found != piece(number, start) {
                report(4, 1);
            }
        }
        number
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        report(0, 0);
        report(4, 0);
        let p = embassy_stm32::init(Default::default());
        ecss_can_stm32f4::accelerate();
        let strap = Input::new(p.PC0, Pull::Up);
        let (mut log, opened) = store::open(p.FLASH).expect("the flash works");
        let mut number = stored(&mut log);
        report(1, number);
        report(3, opened.damaged);
        report(0, 1);
        for len in [LONG, SHORT] {
            if len == SHORT || strap.is_low() {
                number += 1;
                if let Err(error) = save(&mut log, number, len) {
                    defmt::error!("set {} is not saved: {}", number, error);
                    stop(3);
                }
                report(2, number);
            }
        }
        defmt::info!("set {} is saved, {}", number, opened);
        stop(2)
    }

    fn stop(state: u32) -> ! {
        report(0, state);
        loop {
            cortex_m::asm::wfi();
        }
    }
}
