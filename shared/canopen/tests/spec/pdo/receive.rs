//! Receive PDOs.
//!
//! Verifies: ECSS 6.2a

use async_canopen::emcy::ErrorCode;
use async_canopen::od::{INVALID, NO_REMOTE};
use async_canopen::pdo::RpdoError::{OutOfRange, Overdue, TooLong, TooShort};
use async_canopen::pdo::machine::{Rpdos, Taken, rules};
use async_canopen::pdo::{Direction, PdoObjects, PdoParameters, RpdoError, RpdoEvent};
use async_canopen::types::{AbortCode, Instant};
use proptest::prelude::*;

use self::Told::{Applied, Error, OutsideWindow, Refused, Rejected, Resolved};
use super::device::{BOTH_WAYS, Device, WORDS, dump, entry};
use crate::bench::{frame, ms};
use crate::random::cases;

/// What became of an RPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Told {
    Applied,
    Refused,
    OutsideWindow,
    Rejected,
    Error(RpdoError),
    Resolved(RpdoError),
}

impl From<RpdoEvent> for Told {
    fn from(event: RpdoEvent) -> Told {
        match event {
            RpdoEvent::Error(error) => Error(error),
            RpdoEvent::Resolved(error) => Resolved(error),
        }
    }
}

fn take_events(rpdos: &mut Rpdos<PdoObjects<4, 4>>, told: &mut Vec<(usize, Told)>) {
    let has_events = rpdos.has_events();
    let events: Vec<_> = std::iter::from_fn(|| rpdos.take_event()).collect();
    assert!(has_events || events.is_empty(), "{events:?} without notice");
    told.extend(events.into_iter().map(|(number, event)| (number, event.into())));
}

/// Four RPDOs of a device, and everything they told.
struct Node {
    rpdos: Rpdos<PdoObjects<4, 4>>,
    device: Device,
    window_end: Instant,
    told: Vec<(usize, Told)>,
}

fn parameters(cob_id: u32, transmission: u8, event_timer: u16) -> PdoParameters {
    PdoParameters { cob_id, transmission, event_timer, ..PdoParameters::default() }
}

impl Node {
    fn new() -> Node {
        Node { rpdos: Rpdos::new(), device: Device::default(), window_end: Instant::NEVER, told: vec![] }
    }

    fn with(number: usize, parameters: PdoParameters, mapping: &[u32]) -> Node {
        let mut node = Node::new();
        assert_eq!(node.configure(number, parameters, mapping), Ok(()));
        node
    }

    fn configure(
        &mut self,
        number: usize,
        parameters: PdoParameters,
        mapping: &[u32],
    ) -> Result<(), AbortCode> {
        let outcome = self.rpdos.configure(
            number,
            &parameters,
            rules::resolve::<Device>(Direction::Receive, &parameters, mapping)?,
            false,
        );
        take_events(&mut self.rpdos, &mut self.told);
        outcome
    }

    fn receive(&mut self, id: u16, data: &[u8], at: Instant) -> bool {
        let Node { rpdos, device, window_end, told } = self;
        let frame = frame(id, data);
        let first = rpdos.first(frame.id());
        let mut number = first;
        while let Some(found) = number {
            if rpdos.on_plain_frame(found, &frame, device) {
                told.push((found, Applied));
            } else {
                let taken = rpdos.on_frame(found, &frame, at, *window_end, device);
                take_events(rpdos, told);
                match taken {
                    Taken::Applied => told.push((found, Applied)),
                    Taken::Refused => told.push((found, Refused)),
                    Taken::Held => {}
                    Taken::OutsideWindow => told.push((found, OutsideWindow)),
                    Taken::Rejected => told.push((found, Rejected)),
                }
            }
            number = rpdos.next(frame.id(), found);
        }
        first.is_some()
    }

    fn sync(&mut self, window_end: Instant) {
        let Node { rpdos, device, told, .. } = self;
        self.window_end = window_end;
        let mut applied = vec![];
        let ended = &mut |number, all| applied.push((number, if all { Applied } else { Refused }));
        rpdos.on_sync(device, ended);
        take_events(rpdos, told);
        self.told.extend(applied);
    }

    fn poll(&mut self, now: Instant) {
        self.rpdos.poll(now);
        take_events(&mut self.rpdos, &mut self.told);
    }

    fn told(&mut self) -> Vec<(usize, Told)> {
        std::mem::take(&mut self.told)
    }
}

const DATA: [u8; 8] = [0x11, 0x11, 0x22, 0x22, 0x33, 0x33, 0x44, 0x44];
const VALUES: [u16; 5] = [0x1111, 0x2222, 0x3333, 0x4444, 0];

#[test]
fn an_event_driven_one_is_in_the_dictionary_at_once() {
    for transmission in [254, 255] {
        let mut node = Node::with(2, parameters(0x205, transmission, 0), &WORDS);
        assert!(node.receive(0x205, &DATA, ms(1)));
        assert_eq!(node.device.words, VALUES);
        assert_eq!(node.told(), [(2, Applied)]);
        node.sync(Instant::NEVER);
        assert_eq!(node.told(), []);
    }
}

/// Verifies: ECSS 6.9a, 6.9b, 6.9e
/// Notices: ECSS 6.9b: a synchronous PDO takes effect when it arrives.
#[test]
fn synchronous_rpdo_applies_newest_frame_at_the_next_sync() {
    for transmission in [0, 1, 2, 240] {
        let mut node = Node::with(0, parameters(0x205, transmission, 0), &WORDS);
        assert!(node.receive(0x205, &[0xFF; 8], ms(1)));
        assert!(node.receive(0x205, &DATA, ms(2)));
        assert_eq!(node.device.words, [0; 5]);
        assert_eq!(node.told(), []);
        node.sync(Instant::NEVER);
        assert_eq!(node.device.words, VALUES);
        assert_eq!(node.told(), [(0, Applied)]);
        // Once.
        node.device.words = [0; 5];
        node.sync(Instant::NEVER);
        assert_eq!(node.device.words, [0; 5]);
        assert_eq!(node.told(), []);
    }
}

/// Given two synchronous RPDOs, when each has received a frame, then the next SYNC puts both into the dictionary.
///
/// Verifies: ECSS 6.9b
/// Notices: ECSS 6.9b: of two PDOs that wait for SYNC, the first alone takes effect.
#[test]
fn rpdos_that_wait_all_take_effect_at_one_sync() {
    let mut node = Node::with(0, parameters(0x205, 1, 0), &[entry(0x6000, 1, 16)]);
    node.configure(3, parameters(0x305, 240, 0), &[entry(0x6000, 2, 16)]).unwrap();
    assert!(node.receive(0x305, &[0x22, 0x22], ms(1)));
    assert!(node.receive(0x205, &[0x11, 0x11], ms(2)));
    assert_eq!((node.device.words, node.told()), ([0; 5], vec![]));
    node.sync(Instant::NEVER);
    assert_eq!(node.device.words, [0x1111, 0x2222, 0, 0, 0]);
    assert_eq!(node.told(), [(0, Applied), (3, Applied)]);
}

/// Verifies: ECSS 6.10a
#[test]
fn a_frame_of_others_is_none() {
    let mut node = Node::with(1, parameters(0x205, 255, 0), &WORDS);
    for id in [0x000, 0x080, 0x204, 0x206, 0x305, 0x7FF] {
        assert!(!node.receive(id, &DATA, ms(1)), "{id:03X}");
    }
    assert_eq!(node.device.words, [0; 5]);
    assert_eq!(node.told(), []);
}

#[test]
fn frame_too_short_is_rejected_and_reported_once_until_good_one() {
    let mut node = Node::with(0, parameters(0x205, 254, 0), &WORDS);
    for length in [0, 1, 7] {
        assert!(node.receive(0x205, &DATA[..length], ms(1)));
    }
    assert_eq!(node.device.words, [0; 5]);
    assert_eq!(node.told(), [(0, Error(TooShort)), (0, Rejected), (0, Rejected), (0, Rejected)]);
    node.receive(0x205, &DATA, ms(2));
    assert_eq!(node.device.words, VALUES);
    assert_eq!(node.told(), [(0, Resolved(TooShort)), (0, Applied)]);
    node.receive(0x205, &[], ms(3));
    assert_eq!(node.told(), [(0, Error(TooShort)), (0, Rejected)]);
}

#[test]
fn frame_too_long_is_processed_as_mapped_and_reported_once() {
    let mut node = Node::with(0, parameters(0x205, 254, 0), &WORDS[..2]);
    node.receive(0x205, &DATA, ms(1));
    assert_eq!(node.device.words, [0x1111, 0x2222, 0, 0, 0]);
    assert_eq!(node.told(), [(0, Error(TooLong)), (0, Applied)]);
    node.receive(0x205, &DATA[..5], ms(1));
    assert_eq!(node.told(), [(0, Applied)]);
    node.receive(0x205, &DATA[..3], ms(1));
    assert_eq!(node.told(), [(0, Error(TooShort)), (0, Resolved(TooLong)), (0, Rejected)]);
    node.receive(0x205, &DATA[..4], ms(1));
    assert_eq!(node.told(), [(0, Resolved(TooShort)), (0, Applied)]);
}

#[test]
fn a_short_frame_does_not_replace_the_one_that_waits_for_sync() {
    let mut node = Node::with(0, parameters(0x205, 1, 0), &WORDS);
    node.receive(0x205, &DATA, ms(1));
    node.receive(0x205, &[0xEE; 7], ms(2));
    node.sync(Instant::NEVER);
    assert_eq!(node.device.words, VALUES);
    assert_eq!(node.told(), [(0, Error(TooShort)), (0, Rejected), (0, Applied)]);
}

/// Verifies: ECSS 6.4a.2
/// Notices: ECSS 6.4a.2: PDOs that are too short and too long have the code of each other.
#[test]
fn every_error_has_its_emergency() {
    let codes = [(TooShort, 0x8210), (TooLong, 0x8220), (Overdue, 0x8250), (OutOfRange, 0x8200)];
    for (error, code) in codes {
        assert_eq!(error.code(), ErrorCode::new(code));
    }
}

/// Verifies: ECSS 5.3.3.2.3k.2
/// Notices: ECSS 5.3.3.2.3k.2: an RPDO stays overdue when its frames come again.
#[test]
fn the_deadline_runs_from_the_first_frame_and_is_told_once() {
    let mut node = Node::with(0, parameters(0x205, 254, 20), &WORDS);
    assert_eq!(node.rpdos.deadline(), None);
    node.poll(ms(1_000));
    assert_eq!(node.told(), []);
    node.receive(0x205, &DATA, ms(1_000));
    assert_eq!(node.rpdos.deadline(), Some(ms(1_020)));
    node.receive(0x205, &DATA, ms(1_019));
    node.told();
    node.poll(ms(1_020));
    node.poll(Instant::from_micros(1_038_999));
    assert_eq!(node.told(), []);
    assert_eq!(node.rpdos.deadline(), Some(ms(1_039)));
    node.poll(ms(1_039));
    assert_eq!(node.told(), [(0, Error(Overdue))]);
    assert_eq!(node.rpdos.deadline(), None);
    node.poll(ms(5_000));
    assert_eq!(node.told(), []);
    node.receive(0x205, &DATA, ms(5_000));
    assert_eq!(node.told(), [(0, Resolved(Overdue)), (0, Applied)]);
    node.poll(ms(5_020));
    assert_eq!(node.told(), [(0, Error(Overdue))]);
}

#[test]
fn a_short_frame_is_no_sign_of_life() {
    let mut node = Node::with(0, parameters(0x205, 254, 20), &WORDS);
    node.receive(0x205, &[], ms(1));
    assert_eq!(node.rpdos.deadline(), None);
    node.receive(0x205, &DATA, ms(2));
    node.receive(0x205, &[], ms(12));
    node.told();
    node.poll(ms(22));
    assert_eq!(node.told(), [(0, Error(Overdue))]);
    node.receive(0x205, &[], ms(23));
    assert_eq!(node.told(), [(0, Rejected)]);
    node.receive(0x205, &DATA, ms(24));
    assert_eq!(node.told(), [(0, Resolved(TooShort)), (0, Resolved(Overdue)), (0, Applied)]);
}

#[test]
fn a_value_outside_of_its_limits_is_not_written_and_told_once() {
    // A level of 10 to 90, one of -5 to 5 in a record, and a word between them.
    let mapping = [entry(0x6027, 0, 8), entry(0x6000, 1, 16), entry(0x6028, 2, 8)];
    for transmission in [254, 1] {
        let mut node = Node::with(0, parameters(0x205, transmission, 0), &mapping);
        let mut receive = |level: u8, word, trim: i8| {
            node.receive(0x205, &[level, word, 0, trim.to_le_bytes()[0]], ms(1));
            node.sync(Instant::NEVER);
            let Device { level, words, trims, .. } = node.device;
            (level, words[0], trims.trim[1], node.told())
        };
        assert_eq!(receive(10, 1, -5), (10, 1, -5, vec![(0, Applied)]));
        assert_eq!(receive(9, 2, 5), (10, 2, 5, vec![(0, Error(OutOfRange)), (0, Refused)]));
        assert_eq!(receive(90, 3, -6), (90, 3, 5, vec![(0, Refused)]));
        assert_eq!(receive(91, 4, 6), (90, 4, 5, vec![(0, Refused)]));
        assert_eq!(receive(255, 5, -128), (90, 5, 5, vec![(0, Refused)]));
        assert_eq!(receive(10, 6, 0), (10, 6, 0, vec![(0, Resolved(OutOfRange)), (0, Applied)]));
    }
}

#[test]
fn each_deadline_is_its_own() {
    let mut node = Node::with(0, parameters(0x205, 254, 50), &WORDS);
    node.configure(1, parameters(0x305, 1, 10), &WORDS).unwrap();
    node.receive(0x205, &DATA, ms(0));
    node.receive(0x305, &DATA, ms(5));
    node.told();
    assert_eq!(node.rpdos.deadline(), Some(ms(15)));
    node.poll(ms(15));
    assert_eq!(node.told(), [(1, Error(Overdue))]);
    assert_eq!(node.rpdos.deadline(), Some(ms(50)));
    node.poll(ms(50));
    assert_eq!(node.told(), [(0, Error(Overdue))]);
}

/// Verifies: ECSS 6.5.4a
#[test]
fn leaving_operational_forgets_what_is_held_and_stops_deadlines() {
    let mut node = Node::with(0, parameters(0x205, 1, 20), &WORDS);
    node.receive(0x205, &DATA, ms(1));
    node.rpdos.stop();
    assert_eq!(node.rpdos.deadline(), None);
    node.poll(ms(1_000));
    node.sync(Instant::NEVER);
    assert_eq!(node.device.words, [0; 5]);
    assert_eq!(node.told(), []);
    // Still configured.
    node.receive(0x205, &DATA, ms(2_000));
    node.sync(Instant::NEVER);
    assert_eq!(node.device.words, VALUES);
    assert_eq!(node.rpdos.deadline(), Some(ms(2_020)));
}

/// Verifies: ECSS 6.9e
#[test]
fn synchronous_frames_after_window_are_discarded_until_sync() {
    let mut node = Node::with(0, parameters(0x205, 1, 0), &WORDS);
    node.configure(1, parameters(0x305, 254, 0), &[entry(0x6000, 5, 16)]).unwrap();
    node.sync(ms(10));
    node.receive(0x205, &DATA, ms(10));
    assert_eq!(node.told(), []);
    node.receive(0x205, &[0xEE; 8], Instant::from_micros(10_001));
    assert_eq!(node.told(), [(0, OutsideWindow)]);
    // The window is for synchronous ones only.
    node.receive(0x305, &[1, 0], ms(11));
    assert_eq!(node.told(), [(1, Applied)]);
    node.sync(ms(110));
    assert_eq!(node.device.words, [0x1111, 0x2222, 0x3333, 0x4444, 1]);
    assert_eq!(node.told(), [(0, Applied)]);
    node.receive(0x205, &DATA, ms(105));
    assert_eq!(node.told(), []);
}

/// Given a synchronous RPDO with a deadline, when all further frames come after the window, then the RPDO is overdue, and only a
/// frame within the window resolves that. The length of a discarded frame is no error.
///
/// Verifies: ECSS 6.9e
#[test]
fn frames_after_the_window_do_not_restart_the_deadline() {
    let mut node = Node::with(0, parameters(0x205, 1, 20), &WORDS);
    node.sync(ms(10));
    node.receive(0x205, &DATA, ms(5));
    node.sync(ms(20));
    assert_eq!(node.told(), [(0, Applied)]);
    node.receive(0x205, &DATA, ms(21));
    assert_eq!(node.told(), [(0, OutsideWindow)]);
    node.poll(ms(24));
    assert_eq!(node.told(), []);
    node.poll(ms(25));
    assert_eq!(node.told(), [(0, Error(Overdue))]);
    for data in [&DATA[..], &[]] {
        node.receive(0x205, data, ms(26));
        assert_eq!(node.told(), [(0, OutsideWindow)]);
    }
    node.sync(ms(40));
    node.receive(0x205, &DATA, ms(40));
    assert_eq!(node.told(), [(0, Resolved(Overdue))]);
    assert_eq!(node.rpdos.deadline(), Some(ms(60)));
}

#[test]
fn two_with_one_cob_id_both_take_it() {
    let mut node = Node::with(3, parameters(0x205, 254, 0), &[entry(0x6000, 1, 16)]);
    node.configure(1, parameters(0x205, 254, 0), &[entry(0x6000, 2, 16)]).unwrap();
    node.receive(0x205, &[0x34, 0x12], ms(1));
    assert_eq!(node.device.words, [0x1234, 0x1234, 0, 0, 0]);
    assert_eq!(node.told(), [(1, Applied), (3, Applied)]);
}

/// Given RPDOs whose COB-IDs have one function code, then each takes the frames with its own COB-ID, also when another one became
/// invalid.
///
/// Verifies: ECSS 6.10a
/// Notices: ECSS 6.10a: of two receive PDOs with one function code, the second takes no frame.
#[test]
fn those_with_one_function_code_are_told_apart() {
    let mut node = Node::with(0, parameters(0x205, 254, 0), &[entry(0x6000, 1, 16)]);
    node.configure(2, parameters(0x27F, 254, 0), &[entry(0x6000, 2, 16)]).unwrap();
    node.configure(3, parameters(0x305, 254, 0), &[entry(0x6000, 3, 16)]).unwrap();
    let receive = |node: &mut Node, ids: &[u16]| {
        let known = ids.iter().map(|id| node.receive(*id, &[1, 0], ms(1))).collect::<Vec<_>>();
        (known, node.told().into_iter().map(|(number, _)| number).collect::<Vec<_>>())
    };
    let ids = [0x205, 0x206, 0x27F, 0x280, 0x305, 0x385];
    let known = vec![true, false, true, false, true, false];
    assert_eq!(receive(&mut node, &ids), (known, vec![0, 2, 3]));
    node.configure(0, parameters(INVALID | 0x205, 254, 0), &[]).unwrap();
    let known = vec![false, false, true, false, true, false];
    assert_eq!(receive(&mut node, &ids), (known, vec![2, 3]));
}

#[test]
fn an_invalid_one_takes_nothing() {
    let mut node = Node::with(0, parameters(0x205, 254, 20), &WORDS);
    node.receive(0x205, &DATA, ms(1));
    node.receive(0x205, &[], ms(1));
    node.told();
    // The error is gone with it. What it is mapped to does not matter.
    assert_eq!(node.configure(0, parameters(INVALID | 0x205, 254, 20), &[1, 2, 3]), Ok(()));
    assert_eq!(node.told(), [(0, Resolved(TooShort))]);
    assert!(!node.receive(0x205, &DATA, ms(2)));
    node.poll(ms(100));
    assert_eq!(node.told(), []);
    // Valid again, nothing is left of it.
    assert_eq!(node.configure(0, parameters(0x205, 254, 20), &WORDS), Ok(()));
    node.receive(0x205, &DATA, ms(200));
    assert_eq!(node.told(), [(0, Applied)]);
}

#[test]
fn a_configuration_that_cannot_work_changes_nothing() {
    let mut node = Node::with(0, parameters(NO_REMOTE | 0x205, 254, 0), &WORDS);
    let bad = [
        (0, 254, &[][..], AbortCode::ParameterIncompatible),
        (0, 254, &[entry(0x6020, 0, 8)], AbortCode::NotMappable),
        (0, 254, &[entry(0x7000, 0, 8)], AbortCode::NoObject),
        (0, 241, &WORDS, AbortCode::ValueRange),
        (0, 253, &WORDS, AbortCode::ValueRange),
        (4, 254, &WORDS, AbortCode::NoObject),
    ];
    for (number, transmission, mapping, code) in bad {
        assert_eq!(node.configure(number, parameters(0x305, transmission, 0), mapping), Err(code));
    }
    assert!(node.receive(0x205, &DATA, ms(1)));
    assert!(!node.receive(0x305, &DATA, ms(1)));
    assert_eq!(node.device.words, VALUES);
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn no_frames_ever_write_what_is_not_mapped(
        mapped in proptest::collection::vec(0..BOTH_WAYS.len(), 1..=8),
        transmission in prop_oneof![Just(1), Just(254)],
        frames in proptest::collection::vec((0x204_u16..0x207, proptest::collection::vec(any::<u8>(), 0..=8)), 1..50),
    ) {
        let entries: Vec<u32> =
            mapped.iter().map(|nth| BOTH_WAYS[*nth]).map(|(index, sub, bits)| entry(index, sub, bits)).collect();
        let mut node = Node::new();
        if node.configure(0, parameters(0x205, transmission, 5), &entries).is_err() {
            return Ok(());
        }
        let before = dump(&mut node.device);
        for (at, (id, data)) in frames.iter().enumerate() {
            prop_assert_eq!(node.receive(*id, data, ms(at as u64)), *id == 0x205);
            node.sync(Instant::NEVER);
            node.poll(ms(at as u64));
        }
        for ((address, before), (_, after)) in before.iter().zip(dump(&mut node.device)) {
            let is_mapped = entries.iter().any(|entry| {
                (entry >> 16) as u16 == address.index && (entry >> 8) as u8 == address.sub
            });
            prop_assert!(is_mapped || *before == after, "{:?}", address);
        }
    }
}
