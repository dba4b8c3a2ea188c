//! The check of the program in flash.

use can_twin::spacecraft::{Bus, GuestId};
use flight::*;

const SLAVE: u8 = 2;
/// The node has its result after a pass of 0.8 s and the next heartbeat.
const PASS_MS: u64 = 1_500;
/// Values of object 2033h sub 3.
const UNCHECKED: u8 = 0;
const WHOLE: u8 = 1;
const DAMAGED: u8 = 2;
const MENDED: u8 = 3;

/// A master and a slave, after the check of its program.
fn checked() -> (Flight, GuestId) {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..2], Bus::Nominal);
    flight.fly_to(PASS_MS);
    (flight, guest)
}

/// The seal of the slave's program: its address, and the length of the program.
fn seal(flight: &Flight) -> (u32, u32) {
    let seal = flight.emulated(SLAVE).symbol("__program_seal").expect("a seal").address;
    (seal, word_at(flight, SLAVE, seal))
}

/// Returns 2033h sub 3 of the slave.
fn state(flight: &mut Flight, guest: GuestId) -> u8 {
    let answer = flight.ask(guest, SLAVE, [0x40, 0x33, 0x20, 3, 0, 0, 0, 0]);
    assert_eq!(answer[..4], [0x4F, 0x33, 0x20, 3]);
    answer[4]
}

/// Flips bits of the last byte of the slave's program, an initial value of a variable that no instruction reads in flight, and flies
/// two passes of the check.
fn flip(flight: &mut Flight, bits: &[u32]) {
    let last = 0x0800_0000 + seal(flight).1 - 1;
    for bit in bits {
        flight.emulated_mut(SLAVE).flip_memory(last, *bit).unwrap();
    }
    flight.fly(flight.end + ms(2 * PASS_MS));
}

/// Given a slave, when two bits of its program flip, then one emergency reports that, and it goes on. When the bits flip back,
/// another one reports the end.
///
/// Verifies: ECSS 6.4a, 6.4a.1, 6.4a.2
#[test]
fn damaged_program_is_reported_once() {
    let (mut flight, guest) = checked();
    assert_eq!(state(&mut flight, guest), WHOLE);
    let mut expected: Vec<[u8; 8]> = Vec::new();
    let reports = [(DAMAGED, [0x00, 0x50, 1, 3, 0, 0, 0, 0]), (WHOLE, [0, 0, 0, 0, 0x50, 3, 0, 0])];
    for (result, report) in reports {
        flip(&mut flight, &[3, 5]);
        assert_eq!(state(&mut flight, guest), result);
        expected.push(report);
        let reported: Vec<&[u8]> = flight.emergencies(SLAVE, ms(0)).collect();
        assert_eq!(reported, expected, "{}", flight.log(SLAVE));
    }
    flight.assert_operational([SLAVE], Bus::Nominal);
    assert_eq!(resets(&flight, SLAVE), 0);
}

/// Given a slave, when a bit of its program flips, then the core reads the right word in its place after a pass, one emergency reports
/// that, and it goes on. After a second flipped bit in the same word, the program is mended no longer.
#[test]
fn flipped_bit_of_the_program_is_mended() {
    let (mut flight, guest) = checked();
    flip(&mut flight, &[5]);
    assert_eq!(state(&mut flight, guest), MENDED);
    let reported: Vec<&[u8]> = flight.emergencies(SLAVE, ms(0)).collect();
    assert_eq!(reported, [[0x00, 0x50, 1, 3, 0, 0, 0, 0]], "{}", flight.log(SLAVE));
    flight.assert_operational([SLAVE], Bus::Nominal);
    assert_eq!(resets(&flight, SLAVE), 0);
}

/// Given a slave, when a bit flips of the first instruction of the handler of a controller's interrupt, which then faults, then the slave
/// is reset once and operational again, with a mended program.
#[test]
fn program_that_faults_is_mended_by_the_reset() {
    let (mut flight, guest) = checked();
    let handler = flight.emulated(SLAVE).symbol("CAN1_RX0").expect("a handler").address & !1;
    // PUSH becomes ADR, so that POP takes from the stack what others have put there.
    flight.emulated_mut(SLAVE).flip_memory(handler + 1, 4).unwrap();
    flight.fly(flight.end + ms(2 * PASS_MS));
    assert_eq!(resets(&flight, SLAVE), 1, "{}", flight.log(SLAVE));
    flight.assert_operational([SLAVE], Bus::Nominal);
    assert_eq!(state(&mut flight, guest), MENDED);
}

/// Given an image as the linker leaves it, with an erased seal, then its program is not checked, and nothing is reported.
#[test]
fn program_without_a_seal_is_not_checked() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..2], Bus::Nominal);
    let seal = seal(&flight).0;
    flight.emulated_mut(SLAVE).write_flash(seal, &[0xFF; 8]).unwrap();
    flight.fly_to(PASS_MS);
    assert_eq!(state(&mut flight, guest), UNCHECKED);
    assert_eq!(flight.emergencies(SLAVE, ms(0)).next(), None);
    flight.assert_operational([SLAVE], Bus::Nominal);
}

/// Given the image of a minimal slave with an erased seal, then it is not checked either.
#[test]
fn minimal_program_without_a_seal_is_not_checked() {
    let mut flight = minimal::librecube(&[minimal::MASTER_SETUP, minimal::SETUP]);
    let seal = flight.emulated(minimal::MINIMAL).symbol("__program_seal").expect("a seal").address;
    flight.emulated_mut(minimal::MINIMAL).write_flash(seal, &[0xFF; 8]).unwrap();
    flight.fly_to(1_000);
    assert!(flight.of(minimal::MINIMAL).count() > 0, "{}", flight.log(minimal::MINIMAL));
}

/// Given the parameters of a slave, when it saves them to the flash behind its program, then the program is still whole.
#[test]
fn saved_parameters_are_no_part_of_the_program() {
    let (mut flight, guest) = checked();
    let before = flight.emulated(SLAVE).counters().flash_programs;
    // "save" to 1010h sub 1.
    let answer = flight.ask(guest, SLAVE, [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e']);
    assert_eq!(answer[0], 0x60);
    assert!(flight.emulated(SLAVE).counters().flash_programs > before);
    flight.fly(flight.end + ms(2 * PASS_MS));
    assert_eq!(state(&mut flight, guest), WHOLE);
}
