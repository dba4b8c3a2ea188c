//! Transmit PDOs.
//!
//! Verifies: ECSS 6.2a

use async_canopen::od::{INVALID, NO_REMOTE, Objects};
use async_canopen::pdo::machine::{Tpdos, rules};
use async_canopen::pdo::{CobIdOf, Direction, Pdo, PdoObjects, PdoParameters, PdoSet};
use async_canopen::types::{AbortCode, Address, CobId, Frame, Instant};

use super::device::{Device, WORDS, entry};
use crate::bench::{frame, ms};

/// Four TPDOs of a device in Operational, and what they sent.
struct Node {
    tpdos: Tpdos<PdoObjects<4, 4>>,
    device: Device,
    sent: Vec<(usize, Frame)>,
}

fn parameters(cob_id: u32, transmission: u8) -> PdoParameters {
    PdoParameters { cob_id: NO_REMOTE | cob_id, transmission, ..PdoParameters::default() }
}

fn synchronous(cycle: u8, sync_start: u8) -> PdoParameters {
    PdoParameters { sync_start, ..parameters(0x185, cycle) }
}

fn event_driven(inhibit: u16, event_timer: u16) -> PdoParameters {
    PdoParameters { inhibit, event_timer, ..parameters(0x185, 254) }
}

impl Node {
    /// With one TPDO of four words; Operational from zero on.
    fn with(parameters: PdoParameters) -> Node {
        let mut node = Node { tpdos: Tpdos::new(&PdoSet::NONE), device: Device::default(), sent: vec![] };
        node.device.words = [0x1111, 0x2222, 0x3333, 0x4444, 0x5555];
        assert_eq!(node.configure(0, parameters, &WORDS, ms(0)), Ok(()));
        node.tpdos.start(ms(0));
        node
    }

    fn configure(
        &mut self,
        number: usize,
        parameters: PdoParameters,
        mapping: &[u32],
        now: Instant,
    ) -> Result<(), AbortCode> {
        self.tpdos.configure(
            number,
            &parameters,
            rules::resolve::<Device>(Direction::Transmit, &parameters, mapping)?,
            now,
        )
    }

    /// Which ones a SYNC sends.
    fn sync(&mut self, counter: u8) -> Vec<usize> {
        let sent = &mut self.sent;
        self.tpdos.on_sync(counter, &self.device, &mut |number, frame, _| {
            sent.push((number, frame));
            true
        });
        self.numbers()
    }

    /// Which ones are due.
    fn poll(&mut self, now: Instant) -> Vec<usize> {
        let sent = &mut self.sent;
        self.tpdos.poll(now, &self.device, &mut |number, frame| {
            sent.push((number, frame));
            true
        });
        self.numbers()
    }

    fn numbers(&mut self) -> Vec<usize> {
        self.sent.drain(..).map(|(number, _)| number).collect()
    }

    /// The instants of transmissions, polled at every deadline up to `until`.
    fn run(&mut self, until: Instant) -> Vec<u64> {
        let mut instants = vec![];
        while let Some(now) = self.tpdos.deadline().filter(|now| *now <= until) {
            instants.extend(self.poll(now).iter().map(|_| now.as_micros()));
        }
        instants
    }

    fn trigger(&mut self, now: Instant) -> bool {
        self.tpdos.trigger(0, now)
    }
}

/// The SYNCs of 1 to `count` at which PDO 0 goes, all with a counter of zero.
fn syncs_with(node: &mut Node, count: u32) -> Vec<u32> {
    (1..=count).filter(|_| !node.sync(0).is_empty()).collect()
}

/// Verifies: ECSS 6.9a, 6.9b, 7.2.3e
/// Notices: ECSS 6.9a: the first transmission does not wait for n SYNCs.
/// Notices: ECSS 7.2.3e: type 240 is not sent with SYNC.
#[test]
fn a_cyclic_one_is_sampled_and_sent_at_every_nth_sync() {
    for (cycle, expected) in
        [(1, vec![1, 2, 3, 4, 5, 6, 7]), (2, vec![2, 4, 6]), (3, vec![3, 6]), (240, vec![])]
    {
        let mut node = Node::with(synchronous(cycle, 0));
        assert_eq!(syncs_with(&mut node, 7), expected, "type {cycle}");
        assert_eq!(node.run(ms(10_000)), [0; 0]);
    }
    assert_eq!(syncs_with(&mut Node::with(synchronous(240, 0)), 500), [240, 480]);
}

/// Verifies: ECSS 6.9a, 6.9e
#[test]
fn a_sync_sends_the_values_of_now() {
    let mut node = Node::with(synchronous(1, 0));
    let Node { tpdos, device, .. } = &mut node;
    let mut sent = vec![];
    for value in [1, 2] {
        device.words[3] = value;
        tpdos.on_sync(0, device, &mut |number, frame, _| {
            sent.push((number, frame));
            true
        });
    }
    let expected = |last| (0, frame(0x185, &[0x11, 0x11, 0x22, 0x22, 0x33, 0x33, last, 0]));
    assert_eq!(sent, [expected(1), expected(2)]);
}

#[test]
fn a_frame_is_as_long_as_its_mapping() {
    let mut node = Node::with(parameters(0x205, 254));
    node.configure(1, parameters(0x4FF, 1), &[entry(0x6001, 1, 1), entry(0x6103, 0, 16)], ms(0)).unwrap();
    node.device.wide.i16 = -2;
    let mut sent = vec![];
    node.tpdos.on_sync(0, &node.device, &mut |number, frame, _| {
        sent.push((number, frame));
        true
    });
    assert_eq!(sent, [(1, frame(0x4FF, &[0xFC, 0xFF, 0x01]))]);
}

/// Verifies: ECSS 6.9a, 6.9b
#[test]
fn an_acyclic_one_waits_for_an_event_and_then_for_the_next_sync() {
    let mut node = Node::with(synchronous(0, 0));
    assert_eq!(syncs_with(&mut node, 3), [0; 0]);
    assert!(node.trigger(ms(1)));
    assert!(node.trigger(ms(2)));
    assert_eq!(node.run(ms(1_000)), [0; 0]);
    assert_eq!(syncs_with(&mut node, 3), [1]);
    assert!(node.trigger(ms(3)));
    assert_eq!(syncs_with(&mut node, 3), [1]);
}

/// Given a TPDO of type 0 with an event timer, when the timer would expire, then nothing is sent without a SYNC.
///
/// Verifies: ECSS 6.9b
/// Notices: ECSS 6.9b: the event timer sends an acyclic PDO without a SYNC.
#[test]
fn an_acyclic_one_has_no_event_timer() {
    let timed = PdoParameters { event_timer: 100, ..synchronous(0, 0) };
    let mut node = Node::with(timed);
    assert_eq!(node.run(ms(1_000)), [0; 0], "since Operational");
    assert_eq!(syncs_with(&mut node, 3), [0; 0]);
    assert!(node.trigger(ms(1_000)));
    assert_eq!(syncs_with(&mut node, 3), [1]);
    assert_eq!(node.run(ms(2_000)), [0; 0], "since the last transmission");
    node.configure(0, timed, &WORDS, ms(2_000)).unwrap();
    assert_eq!(node.run(ms(3_000)), [0; 0], "since it was configured");
    assert_eq!(syncs_with(&mut node, 3), [0; 0]);
}

/// Given a TPDO whose event timer runs, when it becomes cyclic, then only SYNCs send it.
///
/// Verifies: ECSS 6.9b
/// Notices: ECSS 6.9b: a cyclic PDO is sent without SYNC when an event timer expires that was started before.
#[test]
fn the_event_timer_ends_when_a_pdo_becomes_cyclic() {
    let mut node = Node::with(event_driven(0, 100));
    node.configure(0, PdoParameters { event_timer: 100, ..synchronous(2, 0) }, &WORDS, ms(50)).unwrap();
    assert_eq!(node.run(ms(1_000)), [0; 0]);
    assert_eq!(syncs_with(&mut node, 4), [2, 4]);
}

/// Verifies: ECSS 6.9a, 6.9b
/// Notices: ECSS 6.2a: an event sends a cyclic PDO with the next SYNC.
#[test]
fn an_event_does_nothing_to_a_cyclic_one() {
    let mut node = Node::with(synchronous(3, 0));
    assert!(!node.trigger(ms(1)));
    assert_eq!(syncs_with(&mut node, 6), [3, 6]);
}

/// Verifies: ECSS 6.9e, 6.9a
/// Notices: ECSS 6.9e: the SYNCs are no longer counted after the first transmission.
/// Notices: ECSS 6.9a: the first transmission comes a cycle after the SYNC start value.
#[test]
fn the_first_one_goes_at_the_sync_start_value() {
    let mut node = Node::with(synchronous(4, 3));
    let counters = (1..=8).cycle().skip(5).take(16);
    let sent: Vec<u8> = counters.filter(|counter| !node.sync(*counter).is_empty()).collect();
    // Begins in mid-cycle: 6, 7, 8, 1, 2, then 3; every fourth from there on.
    assert_eq!(sent, [3, 7, 3]);
}

/// Verifies: ECSS 6.9a
#[test]
fn the_start_value_does_not_matter_without_a_counter() {
    assert_eq!(syncs_with(&mut Node::with(synchronous(2, 5)), 6), [2, 4, 6]);
    assert_eq!(syncs_with(&mut Node::with(synchronous(1, 5)), 3), [1, 2, 3]);
}

/// Verifies: ECSS 6.9a
#[test]
fn without_a_start_value_the_counter_does_not_matter() {
    let mut node = Node::with(synchronous(2, 0));
    let sent: Vec<u8> = (4..=9).filter(|counter| !node.sync(*counter).is_empty()).collect();
    assert_eq!(sent, [5, 7, 9]);
}

#[test]
fn an_event_driven_one_goes_at_its_event_and_not_before() {
    for transmission in [254, 255] {
        let mut node = Node::with(parameters(0x185, transmission));
        assert_eq!(node.tpdos.deadline(), None);
        assert_eq!(node.poll(ms(1_000)), [0; 0]);
        assert_eq!(syncs_with(&mut node, 3), [0; 0]);
        assert!(node.trigger(ms(1_000)));
        assert_eq!(node.tpdos.deadline(), Some(ms(1_000)));
        assert_eq!(node.poll(ms(1_000)), [0]);
        assert_eq!(node.poll(ms(1_000)), [0; 0]);
        assert_eq!(node.tpdos.deadline(), None);
    }
}

#[test]
fn event_in_inhibit_time_goes_at_its_end_with_current_values() {
    // 5 ms.
    let mut node = Node::with(event_driven(50, 0));
    node.trigger(ms(10));
    assert_eq!(node.poll(ms(10)), [0]);
    node.trigger(ms(11));
    node.trigger(ms(12));
    assert_eq!(node.poll(ms(12)), [0; 0]);
    assert_eq!(node.tpdos.deadline(), Some(ms(15)));
    assert_eq!(node.poll(Instant::from_micros(14_999)), [0; 0]);
    node.device.words = [7; 5];
    let mut sent = vec![];
    node.tpdos.poll(ms(15), &node.device, &mut |number, frame| {
        sent.push((number, frame));
        true
    });
    assert_eq!(sent, [(0, frame(0x185, &[7, 0, 7, 0, 7, 0, 7, 0]))]);
    assert_eq!(node.run(ms(1_000)), [0; 0]);
    // After it, at once.
    node.trigger(ms(20));
    assert_eq!(node.poll(ms(20)), [0]);
}

#[test]
fn inhibit_time_counts_from_the_transmission_even_if_late() {
    let mut node = Node::with(event_driven(50, 0));
    node.trigger(ms(10));
    assert_eq!(node.poll(ms(13)), [0]);
    node.trigger(ms(14));
    assert_eq!(node.tpdos.deadline(), Some(ms(18)));
}

/// Given the longest inhibit time, 6 553.5 ms, when an event follows a transmission, then the PDO is sent at the end of that time.
///
/// Notices: ECSS 6.2a: an inhibit time above 65.5 ms ends too early.
#[test]
fn longest_inhibit_time_delays_event_to_its_end() {
    let mut node = Node::with(event_driven(u16::MAX, 0));
    node.trigger(ms(10));
    assert_eq!(node.poll(ms(10)), [0]);
    node.trigger(ms(11));
    assert_eq!(node.tpdos.deadline(), Some(Instant::from_micros(6_563_500)));
    assert_eq!(node.poll(Instant::from_micros(6_563_499)), [0; 0]);
    assert_eq!(node.poll(Instant::from_micros(6_563_500)), [0]);
}

/// Verifies: ECSS 11.1a
/// Notices: ECSS 11.1a: the event timer does not start when Operational is entered.
#[test]
fn event_timer_runs_from_operational_and_every_transmission() {
    let mut node = Node::with(event_driven(0, 10));
    assert_eq!(node.run(ms(35)), [10_000, 20_000, 30_000]);
    node.trigger(ms(36));
    assert_eq!(node.run(ms(60)), [36_000, 46_000, 56_000]);
}

#[test]
fn being_polled_late_does_not_shift_the_event_timer() {
    let mut node = Node::with(event_driven(0, 10));
    assert_eq!(node.poll(ms(13)), [0]);
    assert_eq!(node.tpdos.deadline(), Some(ms(20)));
    // A whole period late: one goes, not two.
    assert_eq!(node.poll(ms(31)), [0]);
    assert_eq!(node.tpdos.deadline(), Some(ms(41)));
    assert_eq!(node.poll(ms(51)), [0]);
    assert_eq!(node.tpdos.deadline(), Some(ms(61)));
}

/// Given an event timer of 10 ms and an inhibit time of 25 ms, then the PDO is sent every 25 ms.
///
/// Verifies: ECSS 11.1a
/// Notices: ECSS 11.1a: an event timer shorter than the inhibit time sends within it.
#[test]
fn an_event_timer_below_the_inhibit_time_waits_for_it() {
    let mut node = Node::with(event_driven(250, 10));
    assert_eq!(node.run(ms(70)), [10_000, 35_000, 60_000]);
}

#[test]
fn a_change_of_a_value_is_an_event_for_those_that_carry_it() {
    let mut node = Node::with(event_driven(0, 0));
    node.configure(1, parameters(0x285, 255), &[entry(0x6000, 5, 16), entry(0x6011, 1, 24)], ms(0)).unwrap();
    node.configure(2, parameters(0x385, 0), &[entry(0x6000, 5, 16)], ms(0)).unwrap();
    node.configure(3, parameters(0x485, 2), &[entry(0x6000, 5, 16)], ms(0)).unwrap();
    let place = |index, sub| Device::find(Address::new(index, sub)).unwrap().0;
    for (index, sub, expected) in [
        (0x6000, 1, vec![0]),
        (0x6000, 4, vec![0]),
        (0x6011, 1, vec![1]),
        (0x6010, 1, vec![]),
        (0x6020, 0, vec![]),
        (0x6000, 5, vec![1]),
    ] {
        node.tpdos.on_changed(place(index, sub), ms(1));
        assert_eq!(node.poll(ms(1)), expected, "{index:04X} {sub}");
    }
    // The acyclic one waited for SYNC; the cyclic one goes at the second.
    assert_eq!(node.sync(0), [2]);
    assert_eq!(node.sync(0), [3]);
}

/// Verifies: ECSS 11.1a, 6.5.4a
/// Notices: ECSS 11.1a: events send PDOs in Pre-operational.
#[test]
fn nothing_goes_out_outside_of_operational() {
    for parameters in [event_driven(50, 10), synchronous(1, 0), synchronous(0, 0), synchronous(1, 2)] {
        let mut node = Node::with(parameters);
        node.trigger(ms(1));
        node.tpdos.stop();
        assert_eq!(node.tpdos.deadline(), None);
        assert!(!node.trigger(ms(2)));
        node.tpdos.on_changed(Device::find(Address::new(0x6000, 1)).unwrap().0, ms(2));
        node.configure(0, parameters, &WORDS, ms(2)).unwrap();
        assert_eq!(node.tpdos.deadline(), None);
        assert_eq!(node.poll(ms(1_000)), [0; 0]);
        assert_eq!((node.sync(1), node.sync(2)), (vec![], vec![]));
    }
}

#[test]
fn operational_begins_anew() {
    let mut node = Node::with(event_driven(500, 10));
    node.trigger(ms(5));
    node.poll(ms(5));
    node.trigger(ms(6));
    node.tpdos.stop();
    node.tpdos.start(ms(20));
    // Neither the event nor the inhibit time of before.
    assert_eq!(node.tpdos.deadline(), Some(ms(30)));
    node.trigger(ms(21));
    assert_eq!(node.poll(ms(21)), [0]);

    let mut node = Node::with(synchronous(3, 0));
    assert_eq!(syncs_with(&mut node, 2), [0; 0]);
    node.tpdos.stop();
    node.tpdos.start(ms(0));
    assert_eq!(syncs_with(&mut node, 6), [3, 6]);
}

#[test]
fn new_parameters_take_effect_at_once() {
    let mut node = Node::with(event_driven(0, 10));
    assert_eq!(node.run(ms(25)), [10_000, 20_000]);
    node.configure(0, event_driven(0, 100), &WORDS, ms(25)).unwrap();
    assert_eq!(node.run(ms(300)), [125_000, 225_000]);
    node.configure(0, event_driven(0, 0), &WORDS, ms(300)).unwrap();
    assert_eq!(node.run(ms(1_000)), [0; 0]);
    node.configure(0, synchronous(1, 0), &WORDS, ms(1_000)).unwrap();
    assert_eq!(syncs_with(&mut node, 2), [1, 2]);
    node.configure(0, parameters(INVALID | 0x185, 1), &WORDS, ms(1_000)).unwrap();
    assert_eq!(syncs_with(&mut node, 2), [0; 0]);
    assert!(!node.trigger(ms(1_001)));
}

#[test]
fn event_waiting_for_inhibit_time_survives_new_parameters() {
    let mut node = Node::with(event_driven(100, 0));
    node.trigger(ms(1));
    node.poll(ms(1));
    node.trigger(ms(2));
    node.configure(0, event_driven(100, 500), &WORDS, ms(3)).unwrap();
    assert_eq!(node.run(ms(100)), [11_000]);
    // The timer alone is no event.
    node.configure(0, event_driven(100, 0), &WORDS, ms(100)).unwrap();
    assert_eq!(node.run(ms(1_000)), [0; 0]);
}

#[test]
fn what_is_due_is_sent_though_its_parameters_change_before() {
    // An event that nobody was asked for yet.
    let mut node = Node::with(event_driven(0, 0));
    node.trigger(ms(5));
    node.configure(0, event_driven(0, 500), &WORDS, ms(5)).unwrap();
    assert_eq!(node.run(ms(600)), [5_000, 505_000]);
    // One that waits for SYNC, and its end.
    let mut node = Node::with(synchronous(0, 0));
    node.trigger(ms(5));
    node.configure(0, PdoParameters { event_timer: 500, ..synchronous(0, 0) }, &WORDS, ms(6)).unwrap();
    assert_eq!(syncs_with(&mut node, 3), [1]);
    node.configure(0, synchronous(0, 0), &WORDS, ms(7)).unwrap();
    assert_eq!(syncs_with(&mut node, 3), [0; 0]);
}

/// Verifies: ECSS 6.10a
#[test]
fn no_two_have_one_cob_id() {
    let mut node = Node::with(parameters(0x185, 1));
    assert_eq!(node.configure(1, parameters(0x185, 1), &WORDS, ms(0)), Err(AbortCode::ParameterIncompatible));
    // Invalid it may, and the same one again.
    assert_eq!(node.configure(1, parameters(INVALID | 0x185, 1), &WORDS, ms(0)), Ok(()));
    assert_eq!(node.configure(0, parameters(0x185, 1), &WORDS, ms(0)), Ok(()));
    assert_eq!(node.sync(0), [0]);
}

#[test]
fn a_configuration_that_cannot_work_changes_nothing() {
    let mut node = Node::with(synchronous(1, 0));
    let bad = [
        (0, 1, &[][..], AbortCode::ParameterIncompatible),
        (0, 1, &[entry(0x6021, 0, 8)], AbortCode::NotMappable),
        (0, 1, &[entry(0x0005, 0, 8)], AbortCode::NotMappable),
        (0, 1, &[entry(0x7000, 0, 8)], AbortCode::NoObject),
        (0, 252, &WORDS, AbortCode::ValueRange),
        (0, 241, &WORDS, AbortCode::ValueRange),
        (4, 1, &WORDS, AbortCode::NoObject),
    ];
    for (number, transmission, mapping, code) in bad {
        assert_eq!(node.configure(number, parameters(0x285, transmission), mapping, ms(0)), Err(code));
    }
    let mut sent = vec![];
    node.tpdos.on_sync(0, &node.device, &mut |number, frame, _| {
        sent.push((number, frame));
        true
    });
    assert_eq!(sent, [(0, frame(0x185, &[0x11, 0x11, 0x22, 0x22, 0x33, 0x33, 0x44, 0x44]))]);
    assert!(!node.tpdos.trigger(4, ms(1)));
}

/// Nine that are due together: the queue of the node takes eight, the ninth goes in the next turn, in the order of numbers.
#[test]
fn a_burst_of_events_goes_out_in_turns() {
    let (mut tpdos, device) = (Tpdos::<PdoObjects<9, 9>>::new(&PdoSet::NONE), Device::default());
    for number in 0..9 {
        let own = parameters(0x181 + number as u32, 254);
        assert_eq!(
            tpdos.configure(
                number,
                &own,
                rules::resolve::<Device>(Direction::Transmit, &own, &WORDS).unwrap(),
                ms(0)
            ),
            Ok(())
        );
    }
    tpdos.start(ms(0));
    assert!((0..9).all(|number| tpdos.trigger(number, ms(1))));
    let mut turn = |now| {
        let mut sent = vec![];
        tpdos.poll(now, &device, &mut |number, _| {
            sent.push(number);
            true
        });
        (sent, tpdos.deadline())
    };
    assert_eq!(turn(ms(1)), ((0..8).collect(), Some(ms(1))));
    assert_eq!(turn(ms(1)), (vec![8], None));
}

/// PDOs 1 and 3 are declared as states, of four PDOs with one word each: 185h to 485h.
fn with_states(transmissions: [u8; 4]) -> Node {
    const STATES: PdoSet = PdoSet::new(
        &[],
        &[
            Pdo::<()>::new(CobIdOf::node(0x180)).map(Device::WORDS.sub(1)).transmit(1).state(),
            Pdo::<()>::new(CobIdOf::node(0x380)).map(Device::WORDS.sub(3)).transmit(3).state(),
        ],
    );
    let mut node = Node { tpdos: Tpdos::new(&STATES), device: Device::default(), sent: vec![] };
    for (number, transmission) in transmissions.into_iter().enumerate() {
        let cob_id = 0x185 + 0x100 * number as u32;
        let configured =
            node.configure(number, parameters(cob_id, transmission), &WORDS[number..=number], ms(0));
        assert_eq!(configured, Ok(()));
    }
    node
}

#[test]
fn states_are_sent_when_operational_is_entered_and_after_a_change_of_the_bus() {
    let mut node = with_states([254, 254, 255, 254]);
    node.tpdos.send_states(ms(0));
    assert_eq!(node.tpdos.deadline(), None, "not Operational");
    node.tpdos.start(ms(100));
    assert_eq!((node.poll(ms(100)), node.tpdos.deadline()), (vec![0], Some(ms(110))));
    assert_eq!(node.poll(ms(110)), [2]);
    assert_eq!(node.tpdos.deadline(), None);
    node.tpdos.send_states(ms(200));
    assert_eq!((node.poll(ms(200)), node.poll(ms(210))), (vec![0], vec![2]));
    // Those that a SYNC sends cyclically need no event; one of type 0 goes with the next SYNC.
    let mut node = with_states([1, 254, 0, 254]);
    node.tpdos.start(ms(0));
    assert_eq!((node.poll(ms(50)), node.sync(0)), (vec![], vec![0, 2]));
    assert_eq!(node.sync(0), [0]);
}

#[test]
fn state_that_was_not_sent_is_sent_again_and_an_event_is_lost() {
    let mut node = with_states([254, 254, 0, 1]);
    node.tpdos.start(ms(0));
    assert_eq!((node.poll(ms(0)), node.sync(0)), (vec![0], vec![2, 3]));
    let ids = [0x185, 0x285, 0x385, 0x485, 0x585].map(|raw| CobId::new(raw).unwrap());
    ids.into_iter().for_each(|id| node.tpdos.on_failed(id, ms(10)));
    assert_eq!((node.poll(ms(59)), node.poll(ms(60)), node.sync(0)), (vec![], vec![0], vec![2, 3]));
    assert_eq!(ids.map(|id| node.tpdos.is_event(id)), [false, true, false, false, false]);
    assert_eq!(ids.map(|id| node.tpdos.has(id)), [true, true, true, true, false]);
    // An event timer sends the next one.
    let timed = PdoParameters { event_timer: 100, ..parameters(0x285, 254) };
    assert_eq!(node.configure(1, timed, &WORDS[1..=1], ms(100)), Ok(()));
    assert!(!node.tpdos.is_event(ids[1]));
    node.tpdos.stop();
    node.tpdos.on_failed(ids[0], ms(110));
    assert_eq!(node.tpdos.deadline(), None);
}
