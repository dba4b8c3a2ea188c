//! Frames of one COB-ID in a row: the segments of an SDO block upload (CiA 301 7.2.4.3.13).

use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::fault::{Fault, Flip, Nodes, Place};
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

const SLAVE: u8 = 2;
const REQUESTS: u16 = 0x602;
const RESPONSES: u16 = 0x582;

/// Segments of the value: more than two per mailbox, in one sub-block.
const SEGMENTS: u8 = 58;

/// Longest gap: the intermission at the slave, whose crystal is 31 ppm slow, and a microsecond for the transmit
/// interrupt.
const NO_GAP: Time = Time::from_us(4);
/// The longest gap if the supervisor's interrupt, which comes ten times a second, delays that of the driver once.
const TICK: Time = Time::from_us(10);

/// A master, a slave, and a client on the nominal bus that has written the data of 6300h.
struct Download {
    flight: Flight,
    client: GuestId,
    /// Another guest there.
    rival: GuestId,
    /// A guest on the redundant bus.
    caller: GuestId,
}

impl Download {
    fn new() -> Download {
        let mut flight = Flight::new(&MASTER_AND_THREE[..2]);
        let client = flight.twin.add_guest(Bus::Nominal, 10.0);
        let rival = flight.twin.add_guest(Bus::Nominal, 12.0);
        let caller = flight.twin.add_guest(Bus::Redundant, 10.0);
        flight.fly_to(1_000);
        let mut download = Download { flight, client, rival, caller };
        let bytes = 7 * SEGMENTS as u16;
        let [low, high] = bytes.to_le_bytes();
        download.ask([0xC2, 0x00, 0x63, 0, low, high, 0, 0]);
        for number in 1..SEGMENTS {
            download.request([number, number, 1, 2, 3, 4, 5, 6]);
        }
        let acknowledged = download.ask([0x80 | SEGMENTS, SEGMENTS, 1, 2, 3, 4, 5, 6]);
        assert_eq!(acknowledged.data()[..2], [0xA2, SEGMENTS]);
        assert_eq!(download.ask([0xC1, 0, 0, 0, 0, 0, 0, 0]).data()[0], 0xA1);
        download
    }

    fn request(&mut self, payload: [u8; 8]) {
        let at = self.flight.end;
        self.flight.twin.inject(self.client, at, WireFrame::standard(REQUESTS, &payload));
    }

    fn response(&mut self) -> Seen {
        self.flight.fly_until(|seen| seen.id() == Some(RESPONSES))
    }

    fn ask(&mut self, payload: [u8; 8]) -> Seen {
        self.request(payload);
        self.response()
    }

    /// Starts an upload. Returns before its first segment is sent.
    fn start(&mut self) {
        let begun = self.ask([0xA0, 0x00, 0x63, 0, SEGMENTS, 0, 0, 0]);
        assert_eq!(begun.data()[0] & 0xE1, 0xC0, "{:02X?}", begun.data());
        self.request([0xA3, 0, 0, 0, 0, 0, 0, 0]);
    }

    /// Flies to the end of segment `number`, where the other guest begins to send `frames` with a low identifier, and on
    /// until it does so. Returns the number of the last segment that was sent.
    fn flood_after(&mut self, number: u8, frames: usize) -> u8 {
        self.flight.fly_until(|seen| seen.id() == Some(RESPONSES) && seen.data()[0] == number);
        for _ in 0..frames {
            self.flight.twin.inject(self.rival, self.flight.end, WireFrame::standard(0x010, &[0x55; 8]));
        }
        // One segment may be on the wire already.
        self.flight.fly(self.flight.end + ms(1));
        self.flight.sent(SLAVE, Bus::Nominal, RESPONSES).last().unwrap().data()[0]
    }

    /// Flies to the end of a sub-block of `count` segments, the last one, and ends the upload. Returns the segments as they
    /// were sent, from `from` on.
    fn finish(&mut self, from: Time, count: u8) -> Vec<Seen> {
        self.flight.fly_until(|seen| seen.id() == Some(RESPONSES) && seen.data()[0] == 0x80 | count);
        let sent = self.flight.sent(SLAVE, Bus::Nominal, RESPONSES).filter(|seen| seen.start > from);
        let segments = sent.cloned().collect();
        let end = self.ask([0xA2, count, SEGMENTS, 0, 0, 0, 0, 0]);
        assert_eq!(end.data()[0], 0xC1);
        self.request([0xA1, 0, 0, 0, 0, 0, 0, 0]);
        self.flight.fly(self.flight.end + ms(1));
        segments
    }
}

/// Number and first byte of each segment, as the client wrote them.
fn assert_complete(segments: &[Seen]) {
    let numbers: Vec<[u8; 2]> = segments.iter().map(|seen| [seen.data()[0] & 0x7F, seen.data()[1]]).collect();
    assert_eq!(numbers, (1..=SEGMENTS).map(|number| [number; 2]).collect::<Vec<_>>());
}

/// Given a client that uploads by blocks
/// When the slave sends a sub-block
/// Then each segment follows the frame before it after no more than the intermission. The supervisor may delay one of them.
///
/// Verifies: ECSS 6.1a
#[test]
fn segments_of_an_upload_follow_without_a_gap() {
    let mut download = Download::new();
    download.start();
    let from = download.flight.end;
    let segments = download.finish(from, SEGMENTS);
    assert_complete(&segments);
    let of_bus: Vec<&Seen> = download.flight.on(Bus::Nominal).collect();
    let pairs = of_bus.windows(2).filter(|pair| segments[1..].contains(pair[1]));
    let gaps: Vec<Time> = pairs.map(|pair| pair[1].start.since(pair[0].end)).collect();
    let late: Vec<Time> = gaps.iter().copied().filter(|gap| *gap >= NO_GAP).collect();
    assert_eq!(gaps.len(), usize::from(SEGMENTS) - 1);
    assert!(late.len() <= 1 && late.iter().all(|gap| *gap < TICK), "{late:?}");
    download.flight.assert_nothing_lost();
}

/// Given a client that uploads by blocks
/// When every third attempt to send a segment is destroyed, which in turn strikes a segment in each mailbox
/// Then all segments are sent once, in their order.
///
/// Verifies: ECSS 6.1a
#[test]
fn segments_destroyed_on_the_bus_keep_their_order() {
    let mut download = Download::new();
    let slave = download.flight.board(SLAVE).0;
    for phase in 0..3 {
        download.start();
        let from = download.flight.end;
        for number in 1..SEGMENTS {
            let segment = download.response();
            assert_eq!(segment.data()[0], number);
            if number % 3 == phase {
                // In the middle of the next segment.
                let flip = Flip::new(Place::Field(Field::Data(40)), Nodes::of(&[slave]));
                let at = segment.end + Time::from_us(30);
                download.flight.twin.wire_mut(Bus::Nominal).schedule(at, Fault::Flip(flip)).unwrap();
            }
        }
        assert_complete(&download.finish(from, SEGMENTS));
        let destroyed = download.flight.attempts(SLAVE, Bus::Nominal).filter(|at| *at > from).count();
        let flips = (1..SEGMENTS).filter(|number| number % 3 == phase).count();
        // Every 100 ms a command of the master is sent between two segments, and the flip misses the segment.
        assert!((flips - 1..=flips).contains(&destroyed), "{destroyed} of {flips} in phase {phase}");
    }
    download.flight.assert_nothing_lost();
}

/// Given a client that uploads by blocks When other frames hold the bus for longer than segments live, from any mailbox
/// on Then no expired segment is sent later, the following ones are sent, and the client requests the missing ones
/// again.
///
/// Verifies: ECSS 6.1a
#[test]
fn segments_that_expire_free_their_mailboxes() {
    /// Segments in the mailboxes and in the queue.
    const WINDOW: u8 = 8;
    let mut download = Download::new();
    for number in 10..13 {
        download.start();
        // 590 ms, a segment lives 500 ms.
        let last = download.flood_after(number, 5_000);
        let from = download.flight.end;
        download.flight.fly(from + ms(700));
        let sent = download.flight.sent(SLAVE, Bus::Nominal, RESPONSES).filter(|seen| seen.start > from);
        let numbers: Vec<u8> = sent.map(|seen| seen.data()[1]).collect();
        assert_eq!(numbers, (last + WINDOW + 1..=SEGMENTS).collect::<Vec<_>>());

        let from = download.flight.end;
        download.request([0xA2, last, SEGMENTS, 0, 0, 0, 0, 0]);
        let left = SEGMENTS - last;
        let again: Vec<u8> = download.finish(from, left).iter().map(|seen| seen.data()[1]).collect();
        assert_eq!(again, (last + 1..=SEGMENTS).collect::<Vec<_>>());
    }
    download.flight.assert_sound();
}

/// Given a client that uploads by blocks, and other frames that hold the bus
/// When the master's heartbeat calls the slave to the other bus
/// Then no segment that was in a mailbox is sent on the bus that was left, and an upload after the return is complete.
///
/// Verifies: ECSS 8.3.3b, 6.1a, 8.3.3g
#[test]
fn segments_of_a_bus_that_was_left_are_not_sent() {
    for number in 10..13 {
        let mut download = Download::new();
        download.start();
        download.flood_after(number, 40);
        let from = download.flight.end;
        download.flight.twin.inject(download.caller, from, WireFrame::standard(0x701, &[OPERATIONAL]));
        download.flight.fly(from + ms(10));
        let sent_on = |bus| download.flight.sent(SLAVE, bus, RESPONSES).filter(|seen| seen.start > from);
        let commands = |bus| sent_on(bus).map(|seen| seen.data()[0]).collect::<Vec<_>>();
        assert_eq!(sent_on(Bus::Nominal).count(), 0, "after segment {number}");
        assert_eq!(commands(Bus::Redundant), [0x80], "the abort");
        // The master still commands on the nominal bus and takes the slave back.
        download.flight.fly(from + ms(300));
        download.start();
        let from = download.flight.end;
        assert_complete(&download.finish(from, SEGMENTS));
        download.flight.assert_sound();
    }
}
