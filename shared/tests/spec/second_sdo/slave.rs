//! Two SDO servers of a slave of a spacecraft: saves, stored parameters, a change of the bus, the budget of the node.
//!
//! Verifies: ECSS 6.1a

use ecss_can::node::Node;
use ecss_can::sdo::Mode;
use ecss_can::store::ParameterStore;

use super::{
    BLOCK, BOTH, Channel, DEVICE_STATE, FIRST, SECOND, SECOND_SDO, SPARE, TestSlave, Transfer, answers, ask,
    fill, open, pattern, read, run, spacecraft_slave, stored_slave, write,
};
use crate::bench::{NOMINAL, REDUNDANT, span};
use crate::device::fixture::{Memory, done, initiate, refused};

/// Expedited download of "save" to 1010h sub 1.
const SAVE: [u8; 8] = [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'];
const ABORT: [u8; 8] = [0x80, 0x10, 0x10, 1, 0, 0, 0, 0x08];

fn opened_with(memory: &Memory) -> TestSlave {
    let mut slave = stored_slave(Some(memory));
    open(&mut slave);
    slave
}

/// Given a save that one client requested, then that client gets the answer at its end, also if the other client aborts and reads
/// meanwhile.
#[test]
fn a_save_is_answered_to_the_client_that_requested_it() {
    let memory = Memory::default();
    let mut slave = opened_with(&memory);
    for [one, other] in [[SECOND, FIRST], [FIRST, SECOND]] {
        slave.clear();
        slave.receive(NOMINAL, one.request, &SAVE);
        slave.receive(NOMINAL, other.request, &ABORT);
        assert_eq!(answers(&slave, one), [[0; 8]; 0], "it runs");
        assert_eq!(ask_during_save(&mut slave, other, SAVE), refused(0x1010, 1, DEVICE_STATE));
        let read = [0x40, 0x00, 0x60, 0, 0, 0, 0, 0];
        assert_eq!(ask_during_save(&mut slave, other, read)[0], 0x43);
        slave.clear();
        slave.finish_save();
        assert_eq!(answers(&slave, one), [done(0x1010, 1)]);
        assert_eq!(answers(&slave, other), [[0; 8]; 0]);
        // Who aborts gets no answer.
        slave.receive(NOMINAL, one.request, &SAVE);
        let until = slave.now + span(6_000);
        keep_alive(&mut slave, until);
        slave.clear();
        slave.receive(NOMINAL, one.request, &SAVE);
        slave.receive(NOMINAL, one.request, &ABORT);
        slave.finish_save();
        assert_eq!(BOTH.map(|channel| answers(&slave, channel).len()), [0, 0]);
        let until = slave.now + span(6_000);
        keep_alive(&mut slave, until);
    }
    assert_ne!(memory.stored_len(), 0);
}

/// The answer to a request that does not wait for the end of the save.
fn ask_during_save(slave: &mut TestSlave, channel: Channel, request: [u8; 8]) -> [u8; 8] {
    slave.clear();
    slave.receive(NOMINAL, channel.request, &request);
    let [answer] = answers(slave, channel)[..] else { panic!("one answer: {:?}", slave.sent) };
    answer
}

/// Time passes, with heartbeats of the master.
fn keep_alive(slave: &mut TestSlave, until: ecss_can::types::Instant) {
    while slave.now < until {
        slave.run_until((slave.now + span(100)).min(until));
        slave.receive(NOMINAL, 0x701, &[5]);
    }
}

/// Given a client that writes a block or a number in segments, when the other one requests a save or a restore, then it gets 0800 0022h:
/// what is stored does not change meanwhile.
#[test]
fn no_save_begins_while_the_other_client_writes() {
    let mut slave = opened_with(&Memory::default());
    let load = [0x23, 0x11, 0x10, 1, b'l', b'o', b'a', b'd'];
    for [one, other] in [[FIRST, SECOND], [SECOND, FIRST]] {
        for begun in [initiate(BLOCK, 0, 100), initiate(0x6000, 0, 4)] {
            assert_eq!(ask(&mut slave, one, begun)[0], 0x60);
            assert_eq!(ask(&mut slave, other, SAVE), refused(0x1010, 1, DEVICE_STATE));
            assert_eq!(ask(&mut slave, other, load), refused(0x1011, 1, DEVICE_STATE));
            slave.receive(NOMINAL, one.request, &[0x80, 0, 0, 0, 0, 0, 0, 0x08]);
        }
        // A reader does not disturb it.
        fill(&mut slave, BLOCK, &pattern(30, 1));
        assert_eq!(ask(&mut slave, one, [0x40, 0x00, 0x63, 0, 0, 0, 0, 0])[0], 0x41);
        assert_eq!(ask(&mut slave, other, SAVE), done(0x1010, 1));
        slave.receive(NOMINAL, one.request, &[0x80, 0, 0, 0, 0, 0, 0, 0x08]);
        let until = slave.now + span(6_000);
        keep_alive(&mut slave, until);
    }
}

/// Given a stored channel, then it works from power-on and after reset communication, until its default is restored.
///
/// Verifies: ECSS 6.8a
#[test]
fn a_stored_channel_is_valid_after_each_reset() {
    let memory = Memory::default();
    let mut slave = opened_with(&memory);
    assert_eq!(write(&mut slave, SECOND, SECOND_SDO, 3, &[9]), done(SECOND_SDO, 3));
    // 1010h sub 2: communication parameters.
    assert_eq!(ask(&mut slave, SECOND, [0x23, 0x10, 0x10, 2, b's', b'a', b'v', b'e']), done(0x1010, 2));
    let mut slave = stored_slave(Some(&memory));
    for _ in 0..2 {
        let values = [1, 2, 3].map(|sub| read(&mut slave, SECOND, SECOND_SDO, sub));
        assert_eq!(values, [SECOND.request.into(), SECOND.answer.into(), 9]);
        assert!(slave.admits(REDUNDANT, SECOND.request));
        slave.receive(NOMINAL, 0x000, &[0x82, 5]);
        let until = slave.now + span(5);
        slave.run_until(until);
    }
    assert_eq!(ask(&mut slave, SECOND, [0x23, 0x11, 0x10, 2, b'l', b'o', b'a', b'd']), done(0x1011, 2));
    let mut slave = stored_slave(Some(&memory));
    assert_eq!(read(&mut slave, FIRST, SECOND_SDO, 1), 0x8000_0000);
}

/// Given transfers of both servers, when the active bus changes, then each client gets the abort 0800 0022h on the new bus.
///
/// Verifies: ECSS 5.3.3.2.3i
#[test]
fn a_change_of_the_bus_ends_both_transfers() {
    let mut slave = spacecraft_slave();
    open(&mut slave);
    assert_eq!(ask(&mut slave, FIRST, initiate(BLOCK, 0, 100)), done(BLOCK, 0));
    assert_eq!(ask(&mut slave, SECOND, initiate(SPARE, 0, 100)), done(SPARE, 0));
    slave.clear();
    slave.receive(REDUNDANT, 0x701, &[5]);
    assert_eq!(answers(&slave, FIRST), [refused(BLOCK, 0, DEVICE_STATE)]);
    assert_eq!(answers(&slave, SECOND), [refused(SPARE, 0, DEVICE_STATE)]);
    let is_sdo = |id: u16| BOTH.iter().any(|channel| channel.answer == id);
    let mut sent = slave.sent.iter().filter(|sent| is_sdo(sent.frame.id().raw()));
    assert!(sent.all(|sent| sent.bus == REDUNDANT));
    // The channel works there, and no longer on the other bus.
    slave.clear();
    slave.receive(NOMINAL, SECOND.request, &[0x40, 0x00, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(answers(&slave, SECOND), [[0; 8]; 0]);
    slave.receive(REDUNDANT, SECOND.request, &[0x40, 0x00, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(answers(&slave, SECOND).len(), 1);
}

/// Given transfers of both servers, when the communication is reset, then they end without an abort.
#[test]
fn reset_communication_ends_both_transfers() {
    let mut slave = opened_with(&Memory::default());
    assert_eq!(ask(&mut slave, FIRST, initiate(BLOCK, 0, 100)), done(BLOCK, 0));
    assert_eq!(ask(&mut slave, SECOND, initiate(SPARE, 0, 100)), done(SPARE, 0));
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    let until = slave.now + span(700);
    keep_alive(&mut slave, until);
    assert_eq!(BOTH.map(|channel| answers(&slave, channel).len()), [0, 0]);
    assert_eq!(ask(&mut slave, FIRST, initiate(SPARE, 0, 100)), done(SPARE, 0), "nobody writes it");
}

/// Given a second client that reads a long block again and again within a moment, then its answers are no frames too many: the client limits
/// them, as those of the first server.
///
/// Verifies: ECSS 5.3.3.1b
#[test]
fn answers_of_the_second_server_are_not_over_the_budget() {
    let mut slave = spacecraft_slave();
    open(&mut slave);
    let value = pattern(2_000, 5);
    fill(&mut slave, BLOCK, &value);
    for _ in 0..5 {
        let mut reads = [Transfer::upload(SECOND, BLOCK, Mode::Block)];
        run(&mut slave, &mut reads);
        assert_eq!(reads[0].outcome, Some(Ok(2_000)));
    }
    assert!(slave.node.deadline().is_some());
    assert_eq!(slave.node.objects().extension.over_budget.refused, 0);
}

/// Given two clients that read both parts of the local time (2011h) in turn, then the parts of each belong to one sample.
///
/// Verifies: ECSS 7.1.2c
#[test]
fn each_client_reads_the_time_from_a_sample_of_its_own() {
    let mut slave = spacecraft_slave();
    open(&mut slave);
    let part = |slave: &mut TestSlave, channel, sub| {
        let until = slave.now + span(7);
        slave.run_until(until);
        let [_, _, _, _, value @ ..] = ask(slave, channel, [0x40, 0x11, 0x20, sub, 0, 0, 0, 0]);
        u32::from_le_bytes(value)
    };
    for round in 0..2 {
        let sampled = BOTH.map(|channel| {
            assert_eq!(part(&mut slave, channel, 1), 0, "in the first second");
            slave.node.scet(slave.now).fine()
        });
        assert!(sampled[0] < sampled[1]);
        assert_eq!(BOTH.map(|channel| part(&mut slave, channel, 2)), sampled, "round {round}");
    }
}
