//! Events of a node as texts with positions.

use can_twin::wire::controller::{ErrorCounters, ErrorKind, WireEvent};
use can_twin::wire::time::{TICKS_PER_US, Time};
use can_twin::wire::waveform::Lane;

/// A remark about an instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Note {
    pub(super) at: Time,
    pub(super) text: String,
    /// [`PLAIN`], [`ERROR`] or [`SHIFT`].
    pub(super) class: &'static str,
}

/// Ends of the names of the classes of a note: of `leader`, its line, and of `note`, its words. Of two events at an
/// instant the greater class is used.
const PLAIN: &str = "";
const ERROR: &str = "-error";
const SHIFT: &str = "-shift";

/// Returns one note for all events of a node at one instant, in chronological order.
pub(super) fn notes(lane: &Lane) -> Vec<Note> {
    let mut notes: Vec<Note> = Vec::new();
    let mut counters = lane.counters;
    let flips = lane.bits.iter().filter(|bit| bit.flipped).map(|bit| Note {
        at: bit.sample,
        text: format!("flipped: reads {}", u8::from(bit.sampled)),
        class: ERROR,
    });
    let shifts = lane.bits.iter().filter(|bit| bit.resynchronised != 0).map(|bit| {
        let ns = bit.resynchronised as f64 * 1000.0 / TICKS_PER_US as f64;
        Note { at: bit.end, text: format!("resync {ns:+.0} ns"), class: SHIFT }
    });
    for &(at, event) in &lane.events {
        let (text, class) = words(&event, &mut counters);
        match notes.last_mut().filter(|last| last.at == at) {
            Some(note) => {
                note.text = format!("{}, {text}", note.text);
                note.class = note.class.max(class);
            }
            None => notes.push(Note { at, text, class }),
        }
    }
    notes.extend(flips);
    notes.extend(shifts);
    notes.sort_by_key(|note| note.at);
    notes
}

fn words(event: &WireEvent, counters: &mut ErrorCounters) -> (String, &'static str) {
    let (text, class) = match *event {
        WireEvent::Joined => ("joins the bus", PLAIN),
        WireEvent::Started => ("starts", PLAIN),
        WireEvent::ArbitrationLost => ("arbitration lost", ERROR),
        WireEvent::Transmitted => ("sent", PLAIN),
        WireEvent::Received(_) => ("received", PLAIN),
        WireEvent::TransmitError(kind) | WireEvent::ReceiveError(kind) => (name(kind), ERROR),
        WireEvent::Counters(now) => {
            let before = std::mem::replace(counters, now);
            let changes = [("TEC", before.transmit, now.transmit), ("REC", before.receive, now.receive)];
            let changed = changes.iter().filter(|(_, before, now)| before != now);
            let words: Vec<String> = changed.map(|(name, _, now)| format!("{name} {now}")).collect();
            return (words.join(" "), PLAIN);
        }
    };
    (text.to_owned(), class)
}

fn name(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::Stuff => "stuff error",
        ErrorKind::Form => "form error",
        ErrorKind::Ack => "no acknowledgement",
        ErrorKind::BitRecessive => "bit error: sent 1, saw 0",
        ErrorKind::BitDominant => "bit error: sent 0, saw 1",
        ErrorKind::Crc => "CRC error",
    }
}
