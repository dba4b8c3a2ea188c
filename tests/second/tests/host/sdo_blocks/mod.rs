//! Block transfers of the SDO client of `ecss-can` with third-party servers, in one process and in virtual time.
//!
//! [`zencan`] is a complete node, [`codecs`] has third-party frames in an order of this project. A third one, on the
//! bus of a spacecraft, is in `tests/tools/sdo_client.rs`.

mod codecs;
mod line;
mod zencan;

use ecss_can::sdo::Error;
use ecss_can::sdo::machine::Payload;
use ecss_can::types::{AbortCode, Address};

use self::codecs::{Codecs, OBJECT};
use self::line::Line;
use self::zencan::{CONSTANT, DOMAIN, KEY, STRING, Zencan};

/// Sizes: a byte, a segment, a byte more, a sub-block and one byte less and more, and many sub-blocks.
const SIZES: [usize; 7] = [1, 7, 8, 888, 889, 890, 20_000];

/// Largest size of a read.
const MOST: usize = 20_000;

fn random(size: usize) -> Vec<u8> {
    let mut random = fastrand::Rng::with_seed(size as u64);
    std::iter::repeat_with(|| random.u8(..)).take(size).collect()
}

/// Frames of a download whose sub-blocks are full: both requests and their answers, segments, acknowledgements.
fn frames_of_download(size: usize) -> usize {
    4 + size.div_ceil(7) + size.div_ceil(889)
}

/// Command specifier of the nth frame.
fn command<S>(line: &Line<S>, nth: usize) -> u8 {
    line.sent[nth].1[0]
}

/// Verifies: ECSS 6.1a
#[test]
fn values_are_downloaded_to_a_node_of_zencan() {
    let mut line = Line::new(Zencan::new());
    for size in SIZES {
        let value = random(size);
        assert_eq!(line.download(DOMAIN, &value), Ok(size));
        assert_eq!(line.server.value(), value);
        assert_eq!((command(&line, 0), command(&line, 1)), (0xC6, 0xA4));
        assert_eq!(line.sent.len(), frames_of_download(size));
    }
}

/// Verifies: ECSS 6.1a
#[test]
fn values_are_uploaded_from_a_node_of_zencan() {
    let mut line = Line::new(Zencan::new());
    for size in SIZES.into_iter().filter(|size| size % 7 != 0) {
        let value = random(size);
        line.server.set(&value);
        assert_eq!(line.upload(DOMAIN, MOST), Ok(value));
        assert_eq!((command(&line, 0), command(&line, 1), command(&line, 2)), (0xA4, 0xC4, 0xA3));
    }
}

/// zencan-node 0.0.5 says at the end that no byte of a full last segment counts, and has no last segment at all when it
/// fills its sub-block (CiA 301 7.2.4.3.15: 0 to 6 bytes without data). The client takes neither for a value.
#[test]
fn a_wrong_end_of_an_upload_is_an_error() {
    let mut line = Line::new(Zencan::new());
    for (size, error) in [
        (7, Error::Protocol(AbortCode::Crc)),
        (896, Error::Protocol(AbortCode::Crc)),
        // The end came in the place of a segment, and was repeated.
        (889, Error::Abort(AbortCode::CommandSpecifier)),
    ] {
        line.server.set(&random(size));
        assert_eq!(line.upload(DOMAIN, MOST), Err(error), "{size}");
        line.server.set(&random(890));
        assert_eq!(line.upload(DOMAIN, MOST), Ok(random(890)), "after {size}");
    }
}

/// Hides from both sides that the other one supports a CRC.
fn hide_crc([command, ..]: &mut Payload) {
    if [0xC6, 0xA4, 0xC4].contains(command) {
        *command &= !0x04;
    }
}

/// Given a line that clears the CRC bits, because client and node always set them, then a value is transferred without
/// a check.
#[test]
fn without_a_crc_a_value_is_moved_and_not_checked() {
    let mut line = Line::new(Zencan::new());
    line.disturb(|_, payload| {
        hide_crc(payload);
        true
    });
    for size in SIZES {
        let value = random(size);
        assert_eq!(line.download(DOMAIN, &value), Ok(size));
        assert_eq!(line.server.value(), value);
        let [.., (_, [end, low, high, ..]), (_, [0xA1, ..])] = line.sent[..] else { panic!("no end") };
        assert_eq!((end & 0xE3, low, high), (0xC1, 0, 0));
        if size % 7 != 0 {
            assert_eq!(line.upload(DOMAIN, MOST), Ok(value));
        }
    }
    line.disturb(|nth, payload| {
        hide_crc(payload);
        payload[1] ^= u8::from(nth == 5);
        true
    });
    let mut changed = random(300);
    assert_eq!(line.download(DOMAIN, &changed), Ok(300));
    // Behind the request and its answer the first segment.
    changed[3 * 7] ^= 1;
    assert_eq!(line.server.value(), changed);
}

/// Given a byte that changes on the line, which the CRC of a CAN frame normally prevents, then both sides refuse the
/// value.
///
/// Verifies: ECSS 6.1a
#[test]
fn both_sides_refuse_a_value_with_another_crc() {
    let mut line = Line::new(Zencan::new());
    let (old, new) = (random(2000), random(1999));
    // Frames of the first and of the second sub-block.
    for frame in [4, 200] {
        line.server.set(&old);
        line.disturb(move |nth, payload| {
            payload[7] ^= u8::from(nth == frame);
            true
        });
        assert_eq!(line.upload(DOMAIN, MOST), Err(Error::Protocol(AbortCode::Crc)));
        assert_eq!(line.download(DOMAIN, &new), Err(Error::Abort(AbortCode::Crc)));
        assert_eq!(line.server.value(), old);
        line.disturb(|_, _| true);
        assert_eq!(line.download(DOMAIN, &new), Ok(1999));
    }
}

/// Given lost frames, then a value is right, or there is an error. The node accepts the repetition of a complete
/// sub-block. After a part of one it expects consecutive numbers (CiA 301 7.2.4.3.10: they start with 1 again), which
/// its CRC then detects. It repeats sub-blocks of an upload from their start regardless of the acknowledgement, and
/// counts them twice in its CRC.
#[test]
fn a_value_is_right_or_an_error_whatever_is_lost() {
    let mut line = Line::new(Zencan::new());
    let (old, new) = (random(8), random(300));
    let segments = 300_usize.div_ceil(7);
    let is_first = |lost| lost == 2;
    for lost in 0..segments + 5 {
        line.server.set(&old);
        line.disturb(move |nth, _| nth != lost);
        let outcome = line.download(DOMAIN, &new);
        assert_eq!(outcome.is_ok(), is_first(lost), "{lost}: {outcome:?}");
        // A value whose last answer is lost is written.
        let is_written = outcome.is_ok() || lost == segments + 4;
        assert_eq!(line.server.value(), if is_written { &new[..] } else { &old }, "{lost}");

        line.server.set(&new);
        line.disturb(move |nth, _| nth != lost);
        let outcome = line.upload(DOMAIN, MOST);
        assert!(outcome.is_err(), "{lost}: {outcome:?}");

        line.disturb(|_, _| true);
        assert_eq!(line.upload(DOMAIN, MOST).as_ref(), Ok(&new), "after {lost}");
        assert_eq!(line.download(DOMAIN, &old), Ok(old.len()), "after {lost}");
    }
}

/// Verifies: ECSS 6.1a
#[test]
fn refusals_of_a_node_of_zencan_have_their_abort_codes() {
    use AbortCode::{NoObject, NoSubIndex, ReadOnly, TooLong, WriteOnly};
    let mut line = Line::new(Zencan::new());
    let unknown = Address::new(0x2004, 0);
    let no_member = Address::new(DOMAIN.index, 1);
    for (at, code) in [(KEY, WriteOnly), (unknown, NoObject), (no_member, NoSubIndex)] {
        assert_eq!(line.upload(at, MOST), Err(Error::Abort(code)), "{at:?}");
    }
    // At the end of a single sub-block, or of the first one, or at once.
    for size in [101, 1000] {
        for (at, code) in
            [(CONSTANT, ReadOnly), (STRING, TooLong), (unknown, NoObject), (no_member, NoSubIndex)]
        {
            assert_eq!(line.download(at, &random(size)), Err(Error::Abort(code)), "{at:?}");
        }
    }
    // More than the application takes.
    line.server.set(&random(890));
    for most in [100, 889] {
        assert_eq!(line.upload(DOMAIN, most), Err(Error::TooLarge));
    }
    assert_eq!(line.upload(DOMAIN, 890), Ok(random(890)));
}

/// CiA 301 7.2.4.3.17: an abort ends a transfer, also in the middle of a sub-block.
#[test]
fn a_download_given_up_changes_nothing() {
    let mut line = Line::new(Zencan::new());
    line.server.set(&random(8));
    for frames in 1..130 {
        line.give_up_download(DOMAIN, &random(900), frames);
        assert_eq!(line.server.value(), random(8), "{frames}");
        assert_eq!(line.upload(DOMAIN, MOST), Ok(random(8)), "{frames}");
    }
}

/// Verifies: ECSS 6.1a
#[test]
fn sub_blocks_of_any_size_move_with_and_without_crc() {
    for sizes in [&[127][..], &[1], &[126, 1, 5, 64]] {
        for crc in [true, false] {
            let mut line = Line::new(Codecs::new(crc, sizes));
            for size in SIZES {
                let value = random(size);
                assert_eq!(line.download(OBJECT, &value), Ok(size), "{sizes:?} {crc}");
                assert_eq!(line.server.value, value);
                assert_eq!(line.upload(OBJECT, MOST), Ok(value), "{sizes:?} {crc}");
            }
        }
    }
}
