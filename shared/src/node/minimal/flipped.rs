//! A running minimal slave whose memory has a flipped bit.

use super::*;
use crate::node::extend::Outbox;
use crate::profile::Profile;

/// A device without PDOs.
struct Idle;

impl MinimalDevice for Idle {
    const PDOS: MinimalPdos = MinimalPdos { receive: [None; PDOS], transmit: [None; PDOS] };

    fn on_pdo(&mut self, _: usize, _: &[u8], _: Instant) -> Option<(usize, Payload)> {
        None
    }

    fn on_sync(&mut self, _: usize, _: Instant) -> Option<Payload> {
        None
    }
}

type Slave = MinimalSlave<Idle>;

/// A slave that has started, and the time.
fn started() -> (Slave, Instant) {
    let mut slave = MinimalSlave::builder(NodeId::of::<5>(), &Profile::DEFAULT, Idle).build();
    let now = Instant::from_micros(46_912_496_118);
    slave.start(&mut Turn::new(now, &mut Outbox::new()));
    (slave, now)
}

fn flipped(time: Duration, bit: u32) -> Duration {
    Duration::from_micros(time.as_micros() ^ 1 << bit)
}

/// A parameter, its bits, and how one of them flips.
type Parameter = (&'static str, u32, fn(&mut Slave, u32));

const PARAMETERS: [Parameter; 8] = [
    ("consumer time", 64, |slave, bit| slave.redundancy.consumer = flipped(slave.redundancy.consumer, bit)),
    ("producer time", 64, |slave, bit| slave.redundancy.producer = flipped(slave.redundancy.producer, bit)),
    ("Ttoggle", 8, |slave, bit| slave.redundancy.ttoggle ^= 1 << bit),
    ("Ntoggle", 8, |slave, bit| slave.redundancy.ntoggle ^= 1 << bit),
    ("heartbeat period", 64, |slave, bit| {
        let period = flipped(slave.heartbeat.period(), bit);
        slave.heartbeat.set_period(period, slave.heartbeat.deadline().unwrap());
    }),
    ("lifetime of telemetry", 64, |slave, bit| slave.lifetime = flipped(slave.lifetime, bit)),
    ("Node-ID", 7, |slave, bit| slave.id = NodeId::new(slave.id.get() ^ 1 << bit).unwrap()),
    ("heartbeats go on", 1, |slave, _| slave.heartbeat.stop()),
];

/// Flips a bit of the copy of a parameter.
const COPIES: [Parameter; 6] = [
    ("consumer time", 64, |slave, bit| {
        change(slave, |all| all.consumer = flipped(all.consumer, bit));
    }),
    ("producer time", 64, |slave, bit| {
        change(slave, |all| all.producer = flipped(all.producer, bit));
    }),
    ("Ttoggle", 8, |slave, bit| change(slave, |all| all.ttoggle ^= 1 << bit)),
    ("Ntoggle", 8, |slave, bit| change(slave, |all| all.ntoggle ^= 1 << bit)),
    ("lifetime of telemetry", 64, |slave, bit| slave.same_lifetime = flipped(slave.same_lifetime, bit)),
    ("Node-ID", 7, |slave, bit| {
        let node = NodeId::new(slave.heartbeat.node().get() ^ 1 << bit).unwrap();
        slave.heartbeat = heartbeat::machine::Producer::new(node, slave.redundancy.producer);
    }),
];

/// Changes the parameters of the selector.
fn change(slave: &mut Slave, change: impl FnOnce(&mut Parameters)) {
    let mut parameters = *slave.selector.parameters();
    change(&mut parameters);
    slave.selector.configure(parameters);
}

/// Given a running slave, then it is on schedule.
#[test]
fn intact_slave_is_on_schedule() {
    let (slave, now) = started();
    assert!(slave.is_on_schedule(now));
}

/// Given a running slave, when any bit of its parameters or of their copies flips, then it is not on schedule, so that its board resets
/// it.
#[test]
fn flipped_parameter_takes_the_slave_off_schedule() {
    for (list, parameters) in [("parameters", &PARAMETERS[..]), ("copies", &COPIES[..])] {
        for (name, bits, flip) in parameters {
            for bit in 0..*bits {
                let (mut slave, now) = started();
                flip(&mut slave, bit);
                assert!(!slave.is_on_schedule(now), "{name} of the {list}, bit {bit}");
            }
        }
    }
}

/// Given a slave that changed its bus and searches, then it is on schedule: Bdefault and Ctoggle are no parameters that stay.
#[test]
fn searching_slave_is_on_schedule() {
    let (mut slave, begin) = started();
    for step in 1..40 {
        let now = begin + Duration::from_millis(50).times(step);
        slave.poll(&mut Turn::new(now, &mut Outbox::new()));
        assert!(slave.is_on_schedule(now), "step {step}");
    }
    assert!(slave.selector.parameters().ctoggle > 0);
}
