//! What a slave keeps over a reset and beyond power-off, profile `standard`: consumer time 250 ms, Bdefault nominal.
//!
//! Verifies: ECSS 8.3.2a

use std::sync::{Arc, Mutex};

use crate::instrument::{self, STANDARD};
use ecss_can::nmt::Command;
use ecss_can::node::SlaveEvent;
use ecss_can::profile::Profile;
use ecss_can::redundancy::machine::Retained;
use ecss_can::store::RetainedMemory;
use ecss_can::types::{Bus, Instant, NmtState, NodeId};

use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, node, span};
use crate::device::fixture::{Memory, done, refused, write_on};
use crate::slave::TestSlave;

/// RAM of a board that outlives a reset. It holds anything at first.
#[derive(Clone)]
struct Ram(Arc<Mutex<[u32; 2]>>);

impl Ram {
    fn of_power_on() -> Ram {
        Ram(Arc::new(Mutex::new([0x1BAD_B002, 0xDEAD_BEEF])))
    }

    fn retained(&self) -> Option<Retained> {
        Retained::decode(*self.0.lock().unwrap())
    }
}

impl RetainedMemory for Ram {
    fn read(&self) -> [u32; 2] {
        *self.0.lock().unwrap()
    }

    fn write(&mut self, words: [u32; 2]) {
        *self.0.lock().unwrap() = words;
    }
}

/// The memories of slave 5.
struct Memories {
    profile: Profile,
    store: Option<Memory>,
    ram: Ram,
}

impl Memories {
    fn new() -> Memories {
        Memories { profile: STANDARD, store: Some(Memory::default()), ram: Ram::of_power_on() }
    }

    /// The slave starts, after a reset or with power: what is in RAM is up to the test.
    fn start(&self) -> Bench<TestSlave> {
        let slave = instrument::builder(node(5), &self.profile, vec![]);
        let slave = slave.retained(Box::leak(Box::new(self.ram.clone())));
        Bench::new(match self.store.clone() {
            Some(store) => slave.store(Box::leak(Box::new(store))).build(),
            None => slave.build(),
        })
    }

    fn lose_power(&mut self) {
        self.ram = Ram::of_power_on();
    }

    /// Where a reset, or power that comes back, starts.
    fn starts_on(&self) -> Bus {
        self.start().node.status(Instant::ZERO).active
    }
}

/// Heartbeats of the master on a bus, every 100 ms for so many milliseconds.
fn hear(slave: &mut Bench<TestSlave>, bus: Bus, length: u64) {
    let from = slave.now.as_micros() / 1_000;
    for at in (from..=from + length).step_by(100) {
        slave.run_until(ms(at));
        slave.receive(bus, 0x701, &[0x05]);
    }
}

fn write(slave: &mut Bench<TestSlave>, index: u16, sub: u8, value: &[u8]) {
    let bus = slave.node.status(slave.now).active;
    assert_eq!(write_on(slave, bus, index, sub, value), done(index, sub));
}

/// How often Bdefault was to be noted, and whether it was.
fn notes(slave: &Bench<TestSlave>) -> Vec<(Bus, bool)> {
    let noted = slave.events.iter().filter_map(|event| match event {
        SlaveEvent::BdefaultNoted { bus, is_kept } => Some((*bus, *is_kept)),
        _ => None,
    });
    noted.collect()
}

/// Given a slave that followed the master to the redundant bus, when its chip is reset at once, with or without a parameter store, then
/// it starts there.
///
/// Verifies: ECSS 8.3.3l, 8.3.3g
/// Notices: ECSS 8.3.3l: Bdefault of a bus that was followed does not outlive a reset.
/// Notices: ECSS 8.3.2a: Bdefault of a bus that was followed does not outlive a reset.
#[test]
fn a_reset_starts_on_the_bus_followed_last() {
    for has_store in [true, false] {
        let mut memories = Memories::new();
        memories.store = memories.store.filter(|_| has_store);
        let mut slave = memories.start();
        hear(&mut slave, NOMINAL, 200);
        slave.run_until(ms(250));
        slave.receive(REDUNDANT, 0x701, &[0x05]);
        assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
        assert_eq!(memories.starts_on(), REDUNDANT);
    }
}

/// Verifies: ECSS 8.3.3k, 8.3.3l, 6.5.3a, 8.3.3g
/// Notices: ECSS 8.3.2a: after a reset a slave starts on the stored Bdefault, not on the last one.
/// Notices: ECSS 8.3.3l: Bdefault of a bus found in a search is not retained.
#[test]
fn a_reset_starts_on_the_bus_found_last() {
    let board = Memories::new();
    let mut slave = board.start();
    assert_eq!(board.starts_on(), NOMINAL);
    hear(&mut slave, REDUNDANT, 0);
    assert_eq!(board.starts_on(), REDUNDANT, "at once, found in a search");
    hear(&mut slave, NOMINAL, 300);
    hear(&mut slave, REDUNDANT, 0);
    assert_eq!(board.starts_on(), REDUNDANT, "followed");
    assert_eq!(board.start().frames(), [(REDUNDANT, frame(0x705, &[0]))]);
}

/// Given a slave with Bdefault redundant in its profile and in its store, when it finds its master on the nominal bus and its chip is
/// reset at once, then it starts there.
///
/// Verifies: ECSS 8.3.3l, 8.3.3k
/// Notices: ECSS 8.3.3l: a nominal bus that was found does not replace a stored Bdefault at a reset.
#[test]
fn a_reset_starts_on_the_nominal_bus_found_last() {
    let mut board = Memories::new();
    board.profile.bdefault = REDUNDANT;
    let mut slave = board.start();
    write(&mut slave, 0x1010, 1, b"save");
    assert_eq!(board.starts_on(), REDUNDANT);
    hear(&mut slave, NOMINAL, 0);
    assert_eq!(board.starts_on(), NOMINAL);
}

#[test]
fn without_power_a_bus_found_just_now_is_forgotten() {
    let mut board = Memories::new();
    let mut slave = board.start();
    hear(&mut slave, REDUNDANT, 200);
    assert_eq!(notes(&slave), []);
    board.lose_power();
    assert_eq!(board.starts_on(), NOMINAL);
}

/// Verifies: ECSS 8.3.3k, 8.3.3l
/// Notices: ECSS 8.3.3l: Bdefault of a bus that was found does not outlive power-off.
#[test]
fn a_bus_found_a_consumer_time_ago_outlives_power() {
    let mut board = Memories::new();
    let mut slave = board.start();
    hear(&mut slave, REDUNDANT, 300);
    assert_eq!(notes(&slave), [(REDUNDANT, true)]);
    board.lose_power();
    assert_eq!(board.starts_on(), REDUNDANT);
    // And back.
    let mut slave = board.start();
    hear(&mut slave, NOMINAL, 300);
    board.lose_power();
    assert_eq!(board.starts_on(), NOMINAL);
}

/// Verifies: ECSS 8.3.3l
/// Notices: ECSS 8.3.3l: a bus that was found just before a reset is never noted.
#[test]
fn a_bus_that_is_stored_already_is_not_noted_again() {
    let mut board = Memories::new();
    let mut slave = board.start();
    hear(&mut slave, NOMINAL, 500);
    assert_eq!(notes(&slave), [], "it is the default");
    hear(&mut slave, REDUNDANT, 500);
    slave.run_until(ms(2_000));
    hear(&mut slave, REDUNDANT, 500);
    assert_eq!(notes(&slave), [(REDUNDANT, true)]);
    // After a reset, and after power-off: it is in the store.
    for _ in 0..2 {
        let mut slave = board.start();
        hear(&mut slave, REDUNDANT, 500);
        assert_eq!(notes(&slave), []);
        board.lose_power();
    }
    // A reset before it was noted: then it is noted after that.
    hear(&mut board.start(), NOMINAL, 0);
    let mut slave = board.start();
    hear(&mut slave, NOMINAL, 300);
    assert_eq!(notes(&slave), [(NOMINAL, true)]);
}

/// Verifies: ECSS 8.3.3l
#[test]
fn eight_notes_are_written_from_power_on_to_power_off() {
    let mut board = Memories::new();
    let mut all = Vec::new();
    let mut buses = [REDUNDANT, NOMINAL].into_iter().cycle();
    // A reset gives no new ones.
    for _ in 0..3 {
        let mut slave = board.start();
        for bus in buses.by_ref().take(4) {
            // Beyond the time in which a heartbeat on the other bus is doubted.
            slave.run_until(slave.now + span(2_000));
            hear(&mut slave, bus, 1_000);
        }
        all.extend(notes(&slave).into_iter().map(|(_, is_kept)| is_kept));
    }
    assert_eq!(all[..8], [true; 8]);
    assert!(all.len() > 8 && all[8..].iter().all(|is_kept| !is_kept), "{all:?}");
    assert_eq!(board.ram.retained().unwrap().bdefault, Some(NOMINAL), "a reset starts on the bus found last");
    board.lose_power();
    let mut slave = board.start();
    hear(&mut slave, REDUNDANT, 300);
    assert_eq!(notes(&slave), [(REDUNDANT, true)]);
}

/// Verifies: ECSS 8.3.3l
/// Notices: ECSS 8.3.3l: with a full store Bdefault does not outlive a reset either.
#[test]
fn a_store_without_room_says_that_bdefault_is_not_kept() {
    let mut board = Memories { store: Some(Memory::full()), ..Memories::new() };
    let mut slave = board.start();
    hear(&mut slave, REDUNDANT, 500);
    assert_eq!(notes(&slave), [(REDUNDANT, false)]);
    assert_eq!(board.starts_on(), REDUNDANT);
    board.lose_power();
    assert_eq!(board.starts_on(), NOMINAL);
}

/// Verifies: ECSS 8.3.3l
#[test]
fn without_a_store_bdefault_outlives_a_reset_only() {
    let mut board = Memories { store: None, ..Memories::new() };
    let mut slave = board.start();
    hear(&mut slave, REDUNDANT, 500);
    assert_eq!(notes(&slave), []);
    assert_eq!(board.starts_on(), REDUNDANT);
    board.lose_power();
    assert_eq!(board.starts_on(), NOMINAL);
}

/// Verifies: ECSS 8.3.1c, 8.3.3l
/// Notices: ECSS 8.3.1c: a Bdefault that a client writes is not taken.
/// Notices: ECSS 8.3.3l: Bdefault stays as written when the master is found again on the same bus.
#[test]
fn a_bdefault_written_lasts_until_the_next_find_or_reset() {
    let board = Memories::new();
    let mut slave = board.start();
    hear(&mut slave, NOMINAL, 300);
    write(&mut slave, 0x2000, 1, &[1]);
    assert_eq!(slave.node.status(slave.now).redundancy.bdefault, REDUNDANT);
    assert_eq!(board.starts_on(), NOMINAL);
    // Missed and found: the search ends with the bus found.
    slave.run_until(ms(700));
    assert_eq!(slave.node.status(slave.now).redundancy.bdefault, REDUNDANT);
    hear(&mut slave, NOMINAL, 0);
    assert_eq!(slave.node.status(slave.now).redundancy.bdefault, NOMINAL);
    assert_eq!(board.starts_on(), NOMINAL);
}

/// Given a Bdefault that a client wrote and did not save, when the slave gets Reset communication, then it boots up on the bus where it is
/// and keeps that Bdefault. After power-on it has the old one.
///
/// Verifies: ECSS 8.3.1c
/// Notices: ECSS 8.3.2a: a slave goes to Bdefault at Reset communication.
/// Notices: ECSS 8.3.1c: Reset communication brings back the Bdefault of the profile.
#[test]
fn an_unsaved_bdefault_lasts_until_power_on() {
    let mut board = Memories::new();
    let mut slave = board.start();
    hear(&mut slave, NOMINAL, 300);
    write(&mut slave, 0x2000, 1, &[1]);
    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x705, &[0x00]))]);
    let status = slave.node.status(slave.now);
    assert_eq!((status.active, status.redundancy.bdefault), (NOMINAL, REDUNDANT));
    board.lose_power();
    let slave = board.start();
    let status = slave.node.status(slave.now);
    assert_eq!((status.active, status.redundancy.bdefault), (NOMINAL, NOMINAL));
}

/// It is not what the master was found on, so it is neither retained nor noted.
///
/// Verifies: ECSS 8.3.3l
#[test]
fn a_bdefault_written_soon_after_a_find_is_not_kept() {
    let mut board = Memories::new();
    let mut slave = board.start();
    hear(&mut slave, REDUNDANT, 100);
    write(&mut slave, 0x2000, 1, &[0]);
    hear(&mut slave, REDUNDANT, 300);
    assert_eq!(board.starts_on(), REDUNDANT);
    board.lose_power();
    assert_eq!(board.starts_on(), REDUNDANT);
}

/// Verifies: ECSS 6.8a, 8.3.1c, 8.3.3l
/// Notices: ECSS 8.3.1c: a Bdefault that was written and saved is lost at a reset.
#[test]
fn save_keeps_the_bdefault_of_the_dictionary() {
    for sub in [1, 4] {
        let mut board = Memories::new();
        let mut slave = board.start();
        hear(&mut slave, REDUNDANT, 500);
        write(&mut slave, 0x2000, 1, &[0]);
        write(&mut slave, 0x1010, sub, b"save");
        assert_eq!(board.starts_on(), NOMINAL, "sub {sub}");
        // Found again: that goes before what was saved.
        slave.run_until(ms(1_000));
        hear(&mut slave, REDUNDANT, 500);
        assert_eq!(board.starts_on(), REDUNDANT);
        board.lose_power();
        assert_eq!(board.starts_on(), REDUNDANT);
    }
}

/// Verifies: ECSS 6.8a
#[test]
fn load_clears_the_kept_bdefault_from_the_next_reset_on() {
    for sub in [1, 4] {
        for saved in [false, true] {
            let mut board = Memories::new();
            let mut slave = board.start();
            hear(&mut slave, REDUNDANT, 500);
            if saved {
                write(&mut slave, 0x1010, sub, b"save");
            }
            write(&mut slave, 0x1011, sub, b"load");
            assert_eq!(slave.node.status(slave.now).active, REDUNDANT, "until the reset");
            assert_eq!(board.starts_on(), NOMINAL, "sub {sub}");
            board.lose_power();
            assert_eq!(board.starts_on(), NOMINAL);
        }
    }
}

/// Within the consumer time after a find: what was found before is not noted after that.
#[test]
fn save_and_load_end_the_wait_for_a_note() {
    for (index, signature, expected) in [(0x1010, b"save", REDUNDANT), (0x1011, b"load", NOMINAL)] {
        let mut board = Memories::new();
        let mut slave = board.start();
        hear(&mut slave, REDUNDANT, 100);
        write(&mut slave, index, 1, signature);
        hear(&mut slave, REDUNDANT, 500);
        assert_eq!(notes(&slave), [], "{index:04X}h");
        assert_eq!(board.starts_on(), expected, "{index:04X}h");
        board.lose_power();
        assert_eq!(board.starts_on(), expected, "{index:04X}h");
    }
}

/// Verifies: ECSS 8.3.3l
#[test]
fn saves_and_loads_of_other_parameters_leave_the_kept_bdefault() {
    for (index, signature) in [(0x1010, b"save"), (0x1011, b"load")] {
        for sub in [2, 3] {
            let mut board = Memories::new();
            let mut slave = board.start();
            hear(&mut slave, REDUNDANT, 500);
            write(&mut slave, index, sub, signature);
            assert_eq!(board.starts_on(), REDUNDANT, "{index:04X}h:{sub}");
            board.lose_power();
            assert_eq!(board.starts_on(), REDUNDANT, "{index:04X}h:{sub}");
        }
    }
}

/// Verifies: ECSS 6.1a, 8.3.3l
#[test]
fn a_save_that_fails_leaves_the_retained_bdefault() {
    let board = Memories { store: Some(Memory::full()), ..Memories::new() };
    let mut slave = board.start();
    hear(&mut slave, REDUNDANT, 500);
    let answer = write_on(&mut slave, REDUNDANT, 0x1010, 1, b"save");
    assert_eq!(answer, refused(0x1010, 1, 0x0800_0022));
    assert_eq!(board.starts_on(), REDUNDANT);
}

/// A command alone may come from any node.
///
/// Verifies: ECSS 8.3.3k, 8.3.3l, 8.3.3g
/// Notices: ECSS 8.3.3l: a bus found by a command and confirmed by a heartbeat is not Bdefault after a reset.
#[test]
fn bus_found_by_command_is_retained_once_heartbeat_confirms_it() {
    let board = Memories::new();
    let mut slave = board.start();
    slave.run_until(ms(50));
    slave.receive(REDUNDANT, 0x000, &[0x01, 0x05]);
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
    assert_eq!(board.starts_on(), NOMINAL);
    slave.receive(REDUNDANT, 0x701, &[0x05]);
    assert_eq!(board.starts_on(), REDUNDANT);
}

/// A slave that nothing was heard on since it booted at zero; resets of the chip start it again.
struct Flight {
    board: Memories,
    slave: Bench<TestSlave>,
    boots: usize,
    ignored: Vec<SlaveEvent>,
}

impl Flight {
    fn new() -> Flight {
        let board = Memories::new();
        let slave = board.start();
        Flight { board, slave, boots: 0, ignored: vec![] }
    }

    /// A command to all on the nominal bus, so many milliseconds later; counts boot-up messages.
    fn command(&mut self, after: u64, command: u8) {
        self.slave.clear();
        let at = self.slave.now + span(after);
        self.slave.run_until(at);
        self.slave.receive(NOMINAL, 0x000, &[command, 0]);
        self.boots += self.slave.frames().contains(&(NOMINAL, frame(0x705, &[0]))) as usize;
        let ignored = |event: &&SlaveEvent| matches!(event, SlaveEvent::ResetIgnored { .. });
        self.ignored.extend(self.slave.events.iter().filter(ignored));
        if self.slave.events.contains(&SlaveEvent::ResetNode) {
            self.slave = self.board.start();
            self.boots += 1;
        }
    }
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5, 6.4a.2, 6.5.3a
#[test]
fn fourth_reset_in_a_row_is_ignored_counted_and_reported_once() {
    for (raw, command) in [(0x81, Command::ResetNode), (0x82, Command::ResetCommunication)] {
        let mut flight = Flight::new();
        for _ in 0..3 {
            flight.command(100, raw);
        }
        assert_eq!(flight.boots, 3);
        assert_eq!(flight.board.ram.retained().unwrap().resets, 3);
        let before = flight.slave.node.status(flight.slave.now).counters.nominal.ignored;
        flight.command(100, raw);
        let emcy = frame(0x085, &[0x00, 0x81, 0x11, raw, 0, 0, 0, 0]);
        assert!(flight.slave.frames().contains(&(NOMINAL, emcy)), "{:?}", flight.slave.frames());
        for _ in 0..10 {
            flight.command(100, raw);
            assert!(flight.slave.frames().iter().all(|(_, frame)| frame.id().raw() != 0x085), "once");
        }
        assert_eq!(flight.boots, 3);
        assert_eq!(flight.ignored, [SlaveEvent::ResetIgnored { bus: NOMINAL, command }]);
        let status = flight.slave.node.status(flight.slave.now);
        assert_eq!(status.counters.nominal.ignored - before, 11);
        assert_eq!(status.state, NmtState::PreOperational);
        // Two consumer times without a reset.
        flight.command(501, raw);
        assert_eq!(flight.boots, 4);
    }
}

/// Verifies: ECSS 6.4a.1, 6.4a.2
#[test]
fn the_end_of_a_row_of_resets_is_reported() {
    let gone = frame(0x085, &[0x00, 0x00, 0, 0x00, 0x81, 0x82, 0, 0]);
    for by_heartbeat in [false, true] {
        let mut flight = Flight::new();
        for _ in 0..4 {
            flight.command(100, 0x82);
        }
        let mut slave = flight.slave;
        slave.clear();
        let at = slave.now + span(if by_heartbeat { 150 } else { 499 });
        slave.run_until(at);
        assert!(slave.frames().iter().all(|(_, frame)| *frame != gone));
        if by_heartbeat {
            slave.receive(NOMINAL, 0x701, &[0x05]);
        }
        // The heartbeat finds the master: the beginning is announced again before the end, an inhibit time apart.
        slave.run_until(slave.now + span(101));
        assert!(slave.frames().iter().any(|(_, frame)| *frame == gone), "{:?}", slave.frames());
        assert_eq!(flight.board.ram.retained().unwrap().resets, 0);
    }
}

/// Verifies: ECSS 6.5.1a.4
#[test]
fn a_reset_is_obeyed_when_the_master_was_heard_since_the_boot() {
    let mut flight = Flight::new();
    for _ in 0..20 {
        flight.slave.receive(NOMINAL, 0x701, &[0x05]);
        flight.command(50, 0x81);
    }
    assert_eq!((flight.boots, flight.ignored.len()), (20, 0));
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5, 6.5.3a
/// Notices: ECSS 6.5.1a.5: resets two consumer times apart count as a row.
#[test]
fn twenty_resets_with_pauses_give_twenty_boots() {
    for command in [0x81, 0x82] {
        let mut flight = Flight::new();
        for _ in 0..20 {
            flight.command(501, command);
        }
        assert_eq!((flight.boots, flight.ignored.len()), (20, 0));
    }
}

/// The command to another node, other commands, and a row that a start interrupts.
///
/// Verifies: ECSS 6.5.1a.4
#[test]
fn commands_other_than_a_reset_of_this_node_do_not_count() {
    let mut flight = Flight::new();
    for _ in 0..5 {
        flight.slave.receive(NOMINAL, 0x000, &[0x81, 0x06]);
        flight.slave.receive(NOMINAL, 0x000, &[0x80, 0x05]);
    }
    assert_eq!(flight.board.ram.retained().unwrap_or_default().resets, 0);
    for _ in 0..4 {
        flight.slave.receive(NOMINAL, 0x000, &[0x01, 0x05]);
        flight.command(100, 0x81);
    }
    assert_eq!(flight.boots, 3, "a command is no heartbeat");
}

/// An ignored reset does not end a search: with selective access the slave gets to the other bus.
///
/// Verifies: ECSS 8.3.3e, 8.3.3h, 5.3.3.1b, 6.5.1a.1, 8.3.2b
/// Notices: ECSS 5.3.3.1b: a slave stays on the bus on which resets are babbled.
#[test]
fn a_selective_slave_leaves_the_bus_on_which_resets_are_babbled() {
    let mut flight = Flight::new();
    flight.board.profile.selective = const { &[NodeId::of::<5>()] };
    flight.slave = flight.board.start();
    for _ in 0..100 {
        flight.command(10, 0x81);
        if flight.slave.node.status(flight.slave.now).active == REDUNDANT {
            break;
        }
    }
    // Ttoggle: 500 ms after its last boot.
    assert_eq!((flight.boots, flight.slave.now), (3, ms(500)));
    flight.slave.receive(REDUNDANT, 0x701, &[0x05]);
    flight.slave.receive(REDUNDANT, 0x000, &[0x01, 0x05]);
    let status = flight.slave.node.status(flight.slave.now);
    assert_eq!((status.state, status.active), (NmtState::Operational, REDUNDANT));
}
