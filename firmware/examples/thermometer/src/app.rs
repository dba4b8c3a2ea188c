//! Board, tasks, and the application: measures ten times a second.

use boards::{Board, Port, TELLTALE, Uptime};
use core::convert::Infallible;
use ecss_can::link::bit_timing::BitTiming;
use ecss_can::link::port::CanPort;
use ecss_can::node::{Slave, SlaveEvent};
use ecss_can::runner::{AppLink, NodeCell, bus_task, node_task};
use ecss_can::time::Clock;
use ecss_can::types::Bus;
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_stm32::adc::{Adc, SampleTime};
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::once_lock::OnceLock;
use embassy_time::{Duration, Ticker};
use thermometer::{COMMAND, PROFILE, Thermometer, slave};

const BIT_TIMING: BitTiming = boards::bit_timing(&PROFILE.network);

type Node = NodeCell<ThreadModeRawMutex, Slave<Thermometer>>;

static NODE: OnceLock<Node> = OnceLock::new();
static LINK: AppLink<ThreadModeRawMutex, SlaveEvent, Infallible> = AppLink::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards::start();
    let board = Board::new(boards::take!(p), BIT_TIMING);
    let Ok(id) = board.node_id else { return defmt::error!("no valid Node-ID on the straps") };
    let (table, _) = board.memory.split_at_mut(2048);
    let mut slave = slave(id, table).with_retained(board.retained);
    if let Some(store) = board.store {
        slave = slave.with_store(store);
    }
    let (filters, mut ports) = (slave.filters(), board.ports);
    Bus::ALL.into_iter().for_each(|bus| ports[bus].set_filters(&filters));
    let node = NODE.get_or_init(|| NodeCell::new(slave));
    spawner.spawn(bus(Bus::Nominal, ports.nominal, node).expect("spawned once"));
    spawner.spawn(bus(Bus::Redundant, ports.redundant, node).expect("spawned once"));
    spawner.spawn(due(node).expect("spawned once"));

    // The board has not taken the converter.
    let mut adc = Adc::new(p.ADC1);
    let mut sensor = adc.enable_temperature();
    let mut ticker = Ticker::every(Duration::from_millis(100));
    loop {
        match select(LINK.events.receive(), ticker.next()).await {
            Either::First(event) => on_event(node, event),
            Either::Second(()) => {
                let code = adc.blocking_read(&mut sensor, SampleTime::CYCLES480);
                measured(node, code);
            }
        }
    }
}

fn measured(node: &Node, code: u16) {
    node.with(|slave| {
        let objects = &mut slave.objects_mut().application;
        let before = (objects.temperature, objects.alarm);
        objects.measured(code);
        if (objects.temperature, objects.alarm) != before {
            slave.changed(Thermometer::TEMPERATURE.address(), Uptime.now());
        }
    });
}

fn on_event(node: &Node, event: SlaveEvent) {
    match event {
        SlaveEvent::Pdo { number, .. } if usize::from(number) == COMMAND.slot() => {
            node.with(|slave| slave.objects_mut().application.obey());
        }
        SlaveEvent::State(state) => defmt::info!("{}", state),
        SlaveEvent::ResetNode => boards::reset(),
        _ => {}
    }
}

#[embassy_executor::task(pool_size = 2)]
async fn bus(bus: Bus, port: Port, node: &'static Node) -> ! {
    match bus_task(bus, port, Uptime, node, &LINK, &TELLTALE).await {}
}

#[embassy_executor::task]
async fn due(node: &'static Node) -> ! {
    match node_task(node, Uptime, &LINK, &TELLTALE).await {}
}
