//! Nodes that send too much: the budget of a slave, and the reaction of the master.

use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

/// Lets a guest on the nominal bus send this frame every `period_us` from 2 s to 4 s.
fn flood(flight: &mut Flight, frame: WireFrame, period_us: u64) {
    let guest = flight.twin.add_guest(Bus::Nominal, 30.0);
    for at in (2_000_000..4_000_000).step_by(period_us as usize) {
        flight.twin.inject(guest, Time::from_us(at), frame);
    }
}

/// Returns the number of frames of `node` with this identifier on the nominal bus during the flood.
fn sent(flight: &Flight, node: u8, id: u16) -> usize {
    flight.sent(node, Bus::Nominal, id).filter(|seen| seen.end > ms(2000) && seen.end <= ms(4000)).count()
}

/// Given a node that requests telemetry of slave 2 4,000 times a second, when that slave answers each, then its budget
/// limits the answers to a thousand per second and a full bucket, with one report. No other node sends less than
/// before.
///
/// Verifies: ECSS 5.3.3.1b
#[test]
fn a_slave_that_is_made_to_babble_keeps_its_budget() {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flood(&mut flight, WireFrame::standard(0x402, &[0x02, 0x01]), 250);
    flight.fly_to(4000);
    let answers = sent(&flight, 2, 0x382);
    assert!((500..=128 + 2 * 1_000).contains(&answers), "{answers}");
    let reports: Vec<&[u8]> = flight.emergencies(2, ms(0)).collect();
    assert!(reports.contains(&&[0x00, 0x81, 0x11, 0x17, 0x82, 0x03, 0, 0][..]), "{reports:02X?}");
    for node in [3, 4] {
        let (commands, answers) =
            (sent(&flight, MASTER, 0x300 + u16::from(node)), sent(&flight, node, 0x380 + u16::from(node)));
        assert!(commands >= 19 && answers >= 19, "{node}: {commands} commands, {answers} answers");
        assert_eq!(flight.emergencies(node, ms(0)).count(), 0, "{node}");
    }
    for node in [2, 3, 4] {
        assert!(sent(&flight, node, 0x700 + u16::from(node)) >= 7, "heartbeats of {node}");
    }
    flight.assert_operational([2, 3, 4], Bus::Nominal);
    flight.assert_sound();
}

/// Given a guest that keeps sending 703h, when no command to slave 3 ends that, then the master leaves the bus: stop,
/// reset, other bus. Slave 2 follows without a change of its state, and its commands continue.
///
/// Verifies: ECSS 5.3.3.1b, 8.3.3b
#[test]
fn the_master_leaves_a_bus_on_which_a_slave_babbles() {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flood(&mut flight, WireFrame::standard(0x703, &[OPERATIONAL]), 100);
    flight.fly_to(4500);
    let command =
        |data: [u8; 2]| flight.first_after(ms(2000), move |seen| seen.id() == Some(0) && seen.data() == data);
    let stopped = command([0x02, 3]).expect("NMT stop").end;
    let reset = command([0x81, 3]).expect("reset node").end;
    let left = flight.first_after(ms(2000), |seen| seen.bus == Bus::Redundant && seen.id() == Some(0x701));
    let left = left.expect("the heartbeat on the other bus").end;
    assert!(stopped < ms(2200) && about(ms(500), ms(20)).contains(&reset.since(stopped)), "{reset:?}");
    assert!(about(ms(500), ms(20)).contains(&left.since(reset)), "{left:?}");
    flight.assert_operational([2], Bus::Redundant);
    let commands = flight.sent(MASTER, Bus::Redundant, 0x302).filter(|seen| seen.end > ms(3500)).count();
    assert!(commands >= 9, "{commands}");
    assert_eq!(flight.sent(2, Bus::Nominal, 0x082).count(), 0);
    flight.assert_sound();
}
