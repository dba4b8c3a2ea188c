//! Heartbeats of foreign nodes: the master reports them, and no node changes its bus.

use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use flight::*;

/// Returns a flight with the master and slave 2. If the master counted a second node, the silence of one would be the
/// share that moves it.
fn master_and_one(images: Option<&Images>) -> Flight {
    let setups = &MASTER_AND_THREE[..2];
    images.map_or_else(|| Flight::new(setups), |images| Flight::with(setups, images))
}

/// Returns the number of frames that the master sent on the redundant bus.
fn strayed(flight: &Flight) -> usize {
    flight.of(MASTER).filter(|seen| seen.bus == Bus::Redundant).count()
}

/// Given one heartbeat of a node that does not exist, then silence for longer than the consumer time, then no node
/// changes its bus.
#[test]
fn one_heartbeat_of_a_node_that_does_not_exist_moves_nobody() {
    for (images, until_ms) in [(Some(&*STANDARD), 4_500), (None, 8_000)] {
        for state in [PRE_OPERATIONAL, OPERATIONAL] {
            let mut flight = master_and_one(images);
            let guest = flight.twin.add_guest(Bus::Nominal, 30.0);
            flight.twin.inject(guest, ms(1_050), WireFrame::standard(0x705, &[state]));
            flight.fly_to(until_ms);
            assert_eq!(strayed(&flight), 0, "state {state:02X}h\n{}", flight.log(1));
            flight.assert_operational([2], Bus::Nominal);
            flight.assert_kept_running([2], ms(300));
            let asked = flight.sent(MASTER, Bus::Nominal, 0x605).map(Seen::data);
            let asked = asked.filter(|data| data[..4] == [0x40, 0, 0x10, 0]);
            assert_eq!(asked.count(), 1, "its device type was asked for once");
            let told = flight.assert_said(1, "node 5 does not answer", ms(1_050));
            assert!(about(ms(1_550), ms(60)).contains(&told), "{} us", told.as_us());
            flight.assert_nothing_lost();
        }
    }
}

/// Given continuous heartbeats of a foreign node on the inactive bus, when it becomes silent, then no node changes its
/// bus.
#[test]
fn heartbeats_of_a_foreign_node_on_the_other_bus_move_nobody() {
    for (images, until_ms) in [(Some(&*STANDARD), 6_000), (None, 20_000)] {
        let mut flight = master_and_one(images);
        let guest = flight.twin.add_guest(Bus::Redundant, 30.0);
        for beat in 0..30 {
            flight.twin.inject(guest, ms(1_050 + 100 * beat), WireFrame::standard(0x705, &[OPERATIONAL]));
        }
        flight.fly_to(until_ms);
        assert_eq!(strayed(&flight), 0, "{}", flight.log(1));
        flight.assert_operational([2], Bus::Nominal);
        flight.assert_kept_running([2], ms(300));
        flight.assert_nothing_lost();
    }
}

/// Given a foreign node that is heard three times and never answers, then it is asked again at each heartbeat after an
/// unanswered question. Ten consumer times after a heartbeat it is forgotten.
#[test]
fn a_foreign_node_is_forgotten_and_asked_again_when_it_returns() {
    let mut flight = master_and_one(Some(&*STANDARD));
    let guest = flight.twin.add_guest(Bus::Nominal, 30.0);
    for at in [1_050, 3_400, 6_000] {
        flight.twin.inject(guest, ms(at), WireFrame::standard(0x705, &[OPERATIONAL]));
    }
    flight.fly_to(7_000);
    let asked = flight.sent(MASTER, Bus::Nominal, 0x605).map(|seen| seen.end.as_us() / 100_000);
    // The question, and the abort when its 500 ms are over.
    assert_eq!(asked.collect::<Vec<_>>(), [10, 15, 34, 39, 60, 65]);
    let reports = flight.logs.iter().filter(|log| log.text.contains("node 5 does not answer"));
    assert_eq!(reports.count(), 2, "once until it is forgotten");
    assert_eq!(strayed(&flight), 0);
    flight.assert_nothing_lost();
}
