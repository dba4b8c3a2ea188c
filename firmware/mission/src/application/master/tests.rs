//! The application repairs what a flipped bit made of the turns of a slave.

extern crate std;

use std::boxed::Box;

use ecss_can::mock::{MockBoard, MockSpacecraft};
use ecss_can::redundancy::OneBoard;
use ecss_can::runner::Events;
use ecss_can::types::Duration;

use super::*;
use crate::STANDARD;

const SLAVE: NodeId = NodeId::of::<2>();
const ABSENT: NodeId = NodeId::of::<3>();

struct Dark;

impl Indicators for Dark {
    fn sync(&mut self) {}
    fn heartbeat(&mut self) {}
    fn time(&mut self) {}
    fn state(&mut self, _on: bool) {}
    fn reset(&mut self) {}
}

/// The application of a master with one slave. No event reaches it.
struct World {
    spacecraft: MockSpacecraft,
    application: Application<MockBoard, OneBoard, Events<MockBoard, Node<OneBoard>>, Dark>,
}

impl World {
    fn new() -> World {
        let mut spacecraft = MockSpacecraft::new();
        let memory: &'static mut [u8] = Box::leak(Box::new([0; 4_096]));
        let _ = spacecraft.power_on(|| crate::slave(SLAVE, &STANDARD, memory).build());
        let (master, events) = spacecraft.power_on(|| crate::master(&STANDARD).build());
        let cables = Box::leak(Box::new(Cables::new()));
        let application = Application::new(master, events, Dark, cables, &[]);
        World { spacecraft, application }
    }

    /// Runs for a time with turns at least ten times a second. Returns the numbers of commands and of telemetry requests to a slave.
    fn run(&mut self, node: NodeId, span: Duration) -> [usize; 2] {
        let end = self.spacecraft.now() + span;
        let mut sent = std::vec![];
        while self.spacecraft.now() < end {
            let next = self.spacecraft.now() + Duration::from_millis(5);
            sent.extend(self.spacecraft.run_until(next));
            self.application.take_turns();
            self.application.compare_next();
        }
        [0x300, 0x400].map(|id| {
            let id = id + u16::from(node.get());
            sent.iter().filter(|sent| sent.frame.id().raw() == id).count()
        })
    }

    /// A world in which the slave has its turns.
    fn settled() -> World {
        let mut world = World::new();
        world.run(SLAVE, Duration::from_millis(2_000));
        assert!(world.has_turns());
        world
    }

    fn has_turns(&mut self) -> bool {
        let second = Duration::from_millis(1_000);
        self.run(SLAVE, second).iter().all(|sent| (9..=11).contains(sent))
    }

    fn now(&self) -> Instant {
        self.spacecraft.now()
    }
}

/// Given a slave with turns, when a flipped bit takes those of commands or of requests away, then they come back within a second.
#[test]
fn slave_that_lost_its_turns_gets_them_back() {
    for schedule in 0..2 {
        let mut world = World::settled();
        let now = world.now();
        match schedule {
            0 => world.application.commands.stop(SLAVE, now),
            _ => world.application.telemetry.stop(SLAVE, now),
        }
        world.run(SLAVE, Duration::from_millis(1_000));
        assert!(world.has_turns(), "schedule {schedule}");
    }
}

/// Given a node that is absent, when a flipped bit gives it turns, then it has none after a second.
#[test]
fn absent_slave_with_turns_loses_them() {
    let mut world = World::settled();
    let now = world.now();
    world.application.commands.start(ABSENT, now);
    world.application.telemetry.start(ABSENT, now);
    world.run(ABSENT, Duration::from_millis(1_000));
    assert_eq!(world.run(ABSENT, Duration::from_millis(500)), [0; 2]);
}

/// Given a slave with turns, when a flipped bit moves the first command of its sequence far ahead, then commands come back
/// within a second.
#[test]
fn sequence_that_waits_too_long_is_brought_back() {
    let mut world = World::settled();
    world.application.sequences[0] = Sequence::new(Instant::from_micros(1 << 40), COMMAND_PERIOD);
    world.run(SLAVE, Duration::from_millis(1_000));
    assert!(world.has_turns());
}

/// Given a number of the slave to compare with any flipped bit, then every slave is compared again.
#[test]
fn every_slave_is_compared_whatever_bit_of_the_number_flipped() {
    for bit in 0..8 {
        let mut world = World::settled();
        world.application.compared ^= 1 << bit;
        world.application.commands.stop(SLAVE, world.now());
        world.run(SLAVE, Duration::from_millis(1_000));
        assert!(world.has_turns(), "bit {bit}");
    }
}
