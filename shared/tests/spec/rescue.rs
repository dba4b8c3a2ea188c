//! Resets by the master of slaves that do not recover by themselves. Profile `standard`: consumer time 250 ms.

use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::MasterRequest;

use crate::bench::{Bench, Master, NOMINAL, frame, ms, node};
use crate::console;
use crate::instrument::STANDARD;

/// Answer to the question for the device type.
const DEVICE_TYPE: [u8; 8] = [0x43, 0, 0x10, 0, 0, 0, 0, 0];

/// A master, and slaves 2 and 3, which count and were heard at 10 ms.
fn flying() -> Bench<Master> {
    let mut master = Bench::new(console::master(&STANDARD));
    master.run_until(ms(10));
    master.transmitted(NOMINAL, frame(0x701, &[0x05]));
    for raw in [2, 3] {
        master.receive(NOMINAL, 0x700 + raw, &[0x05]);
    }
    for raw in [2, 3] {
        master.receive(NOMINAL, 0x580 + raw, &DEVICE_TYPE);
    }
    master.clear();
    master
}

/// Runs it to `until`. Slave 2 sends this state each 100 ms. All heartbeats of the master are acknowledged.
fn run(master: &mut Bench<Master>, until: u64, state: u8) {
    while master.now < ms(until) {
        let next = master.now.as_micros() / 100_000 * 100 + 100;
        master.run_until(ms(next));
        master.transmitted(NOMINAL, frame(0x701, &[0x05]));
        master.receive(NOMINAL, 0x702, &[state]);
    }
}

/// Times at which the master sent "reset node" to a node.
fn resets(master: &Bench<Master>, raw: u8) -> Vec<u64> {
    let reset = frame(0x000, &[0x81, raw]);
    let all = master.sent.iter().filter(|sent| sent.frame == reset);
    all.map(|sent| sent.at.as_micros() / 1_000).collect()
}

/// Given a slave that is lost on a bus where others acknowledge, then the master resets it after 5 s, and again after pauses of 10,
/// 20 and 40 s. It resets no other slave.
#[test]
fn a_lost_slave_is_reset_after_bounded_times() {
    let mut master = flying();
    run(&mut master, 90_000, 5);
    // Lost 250 ms after its heartbeat at 10 ms. A reset that waits for other frames is later by at most a turn.
    let times = resets(&master, 3);
    let expected = [5_260, 15_270, 35_280, 75_290];
    assert_eq!(times.len(), expected.len(), "{times:?}");
    assert!(times.iter().zip(expected).all(|(time, expected)| time.abs_diff(expected) <= 100), "{times:?}");
    assert_eq!(resets(&master, 2), [0; 0]);
}

/// Given a slave that was lost and reset, when it is heard again and lost later, then the master resets it 5 s after that.
#[test]
fn a_slave_that_returned_is_reset_as_the_first_time() {
    let mut master = flying();
    run(&mut master, 10_000, 5);
    assert_eq!(resets(&master, 3).len(), 1);
    master.receive(NOMINAL, 0x703, &[0x05]);
    master.clear();
    run(&mut master, 16_000, 5);
    let times = resets(&master, 3);
    assert!(matches!(times[..], [time] if time.abs_diff(15_250) <= 100), "{times:?}");
}

/// Given a slave that stays in Stopped and was not stopped by the application, then the master commands it, and resets it after
/// 5 s. Given one that the application stopped, then it stays so.
#[test]
fn a_slave_that_stays_in_stopped_is_reset_unless_it_was_stopped() {
    let mut master = flying();
    master.receive(NOMINAL, 0x703, &[0x05]);
    run(&mut master, 7_000, 4);
    let times = resets(&master, 2);
    assert!(matches!(times[..], [time] if time.abs_diff(5_100) <= 200), "{times:?}");

    let mut master = flying();
    let message = NmtMessage { command: Command::Stop, target: Target::Node(node(2)) };
    master.request(MasterRequest::Nmt(message));
    run(&mut master, 60_000, 4);
    assert_eq!(resets(&master, 2), [0; 0]);
}
