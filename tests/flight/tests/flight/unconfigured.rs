//! Slaves that differ from what the master expects: reset unnoticed, or another product.

use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

const CUT: Time = Time::from_ms(2_013);
/// Slave 2, which has parallel access.
const SLAVE: u8 = 2;
/// "Error behaviour" (1029h sub 1): 1 in the configuration of profile `librecube`, 0 after a reset.
const WRITE_ERROR_BEHAVIOUR: [u8; 5] = [0x2F, 0x29, 0x10, 1, 1];

/// Returns the SDO requests to the slave on `bus` after `from`.
fn requests(flight: &Flight, bus: Bus, from: Time) -> Vec<&Seen> {
    flight.sent(MASTER, bus, 0x602).filter(|seen| seen.end > from).collect()
}

/// Returns sub-index and value of a download of 4 bytes to 1020h.
fn stamped(seen: &Seen) -> Option<(u8, u32)> {
    let &[0x23, 0x20, 0x10, sub, a, b, c, d] = seen.data() else { return None };
    Some((sub, u32::from_le_bytes([a, b, c, d])))
}

/// Given the nominal bus is cut next to the master, and slave 2 is reset right then: its boot-up message does not reach the
/// master
/// When slave 2 follows the master to the redundant bus
/// Then it is started at once, 1020h is read, and it is configured in Pre-operational and started again.
///
/// Verifies: ECSS 6.1a, 8.3.3f
#[test]
fn a_slave_reset_on_the_bus_left_is_configured_again() {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flight.fly(CUT);
    let is_configured = |seen: &&Seen| seen.data()[..5] == WRITE_ERROR_BEHAVIOUR;
    assert!(requests(&flight, Bus::Nominal, ms(0)).iter().any(is_configured));
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.reset(SLAVE);
    flight.fly(CUT + ms(1_500));
    flight.assert_said(SLAVE, "slave 2 starts", CUT);
    let reached_master = |seen: &&Seen| seen.reached.contains(&MASTER) && seen.end > CUT;
    assert_eq!(flight.sent(SLAVE, Bus::Nominal, 0x702).filter(reached_master).count(), 0, "unheard");

    let said = flight.heartbeats(SLAVE, Bus::Redundant);
    let states: Vec<u8> = said.iter().map(|(_, state)| *state).collect();
    assert_eq!(states[..4], [PRE_OPERATIONAL, OPERATIONAL, PRE_OPERATIONAL, OPERATIONAL], "{said:?}");
    assert!(states[4..].iter().all(|state| *state == OPERATIONAL));
    let [waits, runs, stopped, runs_again] = [0, 1, 2, 3].map(|nth| said[nth].0);
    assert!(runs < waits + ms(2), "fail-over does not wait for SDO: {} us", runs.since(waits).as_us());
    let asked = requests(&flight, Bus::Redundant, CUT);
    let read = asked.iter().find(|seen| seen.data()[..4] == [0x40, 0x20, 0x10, 1]).unwrap();
    assert!(read.start > waits && read.end < stopped, "1020h is read while it runs");
    let written = asked.iter().find(|seen| is_configured(seen)).unwrap();
    assert!(written.start > stopped && written.end < runs_again, "configured while it waits");
    let stamps: Vec<(u8, u32)> = asked.iter().filter_map(|seen| stamped(seen)).collect();
    assert_eq!(stamps, [(1, 12_321), (2, 43_200_000)]);
    let told = "slave 2: configuration lost, 1020h sub 1 is 00000000h, expected 00003021h";
    flight.assert_said(MASTER, told, CUT);
    flight.assert_operational([SLAVE], Bus::Redundant);
    // The other slave with parallel access followed. The master reads its error register and no other object.
    let asked = flight.sent(MASTER, Bus::Redundant, 0x603);
    assert!(asked.map(Seen::data).all(|data| data[..4] == [0x40, 0x01, 0x10, 0]));
    flight.assert_sound();
}

/// Given a client that makes the master expect another product code of slave 3 (1F86h)
/// When slave 3 boots up again
/// Then the log of the master names error, letter, object, found and expected value, and slave 3 is not started.
#[test]
fn a_failed_boot_up_is_logged_with_its_object() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Nominal);
    flight.fly_to(1_045);
    let expect_5016 = WireFrame::standard(0x601, &[0x23, 0x86, 0x1F, 3, 0x16, 0x50, 0, 0]);
    flight.twin.inject(guest, ms(1_045), expect_5016);
    flight.fly_to(1_050);
    flight.reset(3);
    flight.fly_to(1_700);
    let told = "slave 3: boot-up failed, error M (Product): 1018h sub 2 is 00005015h, expected 00005016h";
    flight.assert_said(MASTER, told, ms(1_050));
    assert!(!flight.is_operational(3, Bus::Nominal) && flight.is_operational(2, Bus::Nominal));
    assert!(flight.said(MASTER, "mandatory", ms(0)).is_none(), "no slave of this profile is mandatory");
}
