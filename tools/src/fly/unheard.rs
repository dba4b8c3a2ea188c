//! Errors that a board reported and the master did not hear.

use std::collections::BTreeMap;

use can_twin::wire::time::Time;

use super::flight::Flight;
use super::meaning::Meaning;
use super::record::{FlightEvent, MASTER, Node};

/// Time after its first report by which an error has to be known: a slave that missed the change of the bus searches
/// for the master.
const BOUND: Time = Time::from_ms(3_000);

/// An error that is active at the end of a flight, and that the master does not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unheard {
    /// Board that reported it.
    pub node: Node,
    /// Error code.
    pub code: u16,
    /// First byte of the manufacturer.
    pub source: u8,
    /// First report.
    pub at: Time,
}

/// Errors whose reports the master did not receive, in the order of their nodes. Those of the last seconds are not judged.
pub fn unheard(flight: &Flight) -> Vec<Unheard> {
    let master = flight.observer.active_master().unwrap_or(MASTER);
    let mut active: BTreeMap<(Node, u16, u8), (Time, bool)> = BTreeMap::new();
    for record in &flight.records {
        match &record.what {
            // A board that starts has no errors.
            FlightEvent::PowerOff(node) | FlightEvent::Reset(node) => active.retain(|(of, ..), _| of != node),
            FlightEvent::Frame(seen) => {
                let Some(Meaning::Emergency { node, code, details, .. }) = seen.meaning else { continue };
                let [first, second, third, ..] = details;
                if code == 0 {
                    active.remove(&(node, u16::from_le_bytes([first, second]), third));
                } else {
                    let (_, is_heard) = active.entry((node, code, first)).or_insert((record.at, false));
                    *is_heard |= seen.reached.contains(master) || seen.from == master;
                }
            }
            _ => {}
        }
    }
    let unheard = active.into_iter().filter(|(_, (at, is_heard))| !is_heard && *at + BOUND < flight.end);
    unheard.map(|((node, code, source), (at, _))| Unheard { node, code, source, at }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::record::Bus;
    use crate::fly::sample;

    fn report(flight: &mut Flight, ms: u64, data: &[u8], reached: &[Node]) {
        flight.records.push(sample::frame(ms, Bus::Nominal, 2, 0x082, data, reached));
    }

    const BEGIN: [u8; 8] = [0x00, 0x42, 0x09, 1, 0, 0, 0, 0];
    const END: [u8; 8] = [0, 0, 0, 0x00, 0x42, 1, 0, 0];

    /// Given an error that only another slave acknowledged, then it is unheard, until the master receives it or it has
    /// ended.
    #[test]
    fn error_is_unheard_until_the_master_receives_it() {
        let mut flight = sample::flight();
        report(&mut flight, 20_100, &BEGIN, &[4]);
        let error = Unheard { node: 2, code: 0x4200, source: 1, at: Time::from_ms(20_100) };
        assert_eq!(unheard(&flight), [error]);
        let mut known = flight.clone();
        report(&mut known, 20_700, &BEGIN, &[1, 4]);
        assert_eq!(unheard(&known), []);
        let mut over = flight.clone();
        report(&mut over, 20_700, &END, &[4]);
        assert_eq!(unheard(&over), []);
        flight.records.push(sample::at(21_000, FlightEvent::Reset(2)));
        assert_eq!(unheard(&flight), []);
    }

    #[test]
    fn error_of_the_last_seconds_is_not_judged() {
        let mut flight = sample::flight();
        report(&mut flight, 37_500, &BEGIN, &[4]);
        assert_eq!((flight.end, unheard(&flight)), (Time::from_ms(40_000), vec![]));
    }
}
