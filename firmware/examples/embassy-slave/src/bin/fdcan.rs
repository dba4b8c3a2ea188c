//! Heater, slave 3 at 250 kbit/s, on FDCAN1 of a NUCLEO-G474RE (PA11, PA12) or NUCLEO-H743ZI (PD0, PD1).
#![cfg_attr(target_os = "none", no_std, no_main)]
use async_canopen::{link::adapter::Adapter, prelude::*};
use embassy_executor::{Spawner, main, task};
use embassy_ports::{Board, Fdcan, Uptime};
use embassy_stm32::can::{CanConfigurator, IT0InterruptHandler, IT1InterruptHandler};
use embassy_stm32::rcc::{Hse, HseMode::*};
use embassy_stm32::{Config, bind_interrupts, peripherals::FDCAN1, time::Hertz};
use {defmt_rtt as _, panic_probe as _};
bind_interrupts!(struct Irqs {
    FDCAN1_IT0 => IT0InterruptHandler<FDCAN1>;
    FDCAN1_IT1 => IT1InterruptHandler<FDCAN1>;
});
#[derive(Debug, Objects)]
#[objects(device)]
struct Heater {
    /// Power in percent
    #[object(0x6000, rww, pdo, high = 100)]
    power: u8,
}
const COMMAND: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x200)).map(Heater::POWER);
impl Device for Heater {
    type Pdos = PdoObjects<1, 0>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[COMMAND.receive(1)], &[]);
}
type Node = CanopenSlave<Heater>;
static NODE: Single<Board<Fdcan>, Node> = Single::new();
static DIAGNOSTICS: Diagnostics = Diagnostics::new();
#[main]
async fn main(spawner: Spawner) {
    let (freq, mode) = if cfg!(feature = "nucleo-g474re") { (24, Oscillator) } else { (8, Bypass) };
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz::mhz(freq), mode });
    let p = embassy_stm32::init(config);
    #[cfg(feature = "nucleo-g474re")]
    let mut can = CanConfigurator::new(p.FDCAN1, p.PA11, p.PA12, Irqs);
    #[cfg(feature = "nucleo-h743zi")]
    let mut can = CanConfigurator::new(p.FDCAN1, p.PD0, p.PD1, Irqs);
    can.set_bitrate(250_000);
    let slave = || CanopenSlave::new(NodeId::of::<3>(), &Settings::DEFAULT, Heater::default());
    let connection = Connection { ports: Adapter::new(Fdcan::new(can)), clock: Uptime };
    let (slave, mut events, runners) = NODE.start(slave, connection, &DIAGNOSTICS);
    spawner.spawn(bus(runners.bus).unwrap());
    spawner.spawn(due(runners.due).unwrap());
    loop {
        match events.next().await {
            Event::ResetNode => cortex_m::peripheral::SCB::sys_reset(),
            _ => defmt::info!("power {} %", slave.read(|heater| heater.power)),
        }
    }
}
#[task]
async fn bus(runner: BusRunner<Board<Fdcan>, Node>) {
    runner.run().await
}
#[task]
async fn due(runner: DueRunner<Board<Fdcan>, Node>) {
    runner.run().await
}
