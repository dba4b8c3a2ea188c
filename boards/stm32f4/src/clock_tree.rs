//! Oscillator, PLL and flash accelerator, which are started before anything else.
//!
//! The HAL waits for HSE without a time limit, so HSE is started and checked here first. A board whose oscillator does
//! not run stays on HSI, whose error of up to 1 % no CAN network tolerates. It accesses no controller, logs the
//! failure, and retries without limit: the oscillator may start late, as the clock that a NUCLEO gets from its ST-LINK
//! does without USB.

#[cfg(feature = "full")]
mod registers;

use thiserror::Error;

use cortex_m::peripheral::SYST;
use ecss_can::runner::Clock;
use ecss_can::types::Duration;
use embassy_stm32::gpio::{AnyPin, Pin};
use embassy_stm32::pac::{DBGMCU, FLASH, RCC, TIM2};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peri, Peripherals};

use crate::Uptime;
use crate::clocks::{Oscillator, OscillatorKind};
use crate::common::dark;
use crate::protection;
use crate::spec::{BoardSpec, clocks_of};
#[cfg(feature = "full")]
pub(crate) use registers::REGISTERS;

/// Reads of HSERDY before the board reports that HSE does not run. A read takes 6 to 16 cycles of HSI (16 MHz), which
/// gives 0.1 to 0.3 s. A crystal takes 2 ms (DS8626 table 34); the vendor's HAL waits 100 ms.
const HSE_LOOKS: u32 = 270_000;
/// Prescaler of TIM2 for a count in milliseconds of HSI.
const MILLISECOND: u16 = 16_000 - 1;
/// Time between changes of the LEDs on a board without oscillator, in milliseconds minus one.
const TURN: u32 = 250 - 1;

/// Starts memory protection, the clocks of the board `B` and the HAL: APB1 at 42 MHz, its timers at 84 MHz, the core at
/// [`BoardSpec::HCLK`]. One bit timing and one timer rate on all boards.
///
/// From here on only the program is executed, and it is not written. Flash, RAM, system memory and peripherals on APB and AHB are
/// accessible. Any other access is a fault: by a null pointer, to bit-band aliases, to external memory. Region 7 of the MPU is
/// free for the latter.
///
/// Without its oscillator the board does not return from here until the oscillator runs: it logs the failure, its LEDs
/// light in turn, and both controllers stay in reset. An oscillator from which HCLK cannot be derived fails the build.
///
/// # Panics
/// When called twice.
pub fn start<B: BoardSpec>() -> Peripherals {
    protection::start();
    let clocks = const { clocks_of::<B>() };
    if !oscillates(B::OSCILLATOR) {
        // SAFETY: `Peripherals` were not handed out yet, and this copy is dropped before that happens.
        let board = B::wiring(B::resources(unsafe { Peripherals::steal() }));
        let [sync, state, ..] = board.leds;
        wait_for_oscillator([sync, state]);
    }
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz(B::OSCILLATOR.hz()), mode: mode(B::OSCILLATOR) });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::from_bits(clocks.prediv),
        mul: PllMul::from_bits(clocks.multiplier),
        // A divider of 2, 4, 6 or 8 is encoded as 0 to 3 (RM0090 7.3.2).
        divp: Some(PllPDiv::from_bits(clocks.divider / 2 - 1)),
        divq: None,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = prescaler(clocks.apb1);
    config.rcc.apb2_pre = prescaler(clocks.apb2);
    let peripherals = embassy_stm32::init(config);
    accelerate();
    // From now on a failure of HSE raises the NMI, which ends the program (`post_mortem`).
    RCC.cr().modify(|w| w.set_csson(true));
    peripherals
}

fn prescaler(divider: u8) -> APBPrescaler {
    match divider {
        1 => APBPrescaler::DIV1,
        2 => APBPrescaler::DIV2,
        _ => APBPrescaler::DIV4,
    }
}

fn mode(oscillator: Oscillator) -> HseMode {
    match oscillator.kind() {
        OscillatorKind::Crystal => HseMode::Oscillator,
        OscillatorKind::External => HseMode::Bypass,
    }
}

/// Starts HSE and waits for it, on HSI. Returns whether it runs.
fn oscillates(oscillator: Oscillator) -> bool {
    RCC.cr().modify(|w| w.set_hsebyp(mode(oscillator) == HseMode::Bypass));
    RCC.cr().modify(|w| w.set_hseon(true));
    (0..HSE_LOOKS).any(|_| RCC.cr().read().hserdy())
}

/// Switches on prefetch and both caches of the flash, empty: at 168 MHz it takes 5 wait states. The HAL's init writes ACR
/// and leaves them off.
pub fn accelerate() {
    FLASH.acr().modify(|w| {
        w.set_icrst(true);
        w.set_dcrst(true);
    });
    FLASH.acr().modify(|w| {
        w.set_icrst(false);
        w.set_dcrst(false);
        w.set_prften(can_prefetch());
        w.set_icen(true);
        w.set_dcen(true);
    });
}

/// Fault of the clock tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ClockFault {
    /// HSE is not ready any more.
    #[error("HSE is not ready any more")]
    Oscillator,
    /// SYSCLK comes from elsewhere than the PLL of HSE.
    #[error("SYSCLK comes from elsewhere than the PLL of HSE")]
    Source,
    /// Wrong number of core cycles in 10 ms of the uptime; a hundredth of HCLK is expected.
    #[error("{0} core cycles in 10 ms")]
    Rate(u32),
}

/// Checks that SYSCLK is the PLL of HSE, and compares the core's clock with the timer of the uptime. Both derive from
/// one oscillator, so an error of its frequency needs an instrument. Call it after `Board::new`, which starts SysTick.
///
/// # Errors
/// [`ClockFault`].
pub fn check_clock<B: BoardSpec>() -> Result<(), ClockFault> {
    const TIME: Duration = Duration::from_millis(10);
    let expected = B::HCLK / 100;
    // The timer has a resolution of a microsecond, and an interrupt may occur in between.
    let tolerance = expected / 100;
    if !RCC.cr().read().hserdy() {
        return Err(ClockFault::Oscillator);
    }
    if RCC.cfgr().read().sws() != Sysclk::PLL1_P || RCC.pllcfgr().read().pllsrc() != PllSource::HSE {
        return Err(ClockFault::Source);
    }
    // Bounded by the number of reads: the uptime may stand still.
    let begin = (SYST::get_current(), Uptime.now());
    let is_over = (0..expected).any(|_| Uptime.now().since(begin.1) >= TIME);
    let (begin, end) = (begin.0, SYST::get_current());
    // SysTick counts down and restarts at its reload value.
    let cycles = if end <= begin { begin - end } else { begin + SYST::get_reload() + 1 - end };
    let is_right = is_over && cycles.abs_diff(expected) <= tolerance;
    if is_right { Ok(()) } else { Err(ClockFault::Rate(cycles)) }
}

/// Returns BOR_LEV of the option bytes, 0 to 3: 3 is off, 0 the highest threshold.
pub fn brown_out_level() -> u8 {
    FLASH.optcr().read().bor_lev()
}

/// Returns whether the prefetch works. It does not in an F405 of revision A, which reports the DEV_ID 411h (ES0182).
fn can_prefetch() -> bool {
    const STM32F20X: u16 = 0x411;
    const STM32F405: u16 = 0x413;
    const REVISION_A: u16 = 0x1000;
    let identity = DBGMCU.idcode().read();
    match identity.dev_id() {
        STM32F20X => false,
        STM32F405 => identity.rev_id() != REVISION_A,
        _ => true,
    }
}

/// Safe state of a board without oscillator: both controllers stay in reset, off their pins, and the LEDs light in
/// turn. HSE is started again at each turn until it runs. The HAL is not started.
fn wait_for_oscillator(leds: [Peri<'static, AnyPin>; 2]) {
    // TIM2 first is the time of the log, which stays at zero, and then times the LEDs.
    RCC.apb1enr().modify(|w| w.set_tim2en(true));
    error!("HSE does not start: staying off both buses");
    TIM2.psc().write_value(MILLISECOND);
    TIM2.arr().write_value(TURN);
    TIM2.cr1().write(|w| w.set_cen(true));
    for led in &leds {
        // One bit for each port, beginning with port A.
        RCC.ahb1enr().modify(|w| w.0 |= 1 << led.port());
    }
    let [mut first, mut second] = leds.map(dark);
    first.set_high();
    while !RCC.cr().read().hserdy() {
        // Starts a crystal again that did not begin to oscillate.
        RCC.cr().modify(|w| w.set_hseon(false));
        RCC.cr().modify(|w| w.set_hseon(true));
        while !TIM2.sr().read().uif() {}
        TIM2.sr().write(|_| ());
        first.toggle();
        second.toggle();
    }
    warn!("HSE has started late");
    // Resets TIM2: the time driver uses it from here on.
    RCC.apb1rstr().modify(|w| w.set_tim2rst(true));
    RCC.apb1rstr().modify(|w| w.set_tim2rst(false));
    RCC.apb1enr().modify(|w| w.set_tim2en(false));
}
