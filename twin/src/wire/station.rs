//! A plain controller that sends queued frames, and a bench of several on one wire.

use std::collections::VecDeque;

use crate::wire::bus::{Wire, WireConfig};
use crate::wire::controller::Controllers;
use crate::wire::controller::{Attachment, Controller, NodeIndex, WireEvent};
use crate::wire::frame::WireFrame;
use crate::wire::time::Time;
use crate::wire::timing::BitTiming;
use crate::wire::transceiver::Transceiver;

/// Sends its queue in order, each frame not before its time, and repeats failed frames.
#[derive(Clone, Debug)]
pub struct Station {
    /// How it takes part; `None` while it does not.
    pub attachment: Option<Attachment>,
    /// Queued frames and the instants from which on they may be sent.
    pub queue: VecDeque<(Time, WireFrame)>,
    /// Drops a frame after its first attempt, also if it lost arbitration or had an error.
    pub single_shot: bool,
    /// Events reported by the wire.
    pub log: Vec<(Time, WireEvent)>,
    /// Level changes at its RX pin.
    pub line: Vec<(Time, bool)>,
    /// Whether it records [`Station::line`].
    pub watches_line: bool,
}

impl Default for Station {
    /// 1 Mbit/s, leaves bus-off by itself.
    fn default() -> Self {
        Station {
            attachment: Some(Attachment::new(BitTiming::MEGABIT)),
            queue: VecDeque::new(),
            single_shot: false,
            log: Vec::new(),
            line: Vec::new(),
            watches_line: false,
        }
    }
}

impl Station {
    /// Makes a station with another bit timing.
    pub fn with_timing(timing: BitTiming) -> Self {
        Station { attachment: Some(Attachment::new(timing)), ..Station::default() }
    }

    /// Queues `frame` for `at`, or as soon as the bus is free and all earlier frames are sent.
    #[must_use]
    pub fn sending(mut self, at: Time, frame: WireFrame) -> Self {
        self.queue.push_back((at, frame));
        self
    }

    /// Frames it received.
    pub fn received(&self) -> impl Iterator<Item = (Time, WireFrame)> + '_ {
        self.log.iter().filter_map(|&(at, event)| match event {
            WireEvent::Received(frame) => Some((at, frame)),
            _ => None,
        })
    }

    /// Returns the instants at which `event` was reported.
    pub fn told(&self, event: WireEvent) -> Vec<Time> {
        self.log.iter().filter(|&&(_, told)| told == event).map(|&(at, _)| at).collect()
    }
}

impl Controller for Station {
    fn attachment(&self) -> Option<Attachment> {
        self.attachment
    }

    fn request_at(&self) -> Option<Time> {
        self.queue.front().map(|&(at, _)| at)
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.queue.front().filter(|(from, _)| *from <= at).map(|&(_, frame)| frame)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        let over = match event {
            WireEvent::Transmitted => true,
            WireEvent::ArbitrationLost | WireEvent::TransmitError(_) => self.single_shot,
            _ => false,
        };
        if over {
            self.queue.pop_front();
        }
        self.log.push((at, *event));
    }

    fn watches_line(&self) -> bool {
        self.watches_line
    }

    fn on_line(&mut self, changes: &[(Time, bool)]) {
        self.line.extend(changes);
    }
}

/// Stations on one wire.
#[derive(Debug)]
pub struct Bench {
    /// The wire.
    pub wire: Wire,
    /// Stations in the order of their indices.
    pub stations: Vec<Station>,
}

impl Controllers for Vec<Station> {
    fn visit(&mut self, node: NodeIndex, visit: &mut dyn FnMut(&mut dyn Controller)) {
        visit(&mut self[node]);
    }
}

impl Bench {
    /// Stations at positions in metres.
    pub fn new(config: WireConfig, stations: Vec<(f64, Station)>) -> Self {
        let transceiver = Transceiver::with_loop(config.transceiver_ns);
        let stations = stations.into_iter().map(|(position_m, station)| (position_m, transceiver, station));
        Bench::with_transceivers(config, stations.collect())
    }

    /// Stations at positions in metres, each behind its own transceiver.
    pub fn with_transceivers(config: WireConfig, stations: Vec<(f64, Transceiver, Station)>) -> Self {
        let mut wire = Wire::new(config);
        let stations = stations.into_iter().map(|(position_m, transceiver, station)| {
            wire.attach_through(position_m, transceiver);
            station
        });
        let stations = stations.collect();
        Bench { wire, stations }
    }

    /// Makes stations that are all at the same position.
    pub fn together(stations: Vec<Station>) -> Self {
        Bench::new(WireConfig::default(), stations.into_iter().map(|station| (0.0, station)).collect())
    }

    /// Runs to `until` in quanta, as boards do: never beyond the next event of the wire.
    pub fn run(&mut self, until: Time, quantum: Time) {
        while self.wire.now() < until {
            let next = self.wire.next_event().unwrap_or(Time::NEVER);
            let stop = (self.wire.now() + quantum).min(next).min(until);
            self.wire.advance(stop, &mut self.stations);
        }
    }

    /// Runs to `until` at once.
    pub fn leap(&mut self, until: Time) {
        self.wire.advance(until, &mut self.stations);
    }
}
