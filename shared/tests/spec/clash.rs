//! Two nodes with one Node-ID: who goes on and who is silent.
//!
//! Verifies: ECSS 6.10h

use crate::instrument::{self, STANDARD};
use ecss_can::link::port::Health;
use ecss_can::nmt::machine::{Clash, ClashWatch};
use ecss_can::node::SlaveEvent;
use ecss_can::node::extend::LinkEvent;
use ecss_can::types::NmtState::{Initialising, Operational, PreOperational, Stopped};
use ecss_can::types::{Duration, Instant};

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, node, span};
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
        assert_eq!(identity.on_heartbeat(state, ms(99), span(100), false), Clash::Newcomer);
        assert!(identity.has_yielded());
        assert_eq!(identity.on_heartbeat(state, ms(120), span(100), false), Clash::Known);
    }
}

#[test]
fn heartbeat_heard_late_leaves_the_elder_running() {
    let mut identity = booted();
    assert_eq!(identity.on_heartbeat(Operational, ms(100), span(100), false), Clash::Elder);
    assert_eq!(identity.on_heartbeat(Operational, ms(200), span(100), false), Clash::Known);
    assert!(!identity.has_yielded());
}

/// Of two boot-up messages one is first on the wire: exactly one of the two nodes yields.
#[test]
fn of_two_boot_up_messages_the_second_is_the_newcomers() {
    let mut first = booted();
    let mut second = ClashWatch::new();
    second.boot(ms(0));
    assert_eq!(second.on_heartbeat(Initialising, ms(1), span(100), false), Clash::Newcomer);
    // It was on its way already.
    assert_eq!(first.on_heartbeat(Initialising, ms(2), span(100), false), Clash::Elder);
}

#[test]
fn clash_is_over_when_the_other_node_was_silent() {
    let mut identity = booted();
    identity.on_heartbeat(Operational, ms(10), span(100), false);
    identity.on_heartbeat(Operational, ms(60), span(100), false);
    assert_eq!(identity.deadline(span(50)), Some(ms(110)));
    assert!(!identity.poll(ms(109), span(50)));
    assert!(identity.poll(ms(110), span(50)) && !identity.poll(ms(111), span(50)));
    assert!(identity.restore() && !identity.restore());
    assert_eq!(identity.on_heartbeat(Operational, ms(500), span(100), false), Clash::Elder, "news again");
}

/// Two nodes that booted together queue their heartbeats at the same time: the one that hears the other before it has sent
/// its own yields, and the other one goes on.
#[test]
fn of_two_heartbeats_that_cross_one_node_yields() {
    let (mut first, mut second) = (booted(), booted());
    first.on_sent(ms(50));
    assert_eq!(second.on_heartbeat(Operational, ms(50), span(100), false), Clash::Newcomer);
    // The heartbeat of the second one was on its way.
    let at = ms(50) + Duration::from_micros(58);
    assert_eq!(first.on_heartbeat(Operational, at, span(100), false), Clash::Elder);
    assert!(!first.has_yielded() && second.has_yielded());
}

/// Given a newcomer that heard the boot-up message of another node, then that one is the newcomer, however soon its heartbeat
/// follows.
#[test]
fn node_that_heard_the_other_boot_is_the_elder() {
    let mut elder = booted();
    assert_eq!(elder.on_heartbeat(Initialising, ms(50), span(100), false), Clash::Elder);
    assert_eq!(elder.on_heartbeat(PreOperational, ms(90), span(100), false), Clash::Known);
    assert!(!elder.has_yielded());
}

/// Given heartbeats that cross, then the node may still be a newcomer. One that is heard apart from its own ends that.
#[test]
fn heartbeat_heard_apart_makes_the_elder() {
    let crossed = || {
        let mut watch = booted();
        watch.on_sent(ms(200));
        assert_eq!(
            watch.on_heartbeat(Operational, ms(200) + Duration::from_micros(60), span(100), false),
            Clash::Elder
        );
        watch
    };
    // Both on one grid: the probation of a late heartbeat is long.
    assert_eq!(crossed().on_heartbeat(Operational, ms(300), span(6_400), false), Clash::Newcomer);
    let mut apart = crossed();
    assert_eq!(apart.on_heartbeat(Operational, ms(250), span(100), false), Clash::Known);
    assert_eq!(apart.on_heartbeat(Operational, ms(300), span(6_400), false), Clash::Known);
}

/// Given a heartbeat that is heard while the own one waits, then the node may still be a newcomer: the other one may have the same
/// grid.
#[test]
fn heartbeat_heard_while_its_own_waits_makes_no_elder() {
    let mut watch = booted();
    watch.on_sent(ms(100));
    assert_eq!(watch.on_heartbeat(Operational, ms(200), span(100), true), Clash::Elder);
    assert_eq!(watch.on_heartbeat(Operational, ms(300), span(6_400), false), Clash::Newcomer);
}

/// A slave whose heartbeats are all late, 700 ms after its boot-up: the next one is due at 700 ms, and goes out 540 us later.
fn late_slave() -> Bench<TestSlave> {
    let slave = instrument::builder(node(5), &STANDARD, vec![0; 1024]).late_heartbeats(u32::MAX);
    let mut slave = Bench::new(slave.build());
    slave.transmitted(NOMINAL, frame(0x705, &[0]));
    for at in (50..=650).step_by(100) {
        slave.run_until(ms(at));
        slave.receive(NOMINAL, 0x701, &[0x7F]);
    }
    slave.run_until(ms(699));
    slave.clear();
    slave
}

/// Given a slave that has worked for seven heartbeat periods, when its own Node-ID is heard while its heartbeat is held back, then
/// the other board has the same grid: the slave yields before its heartbeat goes out. At any other time it goes on.
#[test]
fn slave_yields_to_a_heartbeat_while_its_own_is_late() {
    for (at, yields) in [(699_900, false), (700_060, true), (700_530, true), (700_700, false)] {
        let mut slave = late_slave();
        slave.run_until(Instant::from_micros(at));
        slave.receive(NOMINAL, 0x705, &[0x7F]);
        slave.run_until(ms(900));
        let clash = SlaveEvent::Clash { bus: NOMINAL, yields };
        assert!(slave.events.contains(&clash), "{at} us: {:?}", slave.events);
        let sent = slave.times(NOMINAL, 0x705).len() + slave.times(REDUNDANT, 0x705).len();
        assert_eq!(sent == 0, yields, "{at} us: {sent} heartbeats");
    }
}

/// Given a slave whose late heartbeat waits for the bus, when that of a board with the same grid is heard, then the slave goes on,
/// and yields to the next one that it hears while its heartbeat is held back.
#[test]
fn slave_yields_later_to_a_heartbeat_that_came_before_its_own() {
    let mut slave = late_slave();
    for (at, yields) in [(700_600, None), (800_060, Some(true))] {
        slave.run_until(Instant::from_micros(at));
        slave.receive(NOMINAL, 0x705, &[0x7F]);
        let clash = yields.map(|yields| SlaveEvent::Clash { bus: NOMINAL, yields });
        assert!(clash.is_none_or(|clash| slave.events.contains(&clash)), "{at} us: {:?}", slave.events);
        assert_eq!(slave.node.status(slave.now).state == Stopped, yields == Some(true), "{at} us");
    }
}

fn clash_frames(slave: &Bench<TestSlave>) -> Vec<Vec<u8>> {
    let all = slave.sent.iter().filter(|sent| sent.frame.id().raw() == 0x085);
    all.map(|sent| sent.frame.data()[..4].to_vec()).collect()
}

/// Given a slave that has just booted, when its own Node-ID is heard, then it sends EMCY 8150h and nothing more until the
/// other node was silent for Ttoggle consumer times; resets and starts do not end that sooner.
///
/// Verifies: ECSS 8.3.3d, 6.4a.2
/// Notices: ECSS 8.3.3d: a slave that was silent in a clash sends no heartbeat after it.
/// Notices: ECSS 6.4a.2: a clash of Node-IDs has another code than 8150h.
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

/// Given a newcomer whose inhibit time runs and for which another emergency waits, when its own Node-ID is heard, then EMCY 8150h
/// goes out before it is Stopped.
///
/// Verifies: ECSS 6.4a.1, 6.4a.2, 6.5.4a
/// Notices: ECSS 6.5.4a: emergencies that wait go out in Stopped.
#[test]
fn newcomer_reports_the_clash_within_its_inhibit_time() {
    let mut slave = powered(&STANDARD);
    slave.transmitted(NOMINAL, frame(0x705, &[0]));
    slave.run_until(ms(30));
    for bus in [NOMINAL, REDUNDANT] {
        slave.link(bus, LinkEvent::Overrun { lost: 1 });
    }
    assert_eq!(clash_frames(&slave).len(), 1, "the second one waits for 100 ms");
    slave.run_until(ms(40));
    slave.clear();
    slave.receive(NOMINAL, 0x705, &[0x05]);
    assert_eq!(clash_frames(&slave), [[0x50, 0x81, 0x11, 5]]);
    assert_eq!(slave.node.status(slave.now).state, Stopped);
    slave.run_until(ms(300));
    assert_eq!(clash_frames(&slave).len(), 1, "Stopped forbids the others");
}

/// Given a slave that has worked for a while, when its own Node-ID is heard, then it reports that once and goes on.
///
/// Verifies: ECSS 6.4a.2, 6.4a.1
/// Notices: ECSS 6.4a.1: each heartbeat with the own Node-ID is another emergency.
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
    // Three inhibit times, in which the other node is heard.
    for at in [410, 510, 610, 710] {
        slave.run_until(ms(at));
        slave.receive(NOMINAL, 0x701, &[0x05]);
        slave.receive(NOMINAL, 0x705, &[0x05]);
    }
    assert_eq!(slave.times(NOMINAL, 0x085), [310], "once");
    slave.receive(NOMINAL, 0x705, &[0x05, 0x05]);
    slave.health(NOMINAL, Health::default());
    let malformed = slave.node.status(slave.now).counters.nominal.malformed;
    assert_eq!(malformed, 1);
}
