//! Runs every scenario and logs its result.

mod bus;
mod filters;
mod loopback;
mod rig;

use rig::{Outcome, Rig};
use stm32f4xx_hal::pac;
use {defmt_rtt as _, panic_probe as _};

/// Name of a scenario in the log, and its function.
type Scenario = (&'static str, fn(&mut Rig) -> Outcome);

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut rig = Rig::new(pac::Peripherals::take().unwrap());
    for (name, run) in [loopback::SCENARIOS, filters::SCENARIOS, bus::SCENARIOS].into_iter().flatten() {
        match run(&mut rig) {
            Ok(()) => defmt::info!("scenario {=str} passed", name),
            Err(reason) => defmt::error!("scenario {=str} failed: {=str}", name, reason),
        }
    }
    defmt::info!("done");
    beyond()
}

/// Starts the DAC, which the twin does not model.
#[inline(never)]
fn beyond() -> ! {
    stm32_metapac::RCC.apb1enr().modify(|w| w.set_dacen(true));
    stm32_metapac::DAC1.cr().write(|w| w.set_en(0, true));
    loop {
        cortex_m::asm::wfe();
    }
}
