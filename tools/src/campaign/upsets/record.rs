//! What a flight with an upset shows: frames on the buses, commands executed, resets.

use std::collections::BTreeMap;

use can_twin::spacecraft::{Bus, Spacecraft};
use can_twin::wire::frame::WireId;
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use ecss_can::types::Scet;

use super::grid;
use crate::images::support::counters::Counters;

/// NMT state Operational in a heartbeat.
const OPERATIONAL: u8 = 5;
/// Greatest number of commands that a slave executes between two stops. More means that the counter itself was changed.
const MOST_COMMANDS: u32 = 1_000;
/// COB-IDs by which the prime and the second master claim to be active.
const CLAIMS: [u16; 2] = [0x680, 0x681];
/// Units of spacecraft time in a second.
const SCET_UNITS: u128 = 1 << 24;

/// A service that a node provides, which a flight counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Service {
    /// Frames with this COB-ID; heartbeats only in state Operational.
    Frames(u16),
    /// Commands executed.
    Commands,
    /// Heartbeats with another state: 0 is a boot-up message.
    Heartbeats(u8),
}

impl Service {
    /// Returns whether the service is sent regularly by a healthy node: no emergency, SDO, NMT command or boot-up message.
    pub fn is_regular(self) -> bool {
        match self {
            Service::Frames(id) => !matches!(id, 0x000..=0x07F | 0x081..=0x0FF | 0x580..=0x67F),
            Service::Commands => true,
            Service::Heartbeats(state) => state != 0,
        }
    }

    fn is_emergency(self) -> bool {
        matches!(self, Service::Frames(0x081..=0x0FF))
    }
}

/// Record of a flight.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Instants of each service by Node-ID, microseconds, ascending. Both master boards are node 1.
    pub services: BTreeMap<(u8, Service), Vec<u64>>,
    /// Resets by program or watchdog: index of the board, instant in microseconds.
    pub resets: Vec<(usize, u64)>,
    /// Differences between the spacecraft time of a slave and the instant of the last SYNC, microseconds: Node-ID, instant.
    pub clocks: Vec<(u8, u64, i64)>,
    /// Bus and board of the last heartbeat of a master.
    pub active: Option<(Bus, usize)>,
    sync: u64,
    counted: Vec<(u64, u32)>,
}

impl Record {
    /// Reads everything up to the present. `nodes`: Node-ID of each board.
    pub fn read(&mut self, craft: &mut Spacecraft, nodes: &[u8]) {
        craft.take_logs();
        for wire in craft.take_frames() {
            let Observation::Completed { trace, .. } = &wire.record else { continue };
            let WireId::Standard(id) = trace.frame.id else { continue };
            if let Some(&node) = nodes.get(trace.transmitter) {
                let (start, end) = (trace.start.as_us(), trace.end.as_us());
                self.on_frame(node, id, trace.frame.payload(), start, end);
                if id == 0x701 {
                    self.active = Some((wire.bus, trace.transmitter));
                }
            }
        }
        self.counted.resize(nodes.len(), (0, 0));
        let now = craft.now().as_us();
        for (index, (_, board)) in craft.boards().enumerate() {
            let counters = board.counters();
            let resets = counters.system_resets + counters.watchdog_resets;
            let (known, executed) = &mut self.counted[index];
            if resets > *known {
                self.resets.push((index, now));
            }
            *known = resets;
            if nodes[index] == 1 || !grid::is_sample(now) {
                continue;
            }
            let total = Counters::read(board).ok().flatten().map_or(0, |counters| counters.commands);
            let new = total.checked_sub(*executed).unwrap_or(total);
            *executed = total;
            let new = if new > MOST_COMMANDS { 0 } else { new };
            let entry = self.services.entry((nodes[index], Service::Commands)).or_default();
            entry.extend(std::iter::repeat_n(now, new as usize));
        }
    }

    fn on_frame(&mut self, node: u8, id: u16, payload: &[u8], start: u64, end: u64) {
        let service = match payload {
            &[state] if id == 0x700 + u16::from(node) && state & 0x7F != OPERATIONAL => {
                Service::Heartbeats(state & 0x7F)
            }
            _ if CLAIMS.contains(&id) => Service::Frames(CLAIMS[0]),
            _ => Service::Frames(id),
        };
        self.services.entry((node, service)).or_default().push(end);
        if id == 0x080 {
            self.sync = start;
        }
        if id == 0x180 + u16::from(node)
            && node != 1
            && let Some(scet) = Scet::decode(payload)
        {
            let us = (u128::from(scet.units()) * 1_000_000 / SCET_UNITS) as i64;
            self.clocks.push((node, end, us - self.sync as i64));
        }
    }

    /// Forgets the services so far, and keeps the state that later ones need.
    pub fn fresh(&self) -> Record {
        Record { services: BTreeMap::new(), resets: Vec::new(), clocks: Vec::new(), ..self.clone() }
    }

    /// Returns whether equal flights from here on add the same to both records.
    pub fn continues_as(&self, other: &Record) -> bool {
        let executed =
            |record: &Record| record.counted.iter().map(|(_, executed)| *executed).collect::<Vec<_>>();
        (self.active, self.sync) == (other.active, other.sync) && executed(self) == executed(other)
    }

    /// Adds what another flight recorded after `from`, when both continue alike from there.
    pub fn continue_as(&mut self, other: &Record, from: Time) {
        let from = from.as_us();
        for (key, instants) in &other.services {
            let later = instants.iter().copied().filter(|at| *at > from);
            self.services.entry(*key).or_default().extend(later);
        }
        self.resets.extend(other.resets.iter().filter(|(_, at)| *at > from));
        self.clocks.extend(other.clocks.iter().filter(|(_, at, _)| *at > from));
        self.active = other.active;
    }

    /// Returns how often a node provided a service in a span, microseconds.
    pub fn count(&self, key: (u8, Service), span: &std::ops::Range<u64>) -> usize {
        let instants = self.services.get(&key).map_or(&[][..], Vec::as_slice);
        let before = |us: u64| instants.partition_point(|at| *at < us);
        before(span.end) - before(span.start)
    }

    /// Returns the number of emergencies in a span.
    pub fn emergencies(&self, span: &std::ops::Range<u64>) -> usize {
        let keys = self.services.keys().filter(|(_, service)| service.is_emergency());
        keys.map(|key| self.count(*key, span)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heartbeats_of_other_states_are_other_services() {
        let mut record = Record::default();
        for (state, at) in [(0, 1), (5, 2), (4, 3), (0x85, 4)] {
            record.on_frame(3, 0x703, &[state], at, at);
        }
        assert_eq!(record.count((3, Service::Frames(0x703)), &(0..10)), 2);
        assert_eq!(record.count((3, Service::Heartbeats(4)), &(0..10)), 1);
        assert_eq!(record.count((3, Service::Heartbeats(0)), &(0..1)), 0);
    }

    #[test]
    fn claims_of_either_master_are_one_service() {
        let mut record = Record::default();
        CLAIMS.into_iter().for_each(|id| record.on_frame(1, id, &[0], 3, 3));
        assert_eq!(record.count((1, Service::Frames(0x680)), &(0..10)), 2);
    }

    #[test]
    fn emergencies_sdo_and_boot_up_are_not_regular() {
        let irregular =
            [Service::Frames(0), Service::Frames(0x083), Service::Frames(0x583), Service::Heartbeats(0)];
        assert!(irregular.iter().all(|service| !service.is_regular()));
        let regular =
            [Service::Frames(0x080), Service::Frames(0x303), Service::Commands, Service::Heartbeats(4)];
        assert!(regular.iter().all(|service| service.is_regular()));
    }
}
