//! A port over embassy's bxCAN driver in each of its modes, for a test. Runs on CAN1 of a pyboard v1.1 (PB8, PB9) at 1
//! Mbit/s.
//!
//! The port is off its bus until 10 ms after the start, on it until 20 ms, off it until 30 ms, listens until 40 ms, and
//! is on the bus from then on. At 50 ms it leaves and joins in one step. It logs received frames, and sends a frame
//! when it joins.

#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use async_canopen::link::adapter::Adapter;
use async_canopen::link::port::{CanPort, Filter, PortEvent};
use async_canopen::types::{CobId, Frame};
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_ports::Bxcan;
use embassy_slave::clocks;
use embassy_stm32::bind_interrupts;
use embassy_stm32::can::{
    Can, Rx0InterruptHandler, Rx1InterruptHandler, SceInterruptHandler, TxInterruptHandler,
};
use embassy_stm32::peripherals::CAN1;
use embassy_time::{Instant, Timer};
use panic_probe as _;

bind_interrupts!(struct Irqs {
    CAN1_TX => TxInterruptHandler<CAN1>;
    CAN1_RX0 => Rx0InterruptHandler<CAN1>;
    CAN1_RX1 => Rx1InterruptHandler<CAN1>;
    CAN1_SCE => SceInterruptHandler<CAN1>;
});

type Port = Adapter<Bxcan>;

fn join(port: &mut Port) {
    port.join();
    let sent = port.send(&Frame::of(CobId::SYNC, []));
    defmt::assert!(sent.is_ok());
}

fn rejoin(port: &mut Port) {
    port.leave();
    join(port);
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_stm32::init(clocks());
    let mut can = Can::new(p.CAN1, p.PB8, p.PB9, Irqs);
    can.set_bitrate(1_000_000);
    let mut port = Adapter::new(Bxcan::new(can));
    port.set_filters(&[Filter::ALL]);
    let steps: [fn(&mut Port); 6] = [|_| (), join, Port::leave, Port::listen, join, rejoin];
    for (step, end) in steps.into_iter().zip((10..).step_by(10)) {
        step(&mut port);
        let end = Instant::from_millis(end);
        while let Either::First(event) = select(port.event(), Timer::at(end)).await {
            match event {
                PortEvent::Received { frame, .. } => defmt::info!("received {:03X}", frame.id().raw()),
                PortEvent::Transmitted { .. } => defmt::info!("sent"),
                PortEvent::Failed { .. } => defmt::info!("failed"),
                _ => {}
            }
        }
    }
}
