//! What `boards-runtime` does for other images, and a small slave.

use core::panic::PanicInfo;

use board::Spec;
use boards_stm32f4::exceptions::{on_panic, on_tick};
use boards_stm32f4::{ReceiveHandler, StatusHandler, TELLTALE, TransmitHandler, supervised};
use cortex_m_rt::exception;
use ecss_can::prelude::*;
use embassy_executor::Spawner;
use embassy_stm32::{bind_interrupts, peripherals};

bind_interrupts!(struct Irqs {
    CAN1_TX => TransmitHandler<peripherals::CAN1>;
    CAN1_RX0 => ReceiveHandler<peripherals::CAN1>;
    CAN1_SCE => StatusHandler<peripherals::CAN1>;
    CAN2_TX => TransmitHandler<peripherals::CAN2>;
    CAN2_RX0 => ReceiveHandler<peripherals::CAN2>;
    CAN2_SCE => StatusHandler<peripherals::CAN2>;
});

#[exception]
fn SysTick() {
    on_tick(None, |_| ());
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    on_panic(|_| ())
}

/// A lamp that a command can break.
#[derive(Debug, Objects)]
#[objects(device)]
struct Lamp {
    /// Brightness
    ///
    /// 200 is the highest. More ends the program by a panic.
    #[object(0x6000, rw)]
    brightness: u8,
}

impl Device for Lamp {
    type Pdos = PdoObjects<4, 4>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[SPACECRAFT_TIME], &[LOCAL_TIME]);
}

type Node = Slave<Lamp>;
type Board = boards_stm32f4::Board<Spec>;

static RESOURCES: Resources<Board, Node> = Resources::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = boards_stm32f4::start::<Spec>();
    let timing = const { boards_stm32f4::bit_timing(&Profile::DEFAULT.network) };
    let board = Board::new(board::take!(p), timing, Irqs);
    let Ok(id) = board.node_id else { return };
    let slave = || {
        let slave = Slave::new(id, &Profile::DEFAULT, Lamp::default());
        slave.with_retained(board.retained).with_store(board.store)
    };
    let (slave, mut events, runners) = RESOURCES.start(slave, board.ports, board.clock, &TELLTALE);
    slave.with(|slave, _| slave.set_post_mortem(board.post_mortem));
    spawner.spawn(bus(runners.nominal).unwrap());
    spawner.spawn(bus(runners.redundant).unwrap());
    spawner.spawn(due(runners.due).unwrap());
    let application = async {
        loop {
            match events.next().await {
                SlaveEvent::Written(at) if at == Lamp::BRIGHTNESS.address() => {
                    slave.change(|lamp| assert!(lamp.brightness <= 200, "too bright"));
                }
                SlaveEvent::ResetNode => boards_stm32f4::reset(),
                _ => {}
            }
        }
    };
    supervised("application", application).await
}

#[embassy_executor::task(pool_size = 2)]
fn bus(runner: BusRunner<Board, Node>) -> impl Future<Output = ()> {
    supervised("bus", runner.run())
}

#[embassy_executor::task]
fn due(runner: DueRunner<Board, Node>) -> impl Future<Output = ()> {
    supervised("due", runner.run())
}
