//! Board, tasks, and the application: measures ten times a second.

use board::Spec;
use boards_stm32f4::{DIAGNOSTICS, supervised};
use ecss_can::emcy::ErrorCode;
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_stm32::i2c::{ErrorInterruptHandler, EventInterruptHandler, I2c};
use embassy_stm32::peripherals::{DMA1_CH5, DMA1_CH6, I2C1};
use embassy_stm32::{bind_interrupts, dma};
use embassy_time::{Duration, Ticker, with_timeout};
use thermometer::{CHANGE, COMMAND, LM75, PROFILE, Thermometer, slave};

bind_interrupts!(struct Irqs {
    I2C1_EV => EventInterruptHandler<I2C1>;
    I2C1_ER => ErrorInterruptHandler<I2C1>;
    DMA1_STREAM5 => dma::InterruptHandler<DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
});

type Node = Slave<Thermometer>;

type Board = boards_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

boards_runtime::node_tasks!(Board, Node);

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    let bit_timing = const { boards_stm32f4::bit_timing(&PROFILE.network) };
    let board = Board::new(board::take!(p), bit_timing, boards_runtime::Irqs);
    let Ok(id) = board.node_id else { return defmt::error!("no valid Node-ID on the straps") };
    let slave = || {
        let slave = slave(id, board.memory.split_at_mut(2048).0).with_retained(board.retained);
        let slave = slave.with_late_heartbeats(Board::late_heartbeats());
        if let Some(store) = board.store { slave.with_store(store) } else { slave }
    };
    let (slave, mut events, runners) = RESOURCES.start(slave, board.ports, board.clock, &DIAGNOSTICS);
    slave.with(|slave, _| slave.set_post_mortem(board.post_mortem));
    spawn_node(spawner, runners);
    // The board has taken neither I2C1 nor its pins. Lines without a sensor stay low: then no START ever ends.
    let mut i2c = I2c::new(p.I2C1, p.PB6, p.PB7, p.DMA1_CH6, p.DMA1_CH5, Irqs, Default::default());
    let mut ticker = Ticker::every(Duration::from_millis(100));
    let application = async {
        loop {
            let mut register = [0; 2];
            let read =
                with_timeout(Duration::from_millis(5), i2c.write_read(LM75, &[0], &mut register)).await;
            let register = matches!(read, Ok(Ok(()))).then(|| i16::from_be_bytes(register));
            slave.change(|thermometer| thermometer.measured(register));
            slave.with(|slave, _| match register {
                Some(_) => slave.clear(ErrorCode::HARDWARE, LM75),
                None => slave.raise(ErrorCode::HARDWARE, [LM75, 0, 0, 0, 0]),
            });
            while let Either::First(event) = select(events.next(), ticker.next()).await {
                on_event(slave, event);
            }
        }
    };
    supervised("application", application).await
}

fn on_event(slave: Handle<Board, Node>, event: SlaveEvent) {
    match event {
        SlaveEvent::Pdo { number, .. } if usize::from(number) == COMMAND.slot() => {
            let highest = slave.change(Thermometer::obey);
            defmt::info!("commanded; highest temperature: {=i16} tenths of a degree", highest);
        }
        // Whoever hears the changes knows from now on.
        SlaveEvent::State(NmtState::Operational) => {
            slave.with(|slave, now| slave.send_pdo(CHANGE.slot(), now));
        }
        SlaveEvent::ResetNode => boards_stm32f4::reset(),
        _ => {}
    }
}
