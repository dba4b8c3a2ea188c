//! What an SDO may write to the parameters of a PDO.
//!
//! Verifies: ECSS 6.2a

use async_canopen::od::Record;
use async_canopen::pdo::machine::{Rpdos, Tpdos, rules};
use async_canopen::pdo::{Direction, Mapping, PdoMapping, PdoObjects, PdoParameters, PdoSet, StaticMapping};
use async_canopen::types::AbortCode;
use async_canopen::types::AbortCode::{
    NoObject, NoSubIndex, NotMappable, ParameterIncompatible, PdoLength, UnsupportedAccess, ValueRange,
    ValueTooHigh,
};

use super::device::{Device, WORDS, entry};
use crate::bench::ms;

const VALID: u32 = 0x4000_0185;
const INVALID: u32 = 0xC000_0185;

fn rpdo(cob_id: u32, sub: u8, value: u32) -> Result<PdoParameters, AbortCode> {
    rules::parameters(Direction::Receive, &PdoParameters { cob_id, ..Default::default() }, sub, value)
}

fn tpdo(cob_id: u32, sub: u8, value: u32) -> Result<PdoParameters, AbortCode> {
    rules::parameters(Direction::Transmit, &PdoParameters { cob_id, ..Default::default() }, sub, value)
}

/// What both kinds answer.
fn both(cob_id: u32, sub: u8, value: u32) -> Result<(), AbortCode> {
    let answers = [rpdo(cob_id, sub, value).map(drop), tpdo(cob_id, sub, value).map(drop)];
    assert_eq!(answers[0], answers[1], "{cob_id:08X} sub {sub} = {value:08X}");
    answers[0]
}

/// Verifies: ECSS 6.10a, 6.10c
#[test]
fn what_is_written_is_what_is_there() {
    let old = PdoParameters { cob_id: INVALID, ..Default::default() };
    assert_eq!(
        rules::parameters(Direction::Receive, &old, 1, 0x4000_0205),
        Ok(PdoParameters { cob_id: 0x4000_0205, ..old })
    );
    assert_eq!(
        rules::parameters(Direction::Receive, &old, 2, 240),
        Ok(PdoParameters { transmission: 240, ..old })
    );
    assert_eq!(
        rules::parameters(Direction::Receive, &old, 3, 0xFFFF),
        Ok(PdoParameters { inhibit: 0xFFFF, ..old })
    );
    assert_eq!(
        rules::parameters(Direction::Receive, &old, 5, 0x1234),
        Ok(PdoParameters { event_timer: 0x1234, ..old })
    );
    let old = PdoParameters { cob_id: INVALID, ..Default::default() };
    assert_eq!(
        rules::parameters(Direction::Transmit, &old, 1, 0x4000_0385),
        Ok(PdoParameters { cob_id: 0x4000_0385, ..old })
    );
    assert_eq!(
        rules::parameters(Direction::Transmit, &old, 2, 255),
        Ok(PdoParameters { transmission: 255, ..old })
    );
    assert_eq!(rules::parameters(Direction::Transmit, &old, 3, 10), Ok(PdoParameters { inhibit: 10, ..old }));
    assert_eq!(
        rules::parameters(Direction::Transmit, &old, 5, 0xFFFF),
        Ok(PdoParameters { event_timer: 0xFFFF, ..old })
    );
    assert_eq!(
        rules::parameters(Direction::Transmit, &old, 6, 240),
        Ok(PdoParameters { sync_start: 240, ..old })
    );
}

/// Verifies: ECSS 6.10a, 6.10c
#[test]
fn writes_of_the_cob_id() {
    let table = [
        // While invalid: any other, valid or not.
        (INVALID, 0xC000_0333, Ok(())),
        (INVALID, 0x4000_0333, Ok(())),
        (INVALID, 0x8000_0000, Ok(())),
        // While valid: the same, and any other that is not valid.
        (VALID, VALID, Ok(())),
        (VALID, INVALID, Ok(())),
        (VALID, 0xC000_0333, Ok(())),
        (VALID, 0x8000_0000, Ok(())),
        (VALID, 0x4000_0333, Err(UnsupportedAccess)),
        (VALID, 0x4000_0186, Err(UnsupportedAccess)),
        // Extended frames.
        (INVALID, 0x6000_0185, Err(ValueRange)),
        (INVALID, 0x4000_0985, Err(ValueRange)),
        (INVALID, 0x5000_0185, Err(ValueRange)),
        (INVALID, 0xE000_0185, Err(ValueRange)),
    ];
    for (old, new, expected) in table {
        assert_eq!(both(old, 1, new), expected, "{old:08X} -> {new:08X}");
    }
}

/// Verifies: ECSS 11.1c
#[test]
fn remote_frames_are_refused_where_they_would_be_answered() {
    assert_eq!(tpdo(INVALID, 1, 0x0000_0185).map(drop), Err(ValueRange));
    assert_eq!(tpdo(VALID, 1, 0x0000_0185).map(drop), Err(ValueRange));
    assert_eq!(tpdo(VALID, 1, 0x8000_0185).map(drop), Ok(()));
    assert_eq!(rpdo(INVALID, 1, 0x0000_0185).map(drop), Ok(()));
    assert_eq!(rpdo(VALID, 1, 0x0000_0185).map(drop), Ok(()));
}

/// Verifies: ECSS 6.10b, 9.5a
#[test]
fn no_valid_pdo_has_a_restricted_identifier() {
    let restricted =
        [(0x000, 0x07F), (0x101, 0x180), (0x581, 0x5FF), (0x601, 0x67F), (0x6E0, 0x6FF), (0x701, 0x7FF)];
    for id in 0..=0x7FF {
        let refused = restricted.iter().any(|(first, last)| (*first..=*last).contains(&id));
        let expected = if refused { Err(ValueRange) } else { Ok(()) };
        assert_eq!(both(0xC000_0000, 1, 0x4000_0000 | id), expected, "{id:03X}");
        assert_eq!(both(0xC000_0000, 1, 0xC000_0000 | id), Ok(()), "{id:03X}");
    }
}

/// Verifies: ECSS 11.1c
#[test]
fn reserved_transmission_types_are_refused() {
    for cob_id in [VALID, INVALID] {
        for transmission in 0..=255 {
            let expected = if (241..=253).contains(&transmission) { Err(ValueRange) } else { Ok(()) };
            assert_eq!(both(cob_id, 2, transmission), expected, "{transmission}");
        }
        assert_eq!(both(cob_id, 2, 0x1FE), Err(ValueRange));
    }
}

/// Given a valid PDO, then a client cannot change its inhibit time and SYNC start value.
///
/// Verifies: ECSS 11.1d
/// Notices: ECSS 11.1d: the inhibit time of a valid PDO is changed.
#[test]
fn inhibit_time_and_sync_start_value_change_while_invalid_only() {
    assert_eq!(both(VALID, 3, 5), Err(UnsupportedAccess));
    assert_eq!(both(INVALID, 3, 5), Ok(()));
    assert_eq!(tpdo(VALID, 6, 5).map(drop), Err(UnsupportedAccess));
    assert_eq!(tpdo(INVALID, 6, 5).map(drop), Ok(()));
    assert_eq!(both(VALID, 5, 5), Ok(()));
}

#[test]
fn what_is_too_large_or_not_there() {
    assert_eq!(both(INVALID, 3, 0x1_0000), Err(ValueTooHigh));
    assert_eq!(both(INVALID, 5, 0x1_0000), Err(ValueTooHigh));
    assert_eq!(tpdo(INVALID, 6, 241).map(drop), Err(ValueTooHigh));
    for sub in [0, 4, 7, 255] {
        assert_eq!(both(INVALID, sub, 0), Err(NoSubIndex));
    }
    assert_eq!(rpdo(INVALID, 6, 0).map(drop), Err(NoSubIndex));
}

/// A mapping with these entries, `count` of them in use.
fn mapping(entries: &[u32], count: u8) -> PdoMapping {
    let mut mapping = PdoMapping::default();
    mapping.map(entries);
    mapping.count = count;
    mapping
}

fn map(cob_id: u32, mapping: &mut PdoMapping, sub: u8, value: u32) -> Result<(), AbortCode> {
    let before = *mapping;
    let answer = rules::mapping::<Device>(Direction::Receive, cob_id, mapping, sub, value);
    assert_eq!(*mapping, before);
    answer
}

#[test]
fn a_mapping_changes_while_its_pdo_is_invalid_only() {
    for sub in 0..=8 {
        assert_eq!(map(VALID, &mut mapping(&[], 0), sub, 0), Err(UnsupportedAccess), "{sub}");
        assert_eq!(map(INVALID, &mut mapping(&[], 0), sub, 0), Ok(()), "{sub}");
    }
    assert_eq!(map(INVALID, &mut mapping(&[], 0), 9, 0), Err(NoSubIndex));
}

#[test]
fn mapped_objects_change_while_their_number_is_zero_only() {
    let word = entry(0x6000, 1, 16);
    for count in 1..=4 {
        for sub in 1..=8 {
            assert_eq!(map(INVALID, &mut mapping(&WORDS, count), sub, word), Err(UnsupportedAccess));
        }
        assert_eq!(map(INVALID, &mut mapping(&WORDS, count), 0, 0), Ok(()));
    }
    for sub in 1..=8 {
        assert_eq!(map(INVALID, &mut mapping(&WORDS, 0), sub, word), Ok(()));
    }
}

#[test]
fn a_mapped_object_is_checked_as_it_is_written() {
    let table = [
        (entry(0x6000, 1, 16), Ok(())),
        (entry(0x0005, 0, 8), Ok(())),
        (0, Ok(())),
        (entry(0x7000, 0, 8), Err(NoObject)),
        (entry(0x6000, 9, 16), Err(NoSubIndex)),
        (entry(0x6000, 1, 15), Err(NotMappable)),
        (entry(0x6020, 0, 8), Err(NotMappable)),
        (entry(0x6025, 0, 8), Err(NotMappable)),
    ];
    for (value, expected) in table {
        assert_eq!(map(INVALID, &mut mapping(&[], 0), 1, value), expected, "{value:08X}");
    }
}

#[test]
fn their_number_is_accepted_when_all_of_them_fit() {
    let wide = entry(0x611B, 0, 64);
    let flag = entry(0x6001, 1, 1);
    let table = [
        (&WORDS[..], 4, Ok(())),
        (&WORDS, 2, Ok(())),
        (&[flag; 8], 8, Ok(())),
        (&[flag; 8], 9, Err(PdoLength)),
        (&[flag; 8], 254, Err(PdoLength)),
        (&[flag; 8], 255, Err(PdoLength)),
        (&[wide, flag], 2, Err(PdoLength)),
        (&[wide, flag], 1, Ok(())),
        // The fifth was never written.
        (&WORDS, 5, Err(NoObject)),
        (&[flag, entry(0x6020, 0, 8)], 2, Err(NotMappable)),
        (&[flag, entry(0x6020, 0, 8)], 1, Ok(())),
        (&[flag, entry(0x6001, 9, 1)], 2, Err(NoSubIndex)),
    ];
    for (entries, count, expected) in table {
        assert_eq!(map(INVALID, &mut mapping(entries, 0), 0, count), expected, "{entries:X?} {count}");
        let mut fixed = StaticMapping::default();
        fixed.map(entries);
        assert_eq!(rules::mapping::<Device>(Direction::Receive, INVALID, &mut fixed, 0, count), expected);
    }
}

#[test]
fn the_direction_matters() {
    let mut transmit = mapping(&[entry(0x6020, 0, 8)], 0);
    let check = |mapping: &mut _, direction| rules::mapping::<Device>(direction, INVALID, mapping, 0, 1);
    assert_eq!(check(&mut transmit, Direction::Transmit), Ok(()));
    assert_eq!(check(&mut transmit, Direction::Receive), Err(NotMappable));
}

/// The whole procedure, the way configuration tools go.
///
/// Verifies: ECSS 6.10a
#[test]
fn a_pdo_is_remapped_step_by_step() {
    let mut parameters = PdoParameters { cob_id: VALID, transmission: 1, ..Default::default() };
    let mut mapping = mapping(&WORDS, 4);
    let mut tpdos = Tpdos::<PdoObjects<1, 1>>::new(&PdoSet::NONE);
    let mut step = |parameters: &mut PdoParameters, mapping: &PdoMapping, sub, value| {
        let new = rules::parameters(Direction::Transmit, parameters, sub, value)?;
        tpdos.configure(
            0,
            &new,
            rules::resolve::<Device>(Direction::Transmit, &new, mapping.objects())?,
            ms(0),
        )?;
        *parameters = new;
        Ok::<(), AbortCode>(())
    };
    assert_eq!(step(&mut parameters, &mapping, 1, INVALID), Ok(()));
    assert_eq!(step(&mut parameters, &mapping, 3, 100), Ok(()));
    for (sub, value) in [(0, 0), (1, entry(0x6103, 0, 16)), (2, entry(0x6001, 3, 1)), (0, 2)] {
        let cob_id = parameters.cob_id;
        assert_eq!(rules::mapping::<Device>(Direction::Transmit, cob_id, &mut mapping, sub, value), Ok(()));
        mapping.variable(sub).unwrap().set_bits(u64::from(value));
        if (sub, value) == (0, 0) {
            // Nothing mapped: it cannot become valid.
            assert_eq!(step(&mut parameters, &mapping, 1, VALID), Err(ParameterIncompatible));
        }
    }
    assert_eq!(step(&mut parameters, &mapping, 1, VALID), Ok(()));
    assert_eq!(parameters.cob_id, VALID);

    let mut device = Device::default();
    device.flags[2] = true;
    device.wide.i16 = 0x1234;
    tpdos.start(ms(0));
    let mut sent = vec![];
    tpdos.on_sync(0, &device, &mut |_, frame, _| {
        sent.push(frame);
        true
    });
    assert_eq!(sent, [crate::bench::frame(0x185, &[0x34, 0x12, 0x01])]);
}

#[test]
fn there_may_be_512_each_way() {
    let mut rpdos = Box::new(Rpdos::<PdoObjects<512, 512>>::new());
    let mut tpdos = Box::new(Tpdos::<PdoObjects<512, 512>>::new(&PdoSet::NONE));
    let receive = PdoParameters { cob_id: 0x4000_0205, ..Default::default() };
    let transmit = PdoParameters { cob_id: VALID, transmission: 1, ..Default::default() };
    assert_eq!(
        rpdos.configure(
            511,
            &receive,
            rules::resolve::<Device>(Direction::Receive, &receive, &WORDS).unwrap(),
            false,
        ),
        Ok(())
    );
    assert_eq!(
        tpdos.configure(
            511,
            &transmit,
            rules::resolve::<Device>(Direction::Transmit, &transmit, &WORDS).unwrap(),
            ms(0)
        ),
        Ok(())
    );
    let mut device = Device::default();
    let data = [1, 0, 2, 0, 3, 0, 4, 0];
    let received = crate::bench::frame(0x205, &data);
    assert_eq!(rpdos.first(received.id()), Some(511));
    assert!(rpdos.on_plain_frame(511, &received, &mut device));
    assert_eq!(rpdos.next(received.id(), 511), None);
    tpdos.start(ms(1));
    let mut sent = vec![];
    tpdos.on_sync(0, &device, &mut |number, frame, _| {
        sent.push((number, frame));
        true
    });
    assert_eq!(sent, [(511, crate::bench::frame(0x185, &data))]);
}
