//! A master and a slave on a mock bus, in virtual time: no executor, no hardware.
//! Run it: `cargo run -p ecss-can --example two_nodes`

use ecss_can::link::Stamp;
use ecss_can::node::extend::{BusCommand, LinkEvent, Outbox, Turn};
use ecss_can::prelude::*;

const COUNTER: NodeId = NodeId::of::<3>();

/// A clock that counts SYNCs.
#[derive(Debug, Objects)]
#[objects(device)]
struct Counter {
    /// Count
    #[object(0x6000, ro, pdo)]
    count: u32,
}

impl Device for Counter {
    type Pdos = PdoObjects<0, 1>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[], &[COUNT.transmit(1).transmission(1)]);
}

/// Its count with every SYNC: 280h + node.
const COUNT: Pdo<Counter, (u32,)> = Pdo::new(CobIdOf::node(0x280)).map(Counter::COUNT);

/// Its reader, which has no objects.
#[derive(Debug, Objects)]
#[objects(device)]
struct Display {}

impl Device for Display {
    type Pdos = PdoObjects<1, 0>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[COUNT.of(COUNTER).receive(1)], &[]);
}

/// A node on both buses.
struct Board<N: Node> {
    node: N,
    out: Outbox<N::Event, N::Depth>,
}

impl<N: Node> Board<N> {
    fn new(mut node: N) -> Self {
        let mut out = Outbox::new();
        node.start(&mut Turn::new(Instant::ZERO, &mut out));
        Board { node, out }
    }
    /// Does what is due; the next frame that it sends goes out at once.
    fn step(&mut self, now: Instant) -> Option<(Bus, Frame)> {
        self.node.poll(&mut Turn::new(now, &mut self.out));
        while let Some((bus, command)) = self.out.pop_command() {
            if let BusCommand::Send(outgoing) = command {
                let (frame, stamp) = (outgoing.frame, Stamp::interrupt(now));
                let event = LinkEvent::Transmitted { frame, stamp };
                self.node.on_link(bus, &event, &mut Turn::new(now, &mut self.out));
                return Some((bus, frame));
            }
        }
        None
    }
    fn receive(&mut self, (bus, frame): (Bus, Frame), now: Instant) {
        self.node.on_received(bus, &frame, &Stamp::interrupt(now), &mut Turn::new(now, &mut self.out));
    }
}

fn main() {
    let mut slave = Board::new(Slave::builder(COUNTER, &Profile::DEFAULT, Counter::default()).build());
    let mut master = Board::new(Master::builder(&Profile::DEFAULT, Display::default()).build());
    let (mut now, mut heard) = (Instant::ZERO, vec![]);
    while now < Instant::from_micros(1_050_000) {
        while let Some(sent) = master.step(now) {
            slave.receive(sent, now);
        }
        while let Some(sent) = slave.step(now) {
            master.receive(sent, now);
        }
        while let Some(event) = slave.out.pop_event() {
            if matches!(event, SlaveEvent::Sync { .. }) {
                slave.node.change(now, |counter| counter.count += 1);
            }
        }
        while let Some(event) = master.out.pop_event() {
            if let MasterEvent::Pdo(pdo) = event {
                heard.push(pdo.data[0]);
            }
        }
        now += Duration::from_micros(100);
    }
    assert_eq!(heard[..8], [0, 1, 2, 3, 4, 5, 6, 7], "started by the master, a count with every SYNC");
}

#[test]
fn it_runs() {
    main();
}
