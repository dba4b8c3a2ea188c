//! Before its boot-up message a node is in Initialising for all others (CiA 301 7.3.2.2.1, 7.2.8.3.3).
//!
//! Verifies: ECSS 6.5.3a, 6.5.4a

use crate::bench::{Bench, NOMINAL, frame, ms, node};
use crate::canopen_slave;
use crate::instrument::{self, STANDARD};
use crate::slave::TestSlave;

/// Upload of 1000h.
const REQUEST: [u8; 8] = [0x40, 0x00, 0x10, 0, 0, 0, 0, 0];

fn alone() -> Bench<TestSlave> {
    let mut slave = Bench::alone(instrument::slave(node(5), &STANDARD, vec![0; 1024]));
    slave.run_until(ms(1));
    slave.clear();
    slave
}

/// Given a slave whose boot-up message is not acknowledged yet, when a request arrives, then it is not answered: its client takes the answer
/// for one of the life before, and what it writes is lost to it. The next request after that message is answered.
#[test]
fn a_request_before_the_boot_up_message_is_not_answered() {
    let mut slave = alone();
    slave.receive(NOMINAL, 0x605, &REQUEST);
    slave.receive(NOMINAL, 0x605, &[0x23, 0x20, 0x10, 1, 1, 0, 0, 0]);
    assert_eq!(slave.frames(), []);
    slave.transmitted(NOMINAL, frame(0x705, &[0]));
    slave.receive(NOMINAL, 0x605, &[0x40, 0x20, 0x10, 1, 0, 0, 0, 0]);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x585, &[0x43, 0x20, 0x10, 1, 0, 0, 0, 0]))]);
}

/// Given a slave that is reset while one of its heartbeats waits in the controller, when that goes out, then its boot-up message is still to
/// come.
#[test]
fn a_heartbeat_of_the_life_before_is_no_boot_up_message() {
    let mut slave = alone();
    slave.transmitted(NOMINAL, frame(0x705, &[0x05]));
    slave.receive(NOMINAL, 0x605, &REQUEST);
    assert_eq!(slave.frames(), []);
    slave.run_until(ms(100));
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x705, &[0]))]);
}

/// The same on one bus.
#[test]
fn a_slave_on_one_bus_answers_after_its_boot_up_message() {
    let mut slave = Bench::alone(canopen_slave::slave());
    slave.run_until(ms(1));
    slave.clear();
    slave.receive(NOMINAL, 0x605, &REQUEST);
    assert_eq!(slave.frames(), []);
    slave.transmitted(NOMINAL, frame(0x705, &[0]));
    slave.receive(NOMINAL, 0x605, &REQUEST);
    assert_eq!(slave.frames().len(), 1, "{:?}", slave.frames());
}
