//! A slave of one's own without any hardware: frames and time go in, frames and events come out.
//!
//!     cargo run -p ecss-can --example slave

use ecss_can::link::Stamp;
use ecss_can::node::extend::{BusCommand, LinkEvent, Outbox, Turn};
use ecss_can::prelude::*;

/// A valve.
#[derive(Debug, Objects)]
#[objects(device)]
struct Valve {
    /// Wanted opening
    ///
    /// Percent.
    #[object(0x6000, rww, pdo, high = 100)]
    wanted: u8,
    /// Opening
    ///
    /// Percent.
    #[object(0x6001, ro, pdo)]
    opening: u8,
}

impl Device for Valve {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;
    /// Receives the wanted value (205h), sends the present one (185h).
    const PDOS: PdoSet = PdoSet::new(
        &[Pdo::<()>::new(CobIdOf::node(0x200)).map(Valve::WANTED).receive(1)],
        &[Pdo::<()>::new(CobIdOf::node(0x180)).map(Valve::OPENING).transmit(1)],
    );
}

/// The valve with its outbox, at a desk.
struct Desk {
    slave: Slave<Valve>,
    out: Outbox<SlaveEvent>,
    now: Instant,
}

impl Desk {
    /// Gives the slave a frame of the nominal bus; what it sends.
    fn receive(&mut self, id: u16, data: &[u8]) -> Vec<(u16, Vec<u8>)> {
        let frame = Frame::new(CobId::new(id).expect("11 bits"), data).expect("8 bytes at most");
        self.slave.on_received(
            Bus::Nominal,
            &frame,
            &Stamp::interrupt(self.now),
            &mut Turn::new(self.now, &mut self.out),
        );
        self.sent()
    }

    /// What the slave has sent since it was asked last. Its application moves the valve.
    fn sent(&mut self) -> Vec<(u16, Vec<u8>)> {
        while let Some(event) = self.out.pop_event() {
            if let SlaveEvent::Pdo(_) = event {
                self.slave.change(self.now, |valve| valve.opening = valve.wanted);
            }
        }
        self.slave.poll(&mut Turn::new(self.now, &mut self.out));
        let mut sent = Vec::new();
        while let Some((bus, command)) = self.out.pop_command() {
            if let BusCommand::Send(outgoing) = command {
                sent.push((outgoing.frame.id().raw(), outgoing.frame.data().to_vec()));
                // Another node acknowledges it.
                let event =
                    LinkEvent::Transmitted { frame: outgoing.frame, stamp: Stamp::interrupt(self.now) };
                self.slave.on_link(bus, &event, &mut Turn::new(self.now, &mut self.out));
            }
        }
        println!("{:?}: {sent:X?}", self.now);
        sent
    }
}

fn main() {
    let slave = Slave::builder(NodeId::of::<5>(), &Profile::DEFAULT, Valve::default()).build();
    let mut desk = Desk { slave, out: Outbox::new(), now: Instant::ZERO };
    desk.slave.start(&mut Turn::new(desk.now, &mut desk.out));
    assert_eq!(desk.sent()[0], (0x705, vec![0]), "boot-up");

    let opening = desk.receive(0x605, &[0x40, 0x01, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(opening, [(0x585, vec![0x4F, 0x01, 0x60, 0, 0, 0, 0, 0])], "the opening over SDO");

    desk.receive(0x000, &[1, 5]);
    assert_eq!(desk.receive(0x205, &[60]), [(0x185, vec![60])], "a PDO moves the valve, a PDO tells of it");
    let refusal = desk.receive(0x205, &[101]);
    assert_eq!(refusal[0].0, 0x085, "an emergency: no valve opens that wide");
    assert_eq!(desk.slave.objects().application.opening, 60);
}

#[test]
fn it_runs() {
    main();
}
