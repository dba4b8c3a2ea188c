//! Upsets that the board finds in its registers: object 2033h, and the emergency that reports them.

use ecss_can::node::{FoundUpsets, Hardware, Master, ProgramState, Upsets};

use super::fixture::{payloads, powered, read, run_with_master};
use crate::bench::{Bench, NOMINAL, frame, ms, node, span};
use crate::instrument::{self, STANDARD};
use crate::slave::TestSlave;
use crate::{console, master_device};

/// Hardware of a board that finds these upsets.
fn hardware(upsets: &'static Upsets) -> Hardware {
    let mut hardware = Hardware::default();
    hardware.upsets = Some(upsets);
    hardware
}

/// A slave in operation, on a board that finds these upsets.
fn slave(upsets: &'static Upsets) -> Bench<TestSlave> {
    let mut slave =
        Bench::new(instrument::builder(node(5), &STANDARD, vec![]).hardware(hardware(upsets)).build());
    run_with_master(&mut slave, ms(500));
    slave.clear();
    slave
}

/// Given a slave, when its board mends two registers between two heartbeats, then one emergency has the address of the last one, and
/// 2033h has number and address.
///
/// Verifies: ECSS 6.4a, 6.4a.1
/// Notices: ECSS 6.4a.1: each register that is mended sends an emergency of its own.
#[test]
fn mended_registers_are_reported_after_the_next_heartbeat() {
    static UPSETS: Upsets = Upsets::new();
    let mut slave = slave(&UPSETS);
    UPSETS.count_mended(0x4000_6600);
    UPSETS.count_mended(0x4000_661C);
    slave.transmitted(NOMINAL, frame(0x705, &[0x7F]));
    slave.transmitted(NOMINAL, frame(0x705, &[0x7F]));
    let until = slave.now + span(500);
    run_with_master(&mut slave, until);
    let reports = payloads(&slave, 0x085);
    // An emergency of an error that is over: the report, and its end.
    assert_eq!(reports[0], [0x00, 0x50, 0x01, 2, 0x1C, 0x66, 0x00, 0x40]);
    assert_eq!((reports.len(), reports[1][..2].to_vec()), (2, vec![0, 0]));
    assert_eq!(read(&mut slave, 0x2033, 1), [2, 0, 0, 0]);
    assert_eq!(read(&mut slave, 0x2033, 2), [0x1C, 0x66, 0x00, 0x40]);
}

/// Given a board that finds no upset, then nothing is reported.
///
/// Verifies: ECSS 6.4a
#[test]
fn board_without_upsets_reports_none() {
    static UPSETS: Upsets = Upsets::new();
    let mut slave = slave(&UPSETS);
    slave.transmitted(NOMINAL, frame(0x705, &[0x7F]));
    let until = slave.now + span(2_000);
    run_with_master(&mut slave, until);
    assert_eq!(payloads(&slave, 0x085), [[0; 8]; 0]);
    assert_eq!(read(&mut slave, 0x2033, 1), [0; 4]);
    assert_eq!(read(&mut powered(), 0x2033, 1), [0; 4], "a board that looks for none");
}

/// Given the master, when its board mends a register, then an emergency has the address.
///
/// Verifies: ECSS 6.4a, 6.4a.1
#[test]
fn mended_register_of_the_master_is_reported() {
    static UPSETS: Upsets = Upsets::new();
    let master = Master::builder(&STANDARD, console::Console::default()).hardware(hardware(&UPSETS));
    let mut master = Bench::new(master.build());
    master.run_until(ms(1));
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    master.run_until(ms(1_000));
    UPSETS.count_mended(0x4002_3840);
    master.clear();
    let until = master.now + span(500);
    master.run_until(until);
    let emergency = master.sent.iter().find(|sent| sent.frame.id().raw() == 0x081).expect("an emergency");
    assert_eq!(emergency.frame.data(), [0x00, 0x50, 0x01, 2, 0x40, 0x38, 0x02, 0x40]);
    assert_eq!(master_device::read(&mut master, 0x2033, 1), 1);
    assert_eq!(master_device::read(&mut master, 0x2033, 2), 0x4002_3840);
}

/// Given more upsets than the object counts, then it stays at its largest value.
#[test]
fn count_of_mended_registers_stays_at_its_largest_value() {
    let upsets = Upsets::new();
    (0..=u32::from(u16::MAX)).for_each(|address| upsets.count_mended(address));
    let FoundUpsets { registers, last, .. } = upsets.found();
    assert_eq!((registers, last), (u16::MAX, 0xFFFF));
}

/// Given a slave, when its board finds that the program is damaged, then one emergency reports that, and another one its end when the
/// program is whole again. 2033h has the state.
///
/// Verifies: ECSS 6.4a, 6.4a.1
/// Notices: ECSS 6.4a.1: each heartbeat reports the damaged program again.
#[test]
fn damaged_program_is_reported_until_it_is_whole() {
    static UPSETS: Upsets = Upsets::new();
    let mut slave = slave(&UPSETS);
    assert_eq!(read(&mut slave, 0x2033, 3), [0, 0, 0, 0], "not checked");
    for (state, number, report) in [
        (ProgramState::Whole, 1, None),
        (ProgramState::Damaged, 2, Some([0x00, 0x50, 0x01, 3, 0, 0, 0, 0])),
        (ProgramState::Whole, 1, Some([0, 0, 0, 0, 0x50, 3, 0, 0])),
    ] {
        UPSETS.set_program(state);
        for _ in 0..2 {
            slave.transmitted(NOMINAL, frame(0x705, &[0x7F]));
            let until = slave.now + span(500);
            run_with_master(&mut slave, until);
        }
        let reports: Vec<[u8; 8]> = report.into_iter().collect();
        assert_eq!(payloads(&slave, 0x085), reports, "{state:?}");
        assert_eq!(read(&mut slave, 0x2033, 3), [number, 0, 0, 0], "{state:?}");
    }
}
