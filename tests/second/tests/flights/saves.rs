//! Saves under load: heartbeats are on time, no frame is lost, and no node changes the bus.

use can_twin::board::{BoardConfig, Fittings};
use can_twin::peripherals::FlashSpeed;
use can_twin::spacecraft::{Bus, GuestId};
use can_twin::traffic::Traffic;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

const NODES: [u8; 3] = [1, 2, 3];
/// Period of all heartbeats in profile `standard`.
const HEARTBEAT: Time = ms(100);
/// Timeout of SDO clients in profile `standard`.
const TIMEOUT: Time = ms(500);

/// A master and two slaves in profile `standard`, foreign frames for half of the time of both buses, and an SDO client.
struct Loaded {
    flight: Flight,
    traffic: [Traffic; 2],
    client: GuestId,
}

impl Loaded {
    fn new(flash_speed: FlashSpeed) -> Loaded {
        let fittings = Fittings { flash_speed, ..Fittings::default() };
        let config = |setup: BoardSetup| BoardConfig { fittings, ..setup.with(&STANDARD) };
        let mut flight = Flight::of(&MASTER_AND_THREE[..3], config);
        let client = flight.twin.add_guest(Bus::Nominal, 30.0);
        let traffic = Bus::ALL.map(|bus| Traffic::new(&mut flight.twin, bus, 0.5, 7, ms(1_000)));
        let mut loaded = Loaded { flight, traffic, client };
        loaded.fly(ms(1_500));
        loaded
    }

    fn fly(&mut self, until: Time) {
        while self.flight.end < until {
            let next = (self.flight.end + Time::from_us(500)).min(until);
            self.traffic.iter_mut().for_each(|traffic| traffic.hand_over(&mut self.flight.twin, next));
            self.flight.fly(next);
        }
    }

    /// Sends a request to `node`, and returns its answer and the time until it.
    fn ask(&mut self, node: u8, request: [u8; 8]) -> (Vec<u8>, Time) {
        let (from, known) = (self.flight.end, self.flight.on(Bus::Nominal).count());
        self.flight.twin.inject(self.client, from, WireFrame::standard(0x600 + u16::from(node), &request));
        loop {
            self.fly(self.flight.end + Time::from_us(500));
            let id = Some(0x580 + u16::from(node));
            if let Some(answer) = self.flight.on(Bus::Nominal).skip(known).find(|seen| seen.id() == id) {
                return (answer.data().to_vec(), answer.end.since(from));
            }
            assert!(self.flight.end < from + TIMEOUT, "node {node} does not answer {request:02X?}");
        }
    }
}

/// Verifies: ECSS 6.5.2a
#[test]
fn ten_saves_in_a_row_at_every_node_disturb_nobody() {
    for speed in [FlashSpeed::Typical, FlashSpeed::Slowest] {
        println!("{speed:?}");
        let mut loaded = Loaded::new(speed);
        let from = loaded.flight.end;
        for node in NODES {
            let mut longest = Time::ZERO;
            for sub in [1, 1, 1, 1, 1, 1, 1, 2, 3, 4] {
                let (answer, took) = loaded.ask(node, [0x23, 0x10, 0x10, sub, b's', b'a', b'v', b'e']);
                assert_eq!(answer, [0x60, 0x10, 0x10, sub, 0, 0, 0, 0], "{speed:?}, node {node}, sub {sub}");
                longest = longest.max(took);
            }
            println!("{speed:?}: a save of node {node} takes at most {} us", longest.as_us());
        }
        loaded.fly(loaded.flight.end + ms(300));
        let mut flight = loaded.flight;
        for node in NODES {
            let said = flight.heartbeats(node, Bus::Nominal).into_iter().filter(|(at, _)| *at > from);
            let (ends, states): (Vec<Time>, Vec<u8>) = said.unzip();
            assert!(states.iter().all(|state| *state == OPERATIONAL), "{speed:?}, node {node}: {states:?}");
            let longest = gaps(&ends).max().unwrap();
            println!("{speed:?}: longest pause between heartbeats of node {node}: {} us", longest.as_us());
            assert!(longest <= HEARTBEAT + ms(5), "{speed:?}, node {node}: {} us", longest.as_us());
            assert!(flight.heartbeats(node, Bus::Redundant).is_empty(), "{speed:?}, node {node}");
        }
        flight.assert_operational(NODES, Bus::Nominal);
        flight.assert_nothing_lost();
    }
}
