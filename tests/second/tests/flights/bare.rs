//! A slave on chip support alone, without `ecss-can-runtime` and without a log: `firmware/fixtures`.

use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::frame::WireFrame;
use flight::*;

const SLAVE: u8 = 3;
const PANIC: u8 = 1;
const LATE_TASK: u8 = 4;

/// Returns a flight in which all nodes are operational, and a client.
fn flown() -> (Flight, GuestId) {
    let bare = parsed(&ecss_can_cli::images::build_fixture("test-bare", "standard").unwrap());
    let [master, slave] = STANDARD.clone();
    let config = move |setup: BoardSetup| {
        let slave = if setup.node == SLAVE { bare.clone() } else { slave.clone() };
        setup.with(&[master.clone(), slave])
    };
    let mut flight = Flight::of(&MASTER_AND_THREE[..3], config);
    let client = flight.twin.add_guest(Bus::Redundant, 30.0);
    flight.fly_to(1_000);
    (flight, client)
}

/// Returns causes and program counters of the emergencies 6100h of the slave, on either bus. The slave repeats them
/// when it finds its master.
fn causes(flight: &Flight) -> Vec<(u8, [u8; 4])> {
    let raised = flight.emergencies(SLAVE, ms(0)).filter(|data| data[..2] == [0x00, 0x61]);
    let mut causes: Vec<_> = raised.map(|data| (data[3], data[4..].try_into().unwrap())).collect();
    causes.dedup();
    causes
}

/// Given the shipped master and an image without `ecss-can-runtime`, then both are operational on the nominal bus, and
/// after a cut on the other one. The image logs nothing.
#[test]
fn an_image_on_chip_support_alone_flies_and_changes_the_bus() {
    let (mut flight, _) = flown();
    flight.assert_operational([SLAVE], Bus::Nominal);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(3_000);
    flight.assert_operational([SLAVE], Bus::Redundant);
    assert_eq!(flight.log(SLAVE), "");
    assert_eq!(flight.lost_frames(SLAVE), 0);
}

/// Given the handler of SysTick and that of panics of the image itself, which know no program counter, when a task
/// hangs or the application panics, then the board is reset, reports the cause, and is operational again.
#[test]
fn its_own_handlers_end_a_program_that_hangs_or_panics() {
    let (mut flight, client) = flown();
    let due = task_named(&flight, SLAVE, b"due ");
    end_program(&mut flight, SLAVE, due, &halfwords(&HANG));
    flight.fly(flight.end + ms(1_500));
    // The master has changed the bus meanwhile.
    assert_eq!(causes(&flight), [(LATE_TASK, [0; 4])]);
    flight.assert_operational([SLAVE], Bus::Redundant);

    // Brightness 201 of 200.
    let too_bright = WireFrame::standard(0x603, &[0x2F, 0x00, 0x60, 0, 201, 0, 0, 0]);
    flight.twin.inject(client, flight.end, too_bright);
    flight.fly(flight.end + ms(1_500));
    assert_eq!(causes(&flight), [(LATE_TASK, [0; 4]), (PANIC, [0; 4])], "{}", flight.log(MASTER));
    assert!(Bus::ALL.into_iter().any(|bus| flight.is_operational(SLAVE, bus)), "{}", flight.log(MASTER));
}
