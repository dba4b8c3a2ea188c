//! Device and clocks of the slaves on bxCAN. The slave on FDCAN is complete in its file.

#![cfg_attr(target_os = "none", no_std)]
#![forbid(unsafe_code)]

use async_canopen::od::{U24, VisibleString};
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
    /// Temperature
    ///
    /// In units of 0.1 °C.
    #[object(0x6001, ro, pdo, default = 200)]
    pub temperature: i16,
    /// Note of the operator
    #[object(0x6002, rw)]
    pub note: VisibleString<200>,
    /// Table of the operator
    ///
    /// It moves by segments or blocks.
    #[object(0x6300, rw)]
    pub table: Domain<[u8; 2048]>,
    /// Values of several types
    ///
    /// What is written can be read back.
    #[object(0x6400, record)]
    pub samples: Samples,
}

/// Values of several types, at the sub-indices that they have in `firmware/fixtures`: conformance cases use them.
#[derive(Clone, Copy, Debug, Record)]
pub struct Samples {
    /// BOOLEAN
    #[sub(1, rw, pdo)]
    pub boolean: bool,
    /// UNSIGNED8
    #[sub(5, rw, pdo)]
    pub unsigned8: u8,
    /// UNSIGNED16
    #[sub(6, rw, pdo)]
    pub unsigned16: u16,
    /// UNSIGNED32
    #[sub(7, rw, pdo)]
    pub unsigned32: u32,
    /// UNSIGNED24
    #[sub(22, rw, pdo)]
    pub unsigned24: U24,
    /// UNSIGNED64
    #[sub(27, rw, pdo)]
    pub unsigned64: u64,
    /// Within limits
    ///
    /// -100 to 100.
    #[sub(28, rw, pdo, low = -100, high = 100)]
    pub limited: i16,
    /// Write-only
    #[sub(29, wo)]
    pub write_only: u8,
}

impl Device for Heater {
    /// The second PDOs are configured by a client.
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<2>;

    const PDOS: PdoSet = PdoSet::new(
        &[Pdo::<Self>::new(CobIdOf::node(0x200)).map(Heater::POWER).receive(1)],
        &[Pdo::<Self>::new(CobIdOf::node(0x180)).map(Heater::TEMPERATURE).transmit(1)],
    );

    fn communication(id: NodeId) -> Communication {
        let identity = Identity { serial: id.get().into(), ..Identity::default() };
        Communication { device_name: "Heater", identity, ..Communication::new(id) }
    }
}

impl Heater {
    /// Sets the temperature from the power: 0.1 °C for each percent, at once.
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
