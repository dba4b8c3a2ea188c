//! Two nodes with one Node-ID: who goes on and who is silent.

use crate::instrument::STANDARD;
use ecss_can::link::port::Health;
use ecss_can::nmt::{Clash, ClashWatch};
use ecss_can::node::SlaveEvent;
use ecss_can::types::Duration;
use ecss_can::types::NmtState::{Initialising, Operational, PreOperational, Stopped};

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, span};
use crate::slave::{TestSlave, powered};

/// A node that booted at 0 ms and whose boot-up message went out.
fn booted() -> ClashWatch {
    let mut identity = ClashWatch::new();
    identity.boot(ms(0));
    identity.on_sent(ms(0));
    identity
}

#[test]
fn heartbeat_heard_soon_after_boot_makes_the_newcomer() {
    for state in [PreOperational, Operational, Stopped] {
        let mut identity = booted();
        assert_eq!(identity.on_heartbeat(state, ms(99), span(100)), Clash::Newcomer);
        assert!(identity.has_yielded());
        assert_eq!(identity.on_heartbeat(state, ms(120), span(100)), Clash::Known);
    }
}

#[test]
fn heartbeat_heard_late_leaves_the_elder_running() {
    let mut identity = booted();
    assert_eq!(identity.on_heartbeat(Operational, ms(100), span(100)), Clash::Elder);
    assert_eq!(identity.on_heartbeat(Operational, ms(200), span(100)), Clash::Known);
    assert!(!identity.has_yielded());
}

/// Of two boot-up messages one is first on the wire: exactly one of the two nodes yields.
#[test]
fn of_two_boot_up_messages_the_second_is_the_newcomers() {
    let mut first = booted();
    let mut second = ClashWatch::new();
    second.boot(ms(0));
    assert_eq!(second.on_heartbeat(Initialising, ms(1), span(100)), Clash::Newcomer);
    // It was on its way already.
    assert_eq!(first.on_heartbeat(Initialising, ms(2), span(100)), Clash::Elder);
}

#[test]
fn clash_is_over_when_the_other_node_was_silent() {
    let mut identity = booted();
    identity.on_heartbeat(Operational, ms(10), span(100));
    identity.on_heartbeat(Operational, ms(60), span(100));
    assert_eq!(identity.deadline(span(50)), Some(ms(110)));
    assert!(!identity.poll(ms(109), span(50)));
    assert!(identity.poll(ms(110), span(50)) && !identity.poll(ms(111), span(50)));
    assert!(identity.restore() && !identity.restore());
    assert_eq!(identity.on_heartbeat(Operational, ms(500), span(100)), Clash::Elder, "news again");
}

/// Two nodes that booted together queue their heartbeats at the same time: the one that hears the other before it has sent
/// its own yields, and the other one goes on.
#[test]
fn of_two_heartbeats_that_cross_one_node_yields() {
    let (mut first, mut second) = (booted(), booted());
    first.on_sent(ms(50));
    assert_eq!(second.on_heartbeat(Operational, ms(50), span(100)), Clash::Newcomer);
    // The heartbeat of the second one was on its way.
    let at = ms(50) + Duration::from_micros(58);
    assert_eq!(first.on_heartbeat(Operational, at, span(100)), Clash::Elder);
    assert!(!first.has_yielded() && second.has_yielded());
}

fn clash_frames(slave: &Bench<TestSlave>) -> Vec<Vec<u8>> {
    let all = slave.sent.iter().filter(|sent| sent.frame.id().raw() == 0x085);
    all.map(|sent| sent.frame.data()[..4].to_vec()).collect()
}

/// Given a slave that has just booted, when its own Node-ID is heard, then it sends EMCY 8150h and nothing more until the
/// other node was silent for Ttoggle consumer times; resets and starts do not end that sooner.
///
/// Verifies: ECSS 6.10e
#[test]
fn newcomer_is_silent_until_the_other_node_is() {
    let mut slave = powered(&STANDARD);
    slave.transmitted(NOMINAL, frame(0x705, &[0]));
    slave.run_until(ms(40));
    slave.clear();
    slave.receive(NOMINAL, 0x705, &[0x05]);
    assert_eq!(clash_frames(&slave), [[0x50, 0x81, 0x11, 5]]);
    assert_eq!(slave.events, [SlaveEvent::Clash { bus: NOMINAL, yields: true }, SlaveEvent::State(Stopped)]);
    slave.clear();
    slave.receive(NOMINAL, 0x701, &[0x05]);
    slave.receive(NOMINAL, 0x000, &[0x01, 0x00]);
    slave.receive(NOMINAL, 0x605, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    // The master is lost, and searched on the other bus.
    slave.run_until(ms(539));
    assert_eq!(slave.frames(), []);
    assert_eq!(slave.node.status(slave.now).state, Stopped);
    slave.run_until(ms(540));
    assert_eq!(slave.events.last(), Some(&SlaveEvent::State(PreOperational)));
    assert!(slave.events.contains(&SlaveEvent::ClashOver));
    assert_eq!(slave.times(NOMINAL, 0x705).len() + slave.times(REDUNDANT, 0x705).len(), 1);
}

/// Given a slave that has worked for a while, when its own Node-ID is heard, then it reports that and goes on.
///
/// Verifies: ECSS 6.10e
#[test]
fn elder_reports_another_node_with_its_id_and_goes_on() {
    let mut slave = powered(&STANDARD);
    slave.transmitted(NOMINAL, frame(0x705, &[0]));
    for at in [10, 110, 210, 310] {
        slave.run_until(ms(at));
        slave.receive(NOMINAL, 0x701, &[0x05]);
    }
    slave.receive(NOMINAL, 0x000, &[0x01, 0x05]);
    slave.clear();
    for bus in [REDUNDANT, NOMINAL, NOMINAL] {
        slave.receive(bus, 0x705, &[0x00]);
    }
    assert_eq!(slave.events, [SlaveEvent::Clash { bus: REDUNDANT, yields: false }]);
    assert_eq!(clash_frames(&slave), [[0x50, 0x81, 0x11, 5]], "once");
    assert_eq!(slave.node.status(slave.now).state, Operational);
    slave.receive(NOMINAL, 0x705, &[0x05, 0x05]);
    slave.health(NOMINAL, Health::default());
    let malformed = slave.node.status(slave.now).counters.nominal.malformed;
    assert_eq!(malformed, 1);
}
