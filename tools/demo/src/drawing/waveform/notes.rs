//! What happened to a node, in words at their places.

use can_wire::controller::{ErrorCounters, ErrorKind, WireEvent};
use can_wire::time::{TICKS_PER_US, Time};
use can_wire::waveform::Lane;

/// A remark about an instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Note {
    pub(super) at: Time,
    pub(super) text: String,
    pub(super) class: Class,
}

/// How it looks; the worst of what happened at an instant comes last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Class {
    Plain,
    Resynchronised,
    Error,
}

impl Class {
    /// End of the names of its classes in the picture: of `leader`, its line, and of `note`, its words.
    pub(super) fn name(self) -> &'static str {
        match self {
            Class::Plain => "",
            Class::Resynchronised => "-shift",
            Class::Error => "-error",
        }
    }
}

/// One note for everything that happened to a node at one instant, in the order of time.
pub(super) fn notes(lane: &Lane) -> Vec<Note> {
    let mut notes: Vec<Note> = Vec::new();
    let mut counters = lane.counters;
    let flips = lane.bits.iter().filter(|bit| bit.flipped).map(|bit| Note {
        at: bit.sample,
        text: format!("flipped: reads {}", u8::from(bit.sampled)),
        class: Class::Error,
    });
    let shifts = lane.bits.iter().filter(|bit| bit.resynchronised != 0).map(|bit| {
        let ns = bit.resynchronised as f64 * 1000.0 / TICKS_PER_US as f64;
        Note { at: bit.end, text: format!("resync {ns:+.0} ns"), class: Class::Resynchronised }
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

fn words(event: &WireEvent, counters: &mut ErrorCounters) -> (String, Class) {
    let error = |kind| (name(kind).to_owned(), Class::Error);
    match *event {
        WireEvent::Joined => ("joins the bus".to_owned(), Class::Plain),
        WireEvent::Started => ("starts".to_owned(), Class::Plain),
        WireEvent::ArbitrationLost => ("arbitration lost".to_owned(), Class::Error),
        WireEvent::Transmitted => ("sent".to_owned(), Class::Plain),
        WireEvent::Received(_) => ("received".to_owned(), Class::Plain),
        WireEvent::TransmitError(kind) | WireEvent::ReceiveError(kind) => error(kind),
        WireEvent::Counters(now) => {
            let before = std::mem::replace(counters, now);
            let changes = [("TEC", before.transmit, now.transmit), ("REC", before.receive, now.receive)];
            let changed = changes.iter().filter(|(_, before, now)| before != now);
            let words: Vec<String> = changed.map(|(name, _, now)| format!("{name} {now}")).collect();
            (words.join(" "), Class::Plain)
        }
    }
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
