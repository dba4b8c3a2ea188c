//! The task of a bus without a node: what the size of [CANopen](../canopen.rs) is counted from.

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
    use core::convert::Infallible;

    use board::Spec;
    use boards_runtime::Irqs;
    use boards_stm32f4::{TELLTALE, supervised};
    use ecss_can::node::{Filters, LinkEvent, Outbox, Usual};
    use ecss_can::prelude::*;
    use embassy_executor::Spawner;

    /// Joins its bus and lets all frames pass.
    struct NoNode;

    impl Node for NoNode {
        type Event = SlaveEvent;
        type Request = Infallible;
        type Depth = Usual;

        fn filters(&self) -> Filters {
            Filters::new()
        }

        fn start(&mut self, _: Instant, _: &mut Outbox<SlaveEvent>) {}

        fn on_link(&mut self, _: Bus, _: &LinkEvent, _: Instant, _: &mut Outbox<SlaveEvent>) {}

        fn on_request(&mut self, request: Infallible, _: Instant, _: &mut Outbox<SlaveEvent>) {
            match request {}
        }

        fn poll(&mut self, _: Instant, _: &mut Outbox<SlaveEvent>) {}

        fn deadline(&self) -> Option<Instant> {
            None
        }

        fn is_stamped(&self, _: Bus, _: &Frame) -> bool {
            false
        }
    }

    type Board = boards_stm32f4::Board<Spec>;

    static NODE: Single<Board, NoNode> = Single::new();

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let p = boards_stm32f4::start::<Spec>();
        let Board { ports, clock, node_id, .. } = Board::new(
            board::take!(p),
            const { boards_stm32f4::bit_timing(&Profile::DEFAULT.network) },
            Irqs,
        );
        let Ok(_) = node_id else { return };
        let (_, mut events, runners) = NODE.start(|| NoNode, ports.nominal, clock, &TELLTALE);
        spawner.spawn(bus(runners.bus).unwrap());
        loop {
            if let SlaveEvent::ResetNode = events.next().await {
                boards_stm32f4::reset()
            }
        }
    }

    #[embassy_executor::task]
    fn bus(runner: BusRunner<Board, NoNode>) -> impl Future<Output = ()> {
        supervised("bus", runner.run())
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is firmware whose size is measured:  cargo xtask bench --only size");
}
