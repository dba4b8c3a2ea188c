//! CANopen slave 3 at 1 Mbit/s on a driver of `embedded_can::nb`, polled: on CAN1 of a pyboard v1.1 (PB8, PB9).

#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use async_canopen::link::adapter::{Adapter, Nonblocking, WakeUp};
use async_canopen::prelude::*;
use async_canopen::runner::Clock;
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_ports::{Board, Uptime};
use embassy_slave::{Heater, clocks};
use embassy_stm32::bind_interrupts;
use embassy_stm32::can::enums::TryReadError;
use embassy_stm32::can::filter::Mask32;
use embassy_stm32::can::{
    self, Can, Fifo, Rx0InterruptHandler, Rx1InterruptHandler, SceInterruptHandler, TxInterruptHandler,
};
use embassy_stm32::peripherals::CAN1;
use embassy_time::{Duration, Ticker};
use embedded_can::ErrorKind;
use panic_probe as _;

bind_interrupts!(struct Irqs {
    CAN1_TX => TxInterruptHandler<CAN1>;
    CAN1_RX0 => Rx0InterruptHandler<CAN1>;
    CAN1_RX1 => Rx1InterruptHandler<CAN1>;
    CAN1_SCE => SceInterruptHandler<CAN1>;
});

/// A driver that has only the two methods of the trait. It represents the driver of any chip.
struct Plain(Can<'static>);

impl embedded_can::nb::Can for Plain {
    type Frame = can::Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &can::Frame) -> nb::Result<Option<can::Frame>, ErrorKind> {
        let status = self.0.try_write(frame).map_err(|_| nb::Error::WouldBlock)?;
        Ok(status.dequeued_frame().copied())
    }

    fn receive(&mut self) -> nb::Result<can::Frame, ErrorKind> {
        match self.0.try_read() {
            Ok(envelope) => Ok(envelope.frame),
            Err(TryReadError::Empty) => Err(nb::Error::WouldBlock),
            Err(TryReadError::BusError(_)) => Err(nb::Error::Other(ErrorKind::Other)),
        }
    }
}

type Port = Nonblocking<Plain>;
type Node = CanopenSlave<Heater>;

static NODE: Single<Board<Port>, Node> = Single::new();
static DIAGNOSTICS: Diagnostics = Diagnostics::new();
static CAN: WakeUp = WakeUp::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_stm32::init(clocks());
    let mut can = Can::new(p.CAN1, p.PB8, p.PB9, Irqs);
    can.modify_filters().clear().enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
    can.set_bitrate(1_000_000);
    can.enable().await;
    let port = Adapter::new(Nonblocking::new(Plain(can), &CAN, || Uptime.now()));
    let slave = || CanopenSlave::new(NodeId::of::<3>(), &Settings::DEFAULT, Heater::default());
    let (slave, mut events, runners) =
        NODE.start(slave, Connection { ports: port, clock: Uptime }, &DIAGNOSTICS);
    spawner.spawn(bus(runners.bus).unwrap());
    spawner.spawn(due(runners.due).unwrap());
    spawner.spawn(poll().unwrap());
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

/// Polls in place of interrupts. The controller stores three frames, which take at least 141 µs.
#[embassy_executor::task]
async fn poll() {
    let mut ticker = Ticker::every(Duration::from_micros(140));
    loop {
        ticker.next().await;
        CAN.notify();
    }
}

#[embassy_executor::task]
async fn bus(runner: BusRunner<Board<Port>, Node>) {
    runner.run().await
}

#[embassy_executor::task]
async fn due(runner: DueRunner<Board<Port>, Node>) {
    runner.run().await
}
