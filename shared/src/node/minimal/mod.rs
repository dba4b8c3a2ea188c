//! Minimal slave: hard-coded PDOs for commands and telemetry, and a choice of the bus (ECSS 9).
//!
//! The *minimal set* is a reduced protocol for very simple nodes. The master begins every exchange: a receive PDO
//! is a command, a request for telemetry, or both. The slave handles it in the call that receives it.
//!
//! ```
//! use ecss_can::node::minimal::{MinimalDevice, MinimalPdos, MinimalSlave, Payload};
//! use ecss_can::profile::Profile;
//! use ecss_can::types::{Instant, NodeId};
//!
//! /// Answers each request with its first byte.
//! struct Echo;
//!
//! impl MinimalDevice for Echo {
//!     const PDOS: MinimalPdos = MinimalPdos::DEFAULT;
//!
//!     fn on_pdo(&mut self, number: usize, data: &[u8], _: Instant) -> Option<(usize, Payload)> {
//!         Some((number, Payload::from_slice(data.get(..1)?).ok()?))
//!     }
//!
//!     fn on_sync(&mut self, _: usize, _: Instant) -> Option<Payload> {
//!         None // no PDO depends on SYNC
//!     }
//! }
//!
//! let slave = MinimalSlave::builder(NodeId::of::<5>(), &Profile::DEFAULT, Echo).build();
//! assert_eq!(slave.active(), Profile::DEFAULT.bdefault);
//! ```
//!
//! # Limits
//!
//! - There is no module control, boot-up message, emergency, SDO or time stamp.
//! - A device has at most four PDOs in each direction.

mod api;
mod builder;
#[cfg(test)]
mod flipped;
mod objects;
mod pdos;

pub use api::{MinimalDevice, MinimalEvent};
pub use builder::MinimalSlaveBuilder;
pub use objects::{Permission, assert_minimal, permission};
pub use pdos::{MinimalPdos, MinimalRpdo, MinimalTpdo, PDOS, Payload, Trigger};

use async_canopen::node::extend::{BusNews, Buses};

use super::{Counters, Filters, LinkEvent, Node};
use crate::heartbeat;
use crate::link::Stamp;
use crate::link::machine::Places;
use crate::link::port::{Filter, Health};
use crate::node;
use crate::redundancy::{BusCause, MasterMessage, Parameters, Selection, Selector};
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, PerBus, earliest};

/// Each step of it sends four PDOs and a heartbeat at most.
const DEPTH: usize = 8;
type Turn<'a> = node::Turn<'a, MinimalEvent, Places<DEPTH>>;

/// Slave of the minimal set, on both buses or on one at a time.
#[doc(alias("minimal slave", "reduced protocol"))]
#[derive(Debug)]
pub struct MinimalSlave<D: MinimalDevice> {
    id: NodeId,
    device: D,
    redundancy: Parameters,
    /// Time after which telemetry that waits for its bus expires.
    lifetime: Duration,
    /// A copy of the lifetime.
    same_lifetime: Duration,
    buses: Buses,
    selector: Selector,
    heartbeat: heartbeat::machine::Producer,
    /// SYNCs until each transmit PDO goes out again.
    syncs: [u8; PDOS],
}

impl<D: MinimalDevice> MinimalSlave<D> {
    /// Returns the device.
    pub const fn device(&self) -> &D {
        &self.device
    }

    /// Returns the bus that the node considers active, or on which it searches.
    pub const fn active(&self) -> Bus {
        self.selector.selected()
    }

    /// Returns the counters of the frames of each bus.
    pub const fn counters(&self) -> &PerBus<Counters> {
        self.buses.counters()
    }

    /// Returns error state and counters of each controller (ECSS 5.6.2b, c).
    pub const fn health(&self) -> &PerBus<Health> {
        self.buses.health()
    }

    /// Returns whether it follows the master's heartbeat (ECSS 9.4.9.1.1a).
    const fn follows_master(&self) -> bool {
        self.redundancy.consumer.as_micros() > 0
    }

    fn on_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        let id = frame.id();
        if !self.buses.is_joined(bus, self.active()) {
            self.buses.count_ignored(bus);
        } else if id == CobId::heartbeat(NodeId::MASTER) {
            self.on_master(bus, frame, stamp, turn);
        } else if bus != self.active() {
            self.buses.count_ignored(bus);
        } else if id == CobId::SYNC {
            self.on_sync(bus, frame, stamp, turn);
        } else if let Some((nth, pdo)) = D::PDOS.received(id, self.id) {
            if frame.data().len() < usize::from(pdo.least) {
                return self.buses.count_malformed(bus);
            }
            let answer = self.device.on_pdo(nth, frame.data(), stamp.at);
            turn.out.event(MinimalEvent::Pdo { bus, number: nth as u8 });
            if let Some((number, payload)) = answer {
                self.answer(number, &payload, turn);
            }
        } else {
            self.buses.count_ignored(bus);
        }
    }

    /// Telemetry that was asked for: at once, so that its delay is that of this board's processor and of the bus.
    fn answer(&mut self, number: usize, payload: &Payload, turn: &mut Turn) {
        match D::PDOS.transmit.get(number) {
            Some(Some(MinimalTpdo { cob_id, trigger: Trigger::Request })) => {
                self.send(cob_id.of(self.id), payload, turn);
            }
            _ => self.buses.count_refused(self.active()),
        }
    }

    fn send(&mut self, id: CobId, payload: &Payload, turn: &mut Turn) {
        match Frame::new(id, payload) {
            Ok(frame) => turn.out.send_for(self.active(), frame, turn.now, self.lifetime),
            Err(_) => self.buses.count_refused(self.active()),
        }
    }

    /// 1019h is not among the objects of a minimal slave: SYNC has no counter.
    fn on_sync(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        if !frame.data().is_empty() {
            return self.buses.count_malformed(bus);
        }
        turn.out.event(MinimalEvent::Sync { bus });
        for (number, pdo) in D::PDOS.transmit.iter().enumerate() {
            let Some(MinimalTpdo { cob_id, trigger: Trigger::Sync(every) }) = pdo else { continue };
            let Some(count) = self.syncs.get_mut(number) else { continue };
            *count = count.saturating_add(1);
            if *count < *every {
                continue;
            }
            *count = 0;
            if let Some(payload) = self.device.on_sync(number, stamp.at) {
                self.send(cob_id.of(self.id), &payload, turn);
            }
        }
    }

    fn on_master(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        if heartbeat::decode(frame).is_none() {
            return self.buses.count_malformed(bus);
        }
        if !self.follows_master() {
            return self.buses.count_ignored(bus);
        }
        self.buses.count_heartbeat(bus, frame);
        if let Some(selection) = self.selector.on_master(bus, MasterMessage::Heartbeat, stamp.at) {
            self.apply(selection, turn);
        }
        if bus == self.active() {
            turn.out.event(MinimalEvent::Heartbeat { bus });
        }
    }

    fn apply(&mut self, selection: Selection, turn: &mut Turn) {
        match selection {
            Selection::Missed { bus } => turn.out.event(MinimalEvent::MasterMissed { bus }),
            Selection::GaveUp { bus } => turn.out.event(MinimalEvent::GaveUp { bus }),
            Selection::Toggled { to } => self.move_to(to, BusCause::Toggled, turn),
            Selection::Followed { to } => self.move_to(to, BusCause::Followed, turn),
            Selection::Found { bus, moved: true } => self.move_to(bus, BusCause::Found, turn),
            Selection::Contradicted { bus, moved: true } => {
                self.move_to(bus, BusCause::TakenBack, turn);
            }
            Selection::Found { bus, moved: false } => {
                turn.out.event(MinimalEvent::ActiveBus { bus, cause: BusCause::Found });
            }
            // Without module control no command alone finds a bus; nothing is kept beyond power-off.
            Selection::Contradicted { moved: false, .. }
            | Selection::Confirmed
            | Selection::Unconfirmed { .. }
            | Selection::Undisputed
            | Selection::KeepBdefault { .. } => {}
        }
    }

    fn move_to(&mut self, bus: Bus, cause: BusCause, turn: &mut Turn) {
        self.buses.change(bus.other(), bus, turn.out);
        if self.redundancy.producer > Duration::ZERO {
            self.heartbeat.announce(turn.now);
        }
        turn.out.event(MinimalEvent::ActiveBus { bus, cause });
    }

    /// Returns whether both copies of each parameter are equal, and heartbeats go on. A board whose node is not intact is reset.
    fn is_intact(&self) -> bool {
        let has_heartbeats = self.redundancy.producer > Duration::ZERO;
        self.redundancy.agrees(self.selector.parameters())
            && self.heartbeat.period() == self.redundancy.producer
            && self.heartbeat.deadline().is_some() == has_heartbeats
            && self.heartbeat.node() == self.id
            && self.lifetime == self.same_lifetime
    }

    /// Does what is due.
    fn run(&mut self, turn: &mut Turn) {
        while let Some(bus) = self.buses.poll(turn) {
            turn.out.event(MinimalEvent::BusFailed { bus });
        }
        if self.follows_master() {
            while let Some(selection) = self.selector.poll(turn.until) {
                self.apply(selection, turn);
            }
        }
        if let Some(frame) = self.heartbeat.poll(turn.until, NmtState::Operational) {
            turn.out.send_for(self.active(), frame, turn.now, self.redundancy.producer);
        }
    }
}

impl<D: MinimalDevice> Node for MinimalSlave<D> {
    type Event = MinimalEvent;
    type Request = core::convert::Infallible;
    type Depth = Places<DEPTH>;

    fn filters(&self) -> Filters {
        let mut filters = Filters::new();
        let pdos = D::PDOS.receive.iter().flatten().map(|pdo| pdo.cob_id.of(self.id));
        let sync = (D::LISTENS_TO_SYNC || D::PDOS.follows_sync()).then_some(CobId::SYNC);
        let master = self.follows_master().then(|| CobId::heartbeat(NodeId::MASTER));
        // There is room for these six.
        filters.extend(pdos.chain(sync).chain(master).map(Filter::exact));
        filters
    }

    fn start(&mut self, turn: &mut Turn) {
        let bus = self.active();
        self.buses.join(bus, turn.out);
        if self.follows_master() {
            self.selector.start(turn.now);
        }
        if self.redundancy.producer > Duration::ZERO {
            self.heartbeat.announce(turn.now);
        }
        turn.out.event(MinimalEvent::ActiveBus { bus, cause: BusCause::PowerOn });
        self.run(turn);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, turn: &mut Turn) {
        if let LinkEvent::Received { frame, stamp } = event {
            return self.on_received(bus, frame, stamp, turn);
        }
        match self.buses.on_link(bus, event, turn.now) {
            Some(BusNews::Health(health)) => turn.out.event(MinimalEvent::Health { bus, health }),
            Some(BusNews::Failed(health)) => {
                turn.out.event(MinimalEvent::Health { bus, health });
                turn.out.event(MinimalEvent::BusFailed { bus });
            }
            Some(BusNews::Stalled) => turn.out.event(MinimalEvent::BusStalled { bus }),
            None => {}
        }
        self.run(turn);
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        self.buses.count_received(bus);
        turn.until = stamp.at.min(turn.now);
        self.run(turn);
        turn.until = turn.now;
        self.on_frame(bus, frame, stamp, turn);
        self.run(turn);
    }

    fn on_request(&mut self, request: Self::Request, _turn: &mut Turn) {
        match request {}
    }

    fn poll(&mut self, turn: &mut Turn) {
        self.run(turn);
    }

    fn deadline(&self) -> Option<Instant> {
        let search = if self.follows_master() { self.selector.deadline() } else { None };
        earliest(&[search, self.heartbeat.deadline(), self.buses.deadline()])
    }

    fn is_on_schedule(&self, now: Instant) -> bool {
        self.is_intact() && self.heartbeat.is_on_schedule(now)
    }

    /// It has no clock that a stamp would serve.
    fn is_stamped(&self, _bus: Bus, _frame: &Frame) -> bool {
        false
    }
}
