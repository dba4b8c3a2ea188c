//! Start of the thermometer: board, node, tasks, and the sensor on I2C1.

use board::Spec;
use ecss_can::prelude::*;
use ecss_can_stm32f4::{DIAGNOSTICS, supervised};
use embassy_executor::Spawner;
use embassy_stm32::i2c::{self, ErrorInterruptHandler, EventInterruptHandler, I2c};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH5, DMA1_CH6, I2C1};
use embassy_stm32::{bind_interrupts, dma};
use embassy_time::{Duration, with_timeout};
use thermometer::{Hardware, LM75, PROFILE, Thermometer, application, slave};

bind_interrupts!(struct Irqs {
    I2C1_EV => EventInterruptHandler<I2C1>;
    I2C1_ER => ErrorInterruptHandler<I2C1>;
    DMA1_STREAM5 => dma::InterruptHandler<DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
});

type Node = Slave<Thermometer>;

type Board = ecss_can_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

ecss_can_runtime::node_tasks!(fn spawn_node(Board, Node));

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = ecss_can_stm32f4::start::<Spec>();
    let bit_timing = const { ecss_can_stm32f4::bit_timing(&PROFILE.network) };
    let board = Board::new(board::take!(p), bit_timing, ecss_can_runtime::Irqs);
    let Ok(id) = board.node_id else { return defmt::error!("no valid Node-ID on the straps") };
    let slave = || slave(id, board.memory.split_at_mut(2048).0).hardware(board.hardware).build();
    let (slave, events, runners) = RESOURCES.start(slave, board.connection, &DIAGNOSTICS);
    spawn_node(spawner, runners);
    // The board uses neither I2C1 nor its pins.
    let i2c = I2c::new(p.I2C1, p.PB6, p.PB7, p.DMA1_CH6, p.DMA1_CH5, Irqs, Default::default());
    supervised("application", application(slave, events, Sensor(i2c))).await
}

/// An LM75.
struct Sensor(I2c<'static, Async, i2c::Master>);

impl Hardware for Sensor {
    async fn temperature(&mut self) -> Option<i16> {
        let mut register = [0; 2];
        // Without a sensor the lines stay low, and a START never ends.
        let read = self.0.write_read(LM75, &[0], &mut register);
        let read = with_timeout(Duration::from_millis(5), read).await;
        matches!(read, Ok(Ok(()))).then(|| i16::from_be_bytes(register))
    }

    fn log_command(&mut self, highest: i16) {
        defmt::info!("commanded; highest temperature: {=i16} tenths of a degree", highest);
    }

    fn reset(&mut self) {
        ecss_can_stm32f4::reset()
    }
}
