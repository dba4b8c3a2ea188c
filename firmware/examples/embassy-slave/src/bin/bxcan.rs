//! CANopen slave 3 at 1 Mbit/s on CAN1 of a pyboard v1.1 (PB8, PB9), by the CAN driver of embassy-stm32.

#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use defmt_rtt as _;
use ecss_can::link::adapter::Adapter;
use ecss_can::od::VisibleString;
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use embassy_ports::{Board, Bxcan, Uptime};
use embassy_stm32::can::{
    Can, Rx0InterruptHandler, Rx1InterruptHandler, SceInterruptHandler, TxInterruptHandler,
};
use embassy_stm32::peripherals::CAN1;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, bind_interrupts};
use panic_probe as _;

bind_interrupts!(struct Irqs {
    CAN1_TX => TxInterruptHandler<CAN1>;
    CAN1_RX0 => Rx0InterruptHandler<CAN1>;
    CAN1_RX1 => Rx1InterruptHandler<CAN1>;
    CAN1_SCE => SceInterruptHandler<CAN1>;
});

/// Heater that its master commands by SDO or PDO.
#[derive(Debug, Objects)]
#[objects(device)]
struct Heater {
    /// Power in percent
    #[object(0x6000, rww, pdo, high = 100)]
    power: u8,
    /// Temperature in units of 0.1 °C
    #[object(0x6001, ro, pdo, default = 200)]
    temperature: i16,
    /// Note of the operator
    #[object(0x6002, rw)]
    note: VisibleString<200>,
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(
        &[Rpdo::new(1, CobIdOf::node(0x200)).map(Heater::POWER)],
        &[Tpdo::new(1, CobIdOf::node(0x180)).map(Heater::TEMPERATURE)],
    );
}

type Node = CanopenSlave<Heater>;

static NODE: Single<Board<Bxcan>, Node> = Single::new();
static DIAGNOSTICS: Diagnostics = Diagnostics::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_stm32::init(clocks());
    let mut can = Can::new(p.CAN1, p.PB8, p.PB9, Irqs);
    can.set_bitrate(1_000_000);
    let port = Adapter::new(Bxcan::new(can));
    let slave = || CanopenSlave::new(NodeId::of::<3>(), &Profile::DEFAULT, Heater::default());
    let (slave, mut events, runners) = NODE.start(slave, port, Uptime, &DIAGNOSTICS);
    spawner.spawn(bus(runners.bus).unwrap());
    spawner.spawn(due(runners.due).unwrap());
    loop {
        match events.next().await {
            SlaveEvent::ResetNode => cortex_m::peripheral::SCB::sys_reset(),
            SlaveEvent::State(state) => defmt::info!("state {}", state),
            // The heater warms its surroundings at once: 0.1 °C for each percent. The change sends the PDO.
            SlaveEvent::Pdo { .. } | SlaveEvent::Written(_) => {
                slave.change(|heater| heater.temperature = 200 + i16::from(heater.power));
            }
            _ => {}
        }
    }
}

#[embassy_executor::task]
async fn bus(runner: BusRunner<Board<Bxcan>, Node>) {
    runner.run().await
}

#[embassy_executor::task]
async fn due(runner: DueRunner<Board<Bxcan>, Node>) {
    runner.run().await
}

/// 168 MHz from the crystal of 12 MHz, APB1 at 42 MHz.
fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz::mhz(12), mode: HseMode::Oscillator });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::DIV6,
        mul: PllMul::MUL168,
        divp: Some(PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config
}
