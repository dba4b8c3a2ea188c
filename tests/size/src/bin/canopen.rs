//! A CANopen slave on one bus with 4 + 4 PDOs: the services that CANopenNode has, and no more.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

// The board that the image is built for.
#[cfg(all(target_os = "none", feature = "nucleo-f446re"))]
extern crate nucleo_f446re as board;
#[cfg(all(target_os = "none", feature = "pyboard-v11"))]
extern crate pyboard_v11 as board;
#[cfg(all(target_os = "none", feature = "stm32f4discovery"))]
extern crate stm32f4discovery as board;

#[cfg(target_os = "none")]
mod app {
    use board::Spec;
    use boards_runtime::Irqs;
    use boards_stm32f4::{TELLTALE, supervised};
    use ecss_can::prelude::*;
    use embassy_executor::Spawner;

    type Node = CanopenSlave<Channels>;

    /// Four channels in, four out.
    #[derive(Debug, Objects)]
    #[objects(device)]
    struct Channels {
        /// Inputs
        #[object(0x6000, array, ro, pdo)]
        inputs: [u16; 4],
        /// Outputs
        #[object(0x6200, array, rww, pdo)]
        outputs: [u16; 4],
    }

    impl Device for Channels {
        type Pdos = PdoObjects<4, 4>;
        type Consumers = HeartbeatConsumers<1>;

        const PDOS: PdoSet = PdoSet::new(
            &[
                Rpdo::new(1, CobIdOf::node(0x200)).map(Channels::OUTPUTS.sub(1)),
                Rpdo::new(2, CobIdOf::node(0x300)).map(Channels::OUTPUTS.sub(2)),
                Rpdo::new(3, CobIdOf::node(0x400)).map(Channels::OUTPUTS.sub(3)),
                Rpdo::new(4, CobIdOf::node(0x500)).map(Channels::OUTPUTS.sub(4)),
            ],
            &[
                Tpdo::new(1, CobIdOf::node(0x180)).map(Channels::INPUTS.sub(1)),
                Tpdo::new(2, CobIdOf::node(0x280)).map(Channels::INPUTS.sub(2)),
                Tpdo::new(3, CobIdOf::node(0x380)).map(Channels::INPUTS.sub(3)),
                Tpdo::new(4, CobIdOf::node(0x480)).map(Channels::INPUTS.sub(4)),
            ],
        );
    }

    type Board = boards_stm32f4::Board<Spec>;

    static NODE: Single<Board, Node> = Single::new();

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let p = boards_stm32f4::start::<Spec>();
        let Board { ports, clock, node_id, .. } = Board::new(
            board::take!(p),
            const { boards_stm32f4::bit_timing(&Profile::DEFAULT.network) },
            Irqs,
        );
        let Ok(id) = node_id else { return };
        let device = || CanopenSlave::new(id, &Profile::DEFAULT, Channels::default());
        let (_, mut events, runners) = NODE.start(device, ports.nominal, clock, &TELLTALE);
        spawner.spawn(bus(runners.bus).unwrap());
        spawner.spawn(due(runners.due).unwrap());
        loop {
            if let SlaveEvent::ResetNode = events.next().await {
                boards_stm32f4::reset()
            }
        }
    }

    #[embassy_executor::task]
    fn bus(runner: BusRunner<Board, Node>) -> impl Future<Output = ()> {
        supervised("bus", runner.run())
    }

    #[embassy_executor::task]
    fn due(runner: DueRunner<Board, Node>) -> impl Future<Output = ()> {
        supervised("due", runner.run())
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is firmware whose size is measured:  cargo xtask bench --only size");
}
