//! Stamps of SYNC from the falling edges of CAN_RX (ECSS 7.2.3).
//!
//! Verifies: ECSS 7.2.3c, 7.2.3k

use std::sync::atomic::Ordering;

use async_canopen::link::{Captured, EdgeRing, Miss, Stamp, StampSource};
use async_canopen::types::{CobId, Frame, Instant};

/// Ticks of the capture timer in a microsecond, which is also a bit at 1 Mbit/s.
const PER_MICRO: u32 = 84;
/// SOF of the SYNC, microseconds.
const START: u64 = 1_000;
/// Bits of a SYNC without data from SOF to the end of EOF (ISO 11898-1), four of them stuff bits.
const LENGTH: u64 = 48;
/// Those of its bits that begin with a falling edge. The last one is the ACK slot.
const FALLS: [u64; 9] = [0, 5, 11, 17, 23, 27, 33, 36, 39];

/// Stamp of one SYNC that the interrupt reports at this microsecond.
fn stamp(reported: u64) -> Result<Stamp, Miss> {
    let ring = EdgeRing::<PER_MICRO>::new();
    let ticks = |micros: u64| micros as u32 * PER_MICRO;
    for (cell, bit) in ring.cells().iter().zip(FALLS) {
        cell.store(ticks(START + bit), Ordering::Relaxed);
    }
    let line = Captured { next: FALLS.len(), alone_until: ticks(reported + 200) };
    let sync = Frame::of(CobId::SYNC, []);
    ring.stamp(line, &sync, Stamp::interrupt(Instant::from_micros(reported)), PER_MICRO)
}

/// Given a SYNC that the interrupt reports up to 43 bits after its end, then the stamp is the end of its last bit.
#[test]
fn a_sync_is_stamped_with_the_end_of_its_last_bit() {
    let end = START + LENGTH;
    for reported in [end - 4, end - 1, end, end + 10, end + 43] {
        let stamp = stamp(reported).unwrap();
        assert_eq!(stamp.source, StampSource::Capture, "{reported}");
        assert_eq!(stamp.at, Instant::from_micros(end), "{reported}");
    }
}

/// Given a report more than two bits and two microseconds before the frame of the edges ends, then they are those of another frame.
#[test]
fn edges_of_a_frame_that_ends_later_give_no_stamp() {
    assert_eq!(stamp(START + LENGTH - 5), Err(Miss::Mismatch));
}

/// Given a report so late that another frame like it could have ended in between, then the stamp is not certain.
#[test]
fn a_report_that_is_a_frame_late_gives_no_stamp() {
    assert_eq!(stamp(START + LENGTH + 44), Err(Miss::Late));
}
