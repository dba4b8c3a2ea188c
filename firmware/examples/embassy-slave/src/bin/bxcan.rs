//! CANopen slave 3 at 1 Mbit/s on CAN1 of a pyboard v1.1 (PB8, PB9), by the CAN driver of embassy-stm32.

#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use async_canopen::link::adapter::Adapter;
use async_canopen::prelude::*;
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_ports::{Board, Bxcan, Uptime};
use embassy_slave::{Heater, clocks};
use embassy_stm32::bind_interrupts;
use embassy_stm32::can::{
    Can, Rx0InterruptHandler, Rx1InterruptHandler, SceInterruptHandler, TxInterruptHandler,
};
use embassy_stm32::peripherals::CAN1;
use panic_probe as _;

bind_interrupts!(struct Irqs {
    CAN1_TX => TxInterruptHandler<CAN1>;
    CAN1_RX0 => Rx0InterruptHandler<CAN1>;
    CAN1_RX1 => Rx1InterruptHandler<CAN1>;
    CAN1_SCE => SceInterruptHandler<CAN1>;
});

type Node = CanopenSlave<Heater>;

static NODE: Single<Board<Bxcan>, Node> = Single::new();
static DIAGNOSTICS: Diagnostics = Diagnostics::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_stm32::init(clocks());
    let mut can = Can::new(p.CAN1, p.PB8, p.PB9, Irqs);
    can.set_bitrate(1_000_000);
    let port = Adapter::new(Bxcan::new(can));
    let slave = || CanopenSlave::new(NodeId::of::<3>(), &Settings::DEFAULT, Heater::default());
    let (slave, mut events, runners) =
        NODE.start(slave, Connection { ports: port, clock: Uptime }, &DIAGNOSTICS);
    spawner.spawn(bus(runners.bus).unwrap());
    spawner.spawn(due(runners.due).unwrap());
    loop {
        match events.next().await {
            Event::ResetNode => cortex_m::peripheral::SCB::sys_reset(),
            Event::State(state) => defmt::info!("state {}", state),
            // The update sends the PDO when the value changed.
            Event::Pdo(_) | Event::Written(_) => slave.update(Heater::heat),
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
