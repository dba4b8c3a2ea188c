//! Requirements on the driver of the controllers: few interrupts, order of frames, urgent frames first, and correct
//! results.

use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

/// Longest frame of 8 bytes: 55 + 10 * 8 bits with stuffing and intermission, at 1 Mbit/s.
const LONGEST_FRAME: Time = Time::from_us(135);

fn flood(flight: &mut Flight, guest: GuestId, from: Time, id: u16, frames: usize) {
    for _ in 0..frames {
        flight.twin.inject(guest, from, WireFrame::standard(id, &[0x55; 8]));
    }
}

fn delta(before: [u32; 3], after: [u32; 3]) -> [u32; 3] {
    std::array::from_fn(|n| after[n] - before[n])
}

/// Given a lone master, which repeats each frame until it expires, with thousands of errors per second, then expired
/// frames cause interrupts and failed attempts do not.
#[test]
fn a_lone_transmitter_does_not_interrupt_with_every_attempt() {
    let mut flight = Flight::new(&MASTER_AND_THREE[..1]);
    flight.fly_to(1000);
    let before = flight.diagnostics(MASTER).interrupts;
    let attempts_before = flight.attempts(MASTER, Bus::Nominal).count();
    flight.fly_to(3000);
    let [results, received, errors] = delta(before, flight.diagnostics(MASTER).interrupts);
    let attempts = flight.attempts(MASTER, Bus::Nominal).count() - attempts_before;
    assert!(attempts > 10_000, "{attempts}");
    // 4 heartbeats a second, and a SYNC and a spacecraft time now and then.
    assert!((7..=12).contains(&results), "{results} results");
    assert_eq!((received, errors), (0, 0), "it is error passive all the time: no change, no interrupt");
    flight.assert_nothing_lost();
}

/// Given a cut bus, then the way from error active to isolated causes few interrupts: warning, passive, and then
/// aborted frames.
#[test]
fn a_cut_costs_a_handful_of_error_interrupts() {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flight.fly_to(2013);
    let before = [1, 2, 3, 4].map(|node| flight.diagnostics(node).interrupts);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(4013);
    for (node, before) in (1..).zip(before) {
        let [results, received, errors] = delta(before, flight.diagnostics(node).interrupts);
        assert!(errors <= 4, "node {node}: {errors} error interrupts");
        let since = |seen: &&Seen| seen.end > ms(2013);
        let sent = flight.of(node).filter(since).count();
        let heard = flight.frames.iter().filter(since).filter(|seen| seen.reached.contains(&node)).count();
        // Frames that were sent or given up: some frames of a second expire.
        assert!((results as usize) < sent + 50, "node {node}: {results} results of {sent} frames");
        assert!(received as usize <= heard, "node {node}: {received} receptions of {heard}");
    }
    flight.assert_nothing_lost();
}

/// A guest keeps the bus busy with frames that beat commands but not SYNC. Commands and requests fill the mailboxes
/// that they may have, and the queue; SYNC is still sent in time. Then all frames follow in the order of COB-IDs, and
/// the commands to each slave in the order of their requests.
#[test]
fn sync_overtakes_commands_that_wait() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Nominal);
    flight.fly_to(5100);
    let first = flight.sent(MASTER, Bus::Nominal, 0x080).last().unwrap().end;
    let due = first + ms(5000);
    let frames = 400;
    flood(&mut flight, guest, due.since(ms(40)), 0x0C0, frames);
    flight.fly(due + ms(400));

    let flood: Vec<&Seen> = flight.with_id(0x0C0).collect();
    let (begin, end) = (flood[0].start, flood[frames - 1].end);
    assert!(begin < due && end > due + ms(1));
    let ids_of_master = |from: Time, until: Time| -> Vec<u16> {
        let sent = flight.of(MASTER).filter(|seen| seen.bus == Bus::Nominal);
        sent.filter(|seen| seen.start > from && seen.end < until).filter_map(Seen::id).collect()
    };
    assert_eq!(ids_of_master(begin, end), [0x080], "nothing else of the master gets through");
    let sync = flight.sent(MASTER, Bus::Nominal, 0x080).find(|seen| seen.end > begin).unwrap().end;
    // One frame of the guest may be on the wire, and its crystal has another error.
    assert!(sync < due + LONGEST_FRAME + ms(1), "{} us late", sync.since(due).as_us());

    let waited = ids_of_master(end, end + ms(1));
    // Frames in a mailbox are sent before frames in the queue.
    let of = |function| waited.iter().filter(move |id| **id & 0x780 == function);
    assert!(waited.len() > 2 && waited.iter().min() == waited.first(), "{waited:03X?}");
    assert!(of(0x300).is_sorted() && of(0x400).is_sorted(), "{waited:03X?}");
    for node in [2, 3, 4] {
        let values: Vec<u32> = flight
            .sent(MASTER, Bus::Nominal, 0x300 + node)
            .filter(|seen| seen.data()[..2] == [2, 0])
            .filter_map(|seen| Some(u32::from_le_bytes(seen.data().get(2..6)?.try_into().unwrap())))
            .collect();
        assert!(values.len() > 10 && values.is_sorted_by(|a, b| a < b), "node {node}: {values:?}");
    }
    flight.assert_nothing_lost();
}

/// Given an answer with a lifetime of 100 ms and a bus that is busy for about the same time, varied by microseconds,
/// when the answer is aborted before its start, on the wire, or just too late, then it is reported as sent only if it
/// was sent.
#[test]
fn frame_aborted_as_it_goes_out_is_reported_as_it_really_ended() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..2], Bus::Nominal);
    flight.fly_to(1000);
    flood(&mut flight, guest, ms(1000), 0x010, 11);
    flight.fly_to(1010);
    let ends: Vec<Time> = flight.with_id(0x010).map(|seen| seen.end).collect();
    let in_100_ms = 1_000_000 / ends[10].since(ends[0]).as_us() as usize;

    let (mut in_time, mut too_late) = (0, 0);
    for trial in 0..20 {
        let request = flight.fly_until(|seen| seen.id() == Some(0x402));
        // Pending frames of the master are sent before the answer. The last frame is shorter by whole bytes.
        let last = WireFrame::standard(0x010, &[0x55; 8][..2 * (trial % 4)]);
        flood(&mut flight, guest, request.end, 0x010, in_100_ms - 4 + trial / 4);
        flight.twin.inject(guest, request.end, last);
        let until = request.end + ms(110);
        flight.fly(until);
        // The next request, which was pending too, asks for another code.
        let asked = &request.data()[..2];
        let answered = flight
            .sent(2, Bus::Nominal, 0x382)
            .any(|seen| seen.end > request.end && &seen.data()[..2] == asked);
        *if answered { &mut in_time } else { &mut too_late } += 1;
        flight.fly(until + ms(300));
    }
    assert!(in_time > 0 && too_late > 0, "{in_time} in time, {too_late} too late");

    flight.fly(flight.end + ms(1500));
    let replies = flight.sent(2, Bus::Nominal, 0x382).filter(|seen| seen.data()[..2] == [0x10, 0x01]);
    let reply = replies.last().unwrap();
    let request = flight.sent(MASTER, Bus::Nominal, 0x402).filter(|seen| seen.end < reply.start).last();
    let asked = request.unwrap().end;
    let sent = flight.of(2).filter(|seen| seen.end < asked).count();
    let [a, b, c] = reply.data()[5..8] else { unreachable!() };
    assert_eq!(u32::from_le_bytes([a, b, c, 0]) as usize, sent);
    let data = telemetry(&flight, 2, 0x0120);
    let [lost, malformed, failed] = [0, 2, 4].map(|at| u16::from_le_bytes([data[at], data[at + 1]]));
    assert_eq!((lost, malformed), (0, 0));
    assert!(failed >= too_late, "{failed} failed, {too_late} answers too late");
    flight.assert_nothing_lost();
}
