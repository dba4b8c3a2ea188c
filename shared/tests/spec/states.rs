//! Values that are declared as states.
//!
//! Verifies: ECSS 6.2a

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::extend::LinkEvent;
use ecss_can::node::{Device, Slave};
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
use ecss_can::profile::Profile;

use crate::bench::{Bench, NOMINAL, REDUNDANT, ms, node, span};
use crate::instrument::STANDARD;

#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
struct Valve {
    /// Position
    #[object(0x6000, ro, pdo)]
    position: u8,
    /// Pressure
    #[object(0x6001, ro, pdo)]
    pressure: u8,
}

impl Device for Valve {
    type Pdos = PdoObjects<1, 2>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(
        &[],
        &[
            Pdo::<()>::new(CobIdOf::fixed(0x205)).map(Valve::POSITION).transmit(1).state(),
            Pdo::<()>::new(CobIdOf::fixed(0x285)).map(Valve::PRESSURE).transmit(2).state(),
        ],
    );
}

fn operational() -> Bench<Slave<Valve>> {
    let profile = Profile { autostart: true, ..STANDARD };
    let mut slave = Bench::new(Slave::builder(node(5), &profile, Valve { position: 0, pressure: 0 }).build());
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.run_until(ms(50));
    slave.clear();
    slave
}

/// Runs it to `until`, with a heartbeat of the master every 100 ms.
fn run(slave: &mut Bench<Slave<Valve>>, until: u64) {
    while slave.now < ms(until) {
        let next = (slave.now + span(100)).min(ms(until));
        slave.run_until(next);
        slave.receive(NOMINAL, 0x701, &[5]);
    }
}

/// Given a receiver that loses frames for 0.2 s, then the states are sent again, once, a second after the first loss. One of
/// the frames may have been the boot-up message of the master.
#[test]
fn states_are_sent_again_after_an_overrun() {
    let mut slave = operational();
    for at in (50..250).step_by(10) {
        slave.run_until(ms(at));
        slave.receive(NOMINAL, 0x701, &[5]);
        slave.link(NOMINAL, LinkEvent::Overrun { lost: 1 });
        slave.link(REDUNDANT, LinkEvent::Overrun { lost: 1 });
    }
    run(&mut slave, 5_000);
    assert_eq!((slave.times(NOMINAL, 0x205), slave.times(NOMINAL, 0x285)), (vec![1_050], vec![1_060]));
}

/// Given no event, then a state is sent every ten seconds.
#[test]
fn a_state_has_an_event_timer() {
    let mut slave = operational();
    run(&mut slave, 25_000);
    assert_eq!(slave.times(NOMINAL, 0x205), [10_000, 20_000]);
}
