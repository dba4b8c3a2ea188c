//! Device and clocks of the slaves on bxCAN. The slave on FDCAN is whole in its file.

#![cfg_attr(target_os = "none", no_std)]
#![forbid(unsafe_code)]

use async_canopen::od::VisibleString;
use async_canopen::prelude::*;
#[cfg(all(target_os = "none", feature = "bxcan"))]
use embassy_stm32::{Config, rcc, time::Hertz};

/// Heater that its master commands by SDO or PDO.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Heater {
    /// Power in percent
    #[object(0x6000, rww, pdo, high = 100)]
    pub power: u8,
    /// Temperature in units of 0.1 °C
    #[object(0x6001, ro, pdo, default = 200)]
    pub temperature: i16,
    /// Note of the operator
    #[object(0x6002, rw)]
    pub note: VisibleString<200>,
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(
        &[Rpdo::new(1, CobIdOf::node(0x200)).map(Heater::POWER)],
        &[Tpdo::new(1, CobIdOf::node(0x180)).map(Heater::TEMPERATURE)],
    );
}

impl Heater {
    /// The heater warms its surroundings at once: 0.1 °C for each percent.
    pub fn heat(&mut self) {
        self.temperature = 200 + i16::from(self.power);
    }
}

/// Clocks of a pyboard: 168 MHz from the crystal of 12 MHz, APB1 at 42 MHz.
#[cfg(all(target_os = "none", feature = "bxcan"))]
pub fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(rcc::Hse { freq: Hertz::mhz(12), mode: rcc::HseMode::Oscillator });
    config.rcc.pll_src = rcc::PllSource::HSE;
    config.rcc.pll = Some(rcc::Pll {
        prediv: rcc::PllPreDiv::DIV6,
        mul: rcc::PllMul::MUL168,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    config
}
