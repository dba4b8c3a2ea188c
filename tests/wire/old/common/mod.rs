//! A scripted controller, and a runner that flies several on one wire.

// Each test binary uses its share of this module.
#![allow(dead_code)]

use std::sync::Arc;

use can_wire::controller::{Controller, ErrorKind, NodeIndex, Trace, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use can_wire::wire::{Controllers, Wire, WireConfig};

/// 1 Mbit/s.
pub const BIT: Time = Time(336);

pub fn bits(count: u64) -> Time {
    Time(BIT.0 * count)
}

pub fn us(us: u64) -> Time {
    Time::from_us(us)
}

/// What a script was told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Told {
    Started,
    Lost,
    Sent(Arc<Trace>),
    Got(Arc<Trace>),
    TxError(ErrorKind),
    RxError(ErrorKind),
}

/// Sends its queue in order, each frame not before its time, and repeats what failed.
#[derive(Debug)]
pub struct Script {
    pub bit: Option<Time>,
    pub acknowledges: bool,
    pub passive: bool,
    pub queue: Vec<(Time, WireFrame)>,
    /// Leaves the bus at this instant.
    pub leaves_at: Time,
    /// Joins the bus at this instant.
    pub joins_at: Time,
    pub log: Vec<(Time, Told)>,
    now: Time,
}

impl Script {
    pub fn new() -> Self {
        Script {
            bit: Some(BIT),
            acknowledges: true,
            passive: false,
            queue: Vec::new(),
            leaves_at: Time::NEVER,
            joins_at: Time::ZERO,
            log: Vec::new(),
            now: Time::ZERO,
        }
    }

    pub fn sending(at: Time, frame: WireFrame) -> Self {
        Script { queue: vec![(at, frame)], ..Script::new() }
    }

    pub fn got(&self) -> Vec<(Time, WireFrame)> {
        self.log
            .iter()
            .filter_map(|(at, told)| if let Told::Got(t) = told { Some((*at, t.frame)) } else { None })
            .collect()
    }

    pub fn sent(&self) -> Vec<(Time, WireFrame)> {
        self.log
            .iter()
            .filter_map(|(at, told)| if let Told::Sent(t) = told { Some((*at, t.frame)) } else { None })
            .collect()
    }

    /// Errors it was told of.
    pub fn errors(&self) -> Vec<(Time, Told)> {
        let is_error = |told: &Told| matches!(told, Told::TxError(_) | Told::RxError(_));
        self.log.iter().filter(|(_, told)| is_error(told)).cloned().collect()
    }
}

impl Controller for Script {
    fn bit_time(&self) -> Option<Time> {
        self.bit.filter(|_| self.now < self.leaves_at && self.now >= self.joins_at)
    }

    fn acknowledges(&self) -> bool {
        self.acknowledges
    }

    fn error_passive(&self) -> bool {
        self.passive
    }

    fn request_at(&self) -> Option<Time> {
        // What lies ahead has not been asked for yet.
        self.queue.first().map(|&(at, _)| at).filter(|&at| at <= self.now)
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.queue.first().filter(|&&(requested, _)| requested <= at).map(|&(_, frame)| frame)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        let told = match event {
            WireEvent::Started => Told::Started,
            WireEvent::ArbitrationLost => Told::Lost,
            WireEvent::Transmitted(trace) => {
                self.queue.remove(0);
                Told::Sent(Arc::clone(trace))
            }
            WireEvent::Received(trace) => Told::Got(Arc::clone(trace)),
            WireEvent::TransmitError(kind) => Told::TxError(*kind),
            WireEvent::ReceiveError(kind) => Told::RxError(*kind),
        };
        self.log.push((at, told));
    }
}

/// Scripts in the order of their attachment.
pub struct Scripts(pub Vec<Script>);

impl Controllers for Scripts {
    fn controller(&mut self, node: NodeIndex) -> &mut dyn Controller {
        &mut self.0[node]
    }
}

/// One wire with its scripts.
pub struct World {
    pub wire: Wire,
    pub scripts: Scripts,
}

impl World {
    /// Scripts at the given positions.
    pub fn new(nodes: Vec<(f64, Script)>) -> Self {
        let mut wire = Wire::new(WireConfig::default());
        let mut scripts = Vec::new();
        for (position_m, script) in nodes {
            assert_eq!(wire.attach(position_m), scripts.len());
            scripts.push(script);
        }
        World { wire, scripts: Scripts(scripts) }
    }

    /// All at the left end: no propagation delay.
    pub fn together(scripts: Vec<Script>) -> Self {
        World::new(scripts.into_iter().map(|script| (0.0, script)).collect())
    }

    /// Runs to `until` in quanta, as boards do: never beyond the next event of the wire.
    pub fn run(&mut self, until: Time, quantum: Time) {
        while self.wire.now() < until {
            let mut now = (self.wire.now() + quantum).min(until);
            if let Some(event) = self.wire.next_event() {
                now = now.min(event);
            }
            for script in &mut self.scripts.0 {
                script.now = now;
            }
            self.wire.advance(now, &mut self.scripts);
        }
    }

    pub fn node(&self, node: NodeIndex) -> &Script {
        &self.scripts.0[node]
    }
}
