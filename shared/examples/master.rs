//! A master without any hardware: it commands a valve and hears how far that is open, both by PDO.
//! Run it: `cargo run -p ecss-can --example master`

use ecss_can::link::Stamp;
use ecss_can::node::extend::{BusCommand, LinkEvent, Outbox, Turn};
use ecss_can::prelude::*;

const VALVE: NodeId = NodeId::of::<5>();

/// The valve, as its own crate declares it.
#[derive(Debug, Objects)]
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

/// Command to a valve: 200h + node.
const OPEN: Pdo<Valve, (u8,)> = Pdo::new(CobIdOf::node(0x200)).map(Valve::WANTED);
/// How far a valve is open: 180h + node.
const OPENING: Pdo<Valve, (u8,)> = Pdo::new(CobIdOf::node(0x180)).map(Valve::OPENING);

/// What the master has beside the objects of every master: nothing. Its application has the values of its PDOs.
#[derive(Debug, Objects)]
#[objects(device)]
struct Plant {}

impl Device for Plant {
    type Pdos = PdoObjects<1, 0>;
    type Consumers = HeartbeatConsumers<4>;
    const PDOS: PdoSet = PdoSet::new(&[OPENING.of(VALVE).receive(1)], &[]);
}

/// The master with its outbox, at a desk.
struct Desk {
    master: Master<Plant>,
    out: Outbox<MasterEvent>,
    now: Instant,
}

impl Desk {
    /// Gives the master a frame of the nominal bus; what it sends.
    fn receive(&mut self, id: u16, data: &[u8]) -> Vec<(u16, Vec<u8>)> {
        let frame = Frame::new(CobId::new(id).expect("11 bits"), data).expect("8 bytes at most");
        self.master.on_received(
            Bus::Nominal,
            &frame,
            &Stamp::interrupt(self.now),
            &mut Turn::new(self.now, &mut self.out),
        );
        self.sent()
    }

    /// What the master has sent since it was asked last. All of it is acknowledged.
    fn sent(&mut self) -> Vec<(u16, Vec<u8>)> {
        self.master.poll(&mut Turn::new(self.now, &mut self.out));
        let mut sent = Vec::new();
        while let Some((bus, command)) = self.out.pop_command() {
            if let BusCommand::Send(outgoing) = command {
                let event =
                    LinkEvent::Transmitted { frame: outgoing.frame, stamp: Stamp::interrupt(self.now) };
                self.master.on_link(bus, &event, &mut Turn::new(self.now, &mut self.out));
                sent.push((outgoing.frame.id().raw(), outgoing.frame.data().to_vec()));
            }
        }
        println!("{:?}: {sent:X?}", self.now);
        sent
    }
}

fn main() {
    let master = Master::builder(&Profile::DEFAULT, Plant::default()).build();
    let mut desk = Desk { master, out: Outbox::new(), now: Instant::ZERO };
    desk.master.start(&mut Turn::new(desk.now, &mut desk.out));
    assert_eq!(desk.sent()[0], (0x701, vec![0]), "boot-up");

    let answer = desk.receive(0x705, &[0]);
    assert!(answer.contains(&(0x000, vec![1, 5])), "the valve has booted: start it");
    desk.receive(0x705, &[5]);

    desk.master.send_to(VALVE, OPEN, (60,), desk.now).expect("the valve is operational");
    assert_eq!(desk.sent(), [(0x205, vec![60])]);

    desk.receive(0x185, &[60]);
    let is_open = |event| matches!(event, MasterEvent::Pdo(pdo) if pdo.get(OPENING.of(VALVE)) == Some((60,)));
    assert!(core::iter::from_fn(|| desk.out.pop_event()).any(is_open), "the application knows");
}

#[test]
fn it_runs() {
    main();
}
