//! Values that a frame may leave out; for all others the length rule of CiA 301 holds.
//!
//! Verifies: ECSS 6.2a

use async_canopen::od::{Objects, Record};
use async_canopen::pdo::machine::{Rpdos, Taken, rules};
use async_canopen::pdo::{Direction, PdoObjects, PdoParameters, RpdoError, RpdoEvent};
use async_canopen::types::Instant;

use crate::bench::{frame, ms};

/// A device with a request.
#[derive(Clone, Debug, Objects)]
struct Device {
    /// Request
    #[object(0x6101, record)]
    request: Request,
    /// Switch
    #[object(0x6102, rw, pdo, optional)]
    switch: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Record)]
struct Request {
    /// Code
    #[sub(1, rww, pdo)]
    code: u16,
    /// Data
    #[sub(2, rww, pdo, optional)]
    data: u32,
}

const CODE: u32 = 0x6101_0110;
const DATA: u32 = 0x6101_0220;
const SWITCH: u32 = 0x6102_0008;
/// 2 bytes of no meaning.
const DUMMY: u32 = 0x0006_0010;

/// What becomes of a frame of so many bytes, and which errors appear or go.
fn taken(mapping: &[u32], lengths: &[usize]) -> (Device, Vec<Taken>, Vec<RpdoEvent>) {
    let (mut rpdos, mut device, mut told) = (Rpdos::<PdoObjects<1, 1>>::new(), Device::default(), Vec::new());
    let parameters = PdoParameters { cob_id: 0x205, transmission: 254, ..PdoParameters::default() };
    rpdos
        .configure(
            0,
            &parameters,
            rules::resolve::<Device>(Direction::Receive, &parameters, mapping).unwrap(),
            false,
        )
        .unwrap();
    (device.request, device.switch) = (Request { code: 0xAAAA, data: 0xBBBB_BBBB }, 0xCC);
    let all = lengths.iter().map(|length| {
        let frame = frame(0x205, &[1, 2, 3, 4, 5, 6, 7, 8][..*length]);
        if rpdos.on_plain_frame(0, &frame, &mut device) {
            return Taken::Applied;
        }
        let taken = rpdos.on_frame(0, &frame, ms(1), Instant::NEVER, &mut device);
        told.extend(std::iter::from_fn(|| rpdos.take_event()).map(|(_, event)| event));
        taken
    });
    let all = all.collect();
    (device, all, told)
}

/// Verifies: ECSS 9.4.1a
#[test]
fn a_frame_may_end_before_an_optional_value() {
    let (device, all, told) = taken(&[CODE, DATA], &[6, 5, 4, 3, 2]);
    assert_eq!((all, told), (vec![Taken::Applied; 5], vec![]));
    assert_eq!(device.request, Request { code: 0x0201, data: 0 }, "what is left out reads as zero");
    let (device, ..) = taken(&[CODE, DATA], &[4]);
    assert_eq!(device.request, Request { code: 0x0201, data: 0x0403 }, "what is there is taken");
    let (device, all, told) = taken(&[CODE, SWITCH], &[2]);
    assert_eq!((device.switch, all, told), (0, vec![Taken::Applied], vec![]), "an object of its own, too");
}

#[test]
fn a_frame_without_a_required_value_is_rejected() {
    let error = vec![RpdoEvent::Error(RpdoError::TooShort)];
    let untouched = Request { code: 0xAAAA, data: 0xBBBB_BBBB };
    for (mapping, lengths) in [
        (&[CODE, DATA][..], &[1, 0][..]),
        // An optional value is required as long as one that is not comes behind it.
        (&[DATA, CODE], &[5, 4]),
        (&[CODE, DATA, DUMMY], &[7, 6, 2]),
    ] {
        let (device, all, told) = taken(mapping, lengths);
        assert_eq!((all, &told), (vec![Taken::Rejected; lengths.len()], &error), "{mapping:08X?}");
        assert_eq!(device.request, untouched, "{mapping:08X?}");
    }
}

#[test]
fn a_short_frame_resolves_the_error_of_one_too_short() {
    let (_, all, told) = taken(&[CODE, DATA], &[1, 2, 8, 2]);
    let (error, resolved) = (RpdoEvent::Error, RpdoEvent::Resolved);
    assert_eq!(all, [Taken::Rejected, Taken::Applied, Taken::Applied, Taken::Applied]);
    let (short, long) = (RpdoError::TooShort, RpdoError::TooLong);
    assert_eq!(told, [error(short), resolved(short), error(long), resolved(long)]);
}
