//! Board, tasks, and the application: measures ten times a second.

use boards::{Board, TELLTALE};
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_stm32::adc::{Adc, SampleTime};
use embassy_time::{Duration, Ticker};
use thermometer::{CHANGE, COMMAND, PROFILE, Thermometer, slave};

type Node = Slave<Thermometer>;

static RESOURCES: Resources<Board, Node> = Resources::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let board = Board::new(boards::take!(p), const { boards::bit_timing(&PROFILE.network) });
    let Ok(id) = board.node_id else { return defmt::error!("no valid Node-ID on the straps") };
    let (table, _) = board.memory.split_at_mut(2048);
    let slave = || {
        let slave = slave(id, table).with_retained(board.retained);
        if let Some(store) = board.store { slave.with_store(store) } else { slave }
    };
    let (slave, mut events, runners) = RESOURCES.start(slave, board.ports, board.clock, &TELLTALE);
    spawner.spawn(bus(runners.nominal).unwrap());
    spawner.spawn(bus(runners.redundant).unwrap());
    spawner.spawn(due(runners.due).unwrap());

    // The board has not taken the converter.
    let mut adc = Adc::new(p.ADC1);
    let mut sensor = adc.enable_temperature();
    let mut ticker = Ticker::every(Duration::from_millis(100));
    loop {
        let code = adc.blocking_read(&mut sensor, SampleTime::CYCLES480);
        slave.change(|thermometer| thermometer.measured(code));
        while let Either::First(event) = select(events.next(), ticker.next()).await {
            on_event(slave, event);
        }
    }
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
        SlaveEvent::ResetNode => boards::reset(),
        _ => {}
    }
}

#[embassy_executor::task(pool_size = 2)]
async fn bus(runner: BusRunner<Board, Node>) -> ! {
    runner.run().await
}

#[embassy_executor::task]
async fn due(runner: DueRunner<Board, Node>) -> ! {
    runner.run().await
}
