//! The Node-ID of a slave: its straps, the stored Node-ID in its flash, and its change in maintenance mode.

use can_twin::pin::Pin;
use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use flight::*;

/// The strap of maintenance mode, and those of the Node-ID with parity (docs/wiring.md).
const MAINTENANCE: Pin = Pin::new('A', 7);
const STRAPS: [Pin; 5] =
    [Pin::new('A', 2), Pin::new('A', 3), Pin::new('A', 4), Pin::new('A', 5), Pin::new('A', 6)];

/// Three copies of a Node-ID, computed on paper: number, Node-ID, CRC of x5 + x2 + 1, without parity.
const COPIES: [(u8, [u16; 3]); 4] = [
    (2, [0x5044, 0x6056, 0x7058]),
    (3, [0x5061, 0x6073, 0x707D]),
    (5, [0x50BF, 0x60AD, 0x70A3]),
    (7, [0x50F5, 0x60E7, 0x70E9]),
];

fn copies(node: u8) -> [u16; 3] {
    COPIES.into_iter().find(|(known, _)| *known == node).unwrap().1
}

fn setup(node: u8) -> BoardSetup {
    BoardSetup { node, ..MASTER_AND_THREE[2] }
}

/// Writes a log with these copies into the flash of a board.
fn store(flight: &mut Flight, node: u8, copies: &[u16]) {
    let board = flight.emulated_mut(node);
    let at = board.symbol("__store_start").unwrap().address;
    // Fifteen bits, even parity, and the complement of all of them.
    let word = |number: u16| {
        let low = number | (number.count_ones() as u16 & 1) << 15;
        [low.to_le_bytes(), (!low).to_le_bytes()].concat()
    };
    let log = [b"CE\xBC\xBA".to_vec(), word(1)].into_iter().chain(copies.iter().map(|copy| word(*copy)));
    board.write_flash(at, &log.collect::<Vec<_>>().concat()).unwrap();
}

/// Returns the copies in a page of the log in the flash of a board that were not replaced.
fn stored(flight: &Flight, node: u8, page: u32) -> Vec<u16> {
    let board = flight.emulated(node);
    let at = board.symbol("__store_start").unwrap().address + page * 128 * 1024;
    let bytes = board.read_memory(at + 8, 64).unwrap();
    let words = bytes.chunks(4).map(|word| u16::from_le_bytes([word[0], word[1]]));
    words.filter(|word| ![0, 0xFFFF].contains(word)).map(|word| word & 0x7FFF).collect()
}

/// Ties the straps of a board; `None` leaves all open.
fn strap(flight: &mut Flight, node: u8, value: Option<u8>) {
    let bits = value.map_or(0, |id| id | u8::from(id.count_ones() % 2 == 0) << 4);
    for (bit, pin) in STRAPS.into_iter().enumerate() {
        flight.emulated_mut(node).drive(pin, (bits >> bit & 1 == 1).then_some(false));
    }
}

fn set_maintenance(flight: &mut Flight, node: u8, is_closed: bool) {
    flight.emulated_mut(node).drive(MAINTENANCE, is_closed.then_some(false));
}

const READ: [u8; 8] = [0x40, 0x46, 0x20, 1, 0, 0, 0, 0];

/// Returns the request that stores this Node-ID: the Node-ID, its complement, "ID".
const fn storing(id: u8) -> [u8; 8] {
    [0x23, 0x46, 0x20, 1, id, !id, 0x49, 0x44]
}

/// Given boards with straps, stored copies, both or neither, when they are powered, then each has the Node-ID on which
/// both agree, or is silent.
///
/// Verifies: ECSS 6.10e, 6.10f, 6.10k
#[test]
fn a_board_is_who_straps_and_store_agree_on_or_silent() {
    let mut flight = Flight::new(&[MASTER_AND_THREE[0], setup(2), setup(3), setup(5), setup(6), setup(8)]);
    store(&mut flight, 2, &copies(2));
    // One bit has flipped: two copies are left.
    let [first, second, third] = copies(3);
    store(&mut flight, 3, &[first ^ 1 << 6, second, third]);
    // No straps: the store decides.
    strap(&mut flight, 5, None);
    store(&mut flight, 5, &copies(5));
    // The store contradicts the straps.
    store(&mut flight, 6, &copies(7));
    // No straps, and no two copies agree.
    strap(&mut flight, 8, None);
    store(&mut flight, 8, &[copies(2)[0], copies(3)[1]]);
    flight.fly_to(1000);
    flight.assert_operational([2, 3, 5], Bus::Nominal);
    assert_eq!(stored(&flight, 2, 0), copies(2), "nothing is written");
    assert_eq!(stored(&flight, 3, 1), copies(3), "in the other page: three copies again");
    for (node, why) in [(6, "Contradiction"), (8, "Missing")] {
        flight.assert_said(node, why, ms(0));
        flight.assert_said(node, "staying silent", ms(0));
        flight.assert_absent(node, ms(0));
    }
    flight.assert_sound();
}

/// Given a board with the strap of maintenance mode, when a client stores a Node-ID, then the board has it at the next start
/// without that strap.
///
/// Verifies: ECSS 6.10g, 6.10j
#[test]
fn a_node_id_stored_in_maintenance_mode_flies_after_a_reset() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..3], Bus::Nominal);
    set_maintenance(&mut flight, 3, true);
    // A master that starts all nodes, resets all nodes, and is lost. A board in maintenance mode ignores all this.
    flight.twin.inject(guest, ms(700), WireFrame::standard(0x000, &[0x01, 0]));
    flight.twin.inject(guest, ms(720), WireFrame::standard(0x000, &[0x82, 0]));
    flight.fly_to(1000);
    assert_eq!(flight.driven(3, ms(0)), 0, "{}", flight.log(3));
    let acknowledged = flight.on(Bus::Nominal).any(|seen| seen.end > ms(500) && seen.reached.contains(&3));
    assert!(acknowledged, "{}", flight.log(3));
    assert_eq!(flight.ask(guest, 127, READ)[4..], [0; 4], "nothing is stored");
    // Neither the Node-ID of the master nor one without its complement is accepted: 06090030h, 08000020h.
    assert_eq!(flight.ask(guest, 127, storing(1))[4..], [0x30, 0x00, 0x09, 0x06]);
    let [.., complement, i, d] = storing(7);
    let wrong = [0x23, 0x46, 0x20, 1, 5, complement, i, d];
    assert_eq!(flight.ask(guest, 127, wrong)[4..], [0x20, 0x00, 0x00, 0x08]);
    assert!(stored(&flight, 3, 0).is_empty());
    assert_eq!(flight.ask(guest, 127, storing(7))[..4], [0x60, 0x46, 0x20, 1]);
    assert_eq!(stored(&flight, 3, 0), copies(7));
    assert_eq!(flight.ask(guest, 127, READ), [0x43, 0x46, 0x20, 1, 7, 0, 0, 0]);

    // Its straps are still those of 3.
    set_maintenance(&mut flight, 3, false);
    flight.reset(3);
    let from = flight.end;
    flight.fly(from + ms(300));
    flight.assert_said(3, "Contradiction", from);
    assert_eq!(flight.driven(3, from), 0);

    strap(&mut flight, 3, Some(7));
    flight.reset(3);
    let from = flight.end;
    flight.fly(from + ms(700));
    let said = || flight.of(3).filter(|seen| seen.end > from);
    let last = said().rfind(|seen| seen.id() == Some(0x707)).map(|seen| seen.data()[0]);
    assert_eq!(last, Some(OPERATIONAL), "{}", flight.log(3));
    assert!(said().all(|seen| seen.id() != Some(0x703)), "nothing under the old one");
    flight.assert_operational([2], Bus::Nominal);
}

/// Given a NUCLEO-F446RE with its own strap of maintenance mode, when a client stores a Node-ID, then its flash has it.
///
/// Verifies: ECSS 6.10g
#[test]
fn a_board_of_the_other_model_has_maintenance_mode_too() {
    let nucleo = BoardSetup { board: NUCLEO_F446RE, ..setup(3) };
    let (mut flight, guest) =
        Flight::with_guest(&[MASTER_AND_THREE[0], MASTER_AND_THREE[1], nucleo], Bus::Nominal);
    flight.emulated_mut(3).drive(Pin::new('A', 4), Some(false));
    flight.fly_to(500);
    assert_eq!(flight.driven(3, ms(0)), 0, "{}", flight.log(3));
    assert_eq!(flight.ask(guest, 127, storing(7))[..4], [0x60, 0x46, 0x20, 1]);
    assert_eq!(stored(&flight, 3, 0), copies(7));
}

/// Verifies: ECSS 6.10g
#[test]
fn no_node_id_is_stored_outside_of_maintenance_mode() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..3], Bus::Nominal);
    flight.fly_to(1000);
    // 08000022h, also in Pre-operational.
    for command in [0x01, 0x80] {
        flight.twin.inject(guest, flight.end, WireFrame::standard(0x000, &[command, 3]));
        assert_eq!(flight.ask(guest, 3, storing(7)), [0x80, 0x46, 0x20, 1, 0x22, 0x00, 0x00, 0x08]);
    }
    assert_eq!(flight.ask(guest, 3, READ)[4..], [0; 4]);
    assert!(stored(&flight, 3, 0).is_empty());
    flight.assert_sound();
}

/// Given straps that change in flight, when NMT resets the board, then it keeps its Node-ID. When its reset pin is
/// pulled, it enters maintenance mode by its straps.
///
/// Verifies: ECSS 6.10g, 6.10k
#[test]
fn a_reset_by_command_takes_no_strap_that_changed_in_flight() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..3], Bus::Nominal);
    flight.fly_to(1000);
    for straps in [Some(3), Some(5), None] {
        println!("straps {straps:?}");
        // The last one: 3, and maintenance mode.
        set_maintenance(&mut flight, 3, straps.is_none());
        strap(&mut flight, 3, straps.or(Some(3)));
        let from = flight.end;
        flight.twin.inject(guest, from, WireFrame::standard(0x000, &[0x81, 3]));
        flight.fly(from + ms(700));
        let heartbeats = flight.heartbeats(3, Bus::Nominal);
        let boots = heartbeats.iter().any(|(at, state)| *at > from && *state == BOOT_UP);
        assert!(boots, "{straps:?}\n{}", flight.log(3));
        flight.assert_operational([3], Bus::Nominal);
    }
    flight.reset(3);
    let from = flight.end;
    flight.fly(from + ms(700));
    assert_eq!(flight.driven(3, from), 0, "{}", flight.log(3));
    assert_eq!(flight.ask(guest, 127, READ)[..4], [0x43, 0x46, 0x20, 1]);
}
