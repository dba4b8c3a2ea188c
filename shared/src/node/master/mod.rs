//! The master node.

mod assignment;
mod builder;
mod declared;
mod due;
#[cfg(test)]
mod flipped;
mod initial;
mod objects;
mod ranging;
mod reception;
mod requests;
mod sending;
mod states;
mod transfers;

pub use builder::MasterBuilder;
pub use declared::MasterObjects;
use declared::MasterServices;

use async_canopen::node::extend::{BusNews, ChangedFilters, Part, Timed};
use async_canopen::store::machine::Storage;

use self::initial::Initial;
use self::objects::FUNCTIONS;
use self::ranging::RangingServices;
use self::requests::Identification;
use self::sending::Budgets;
use self::transfers::Transfers;
use super::services::{Services, State, TimeServices};
use super::settings;
use super::stored::Stored;
use super::{MasterEvent, MasterRequest, SpacecraftDevice, Status};
use crate::boot::machine::Boot;
use crate::emcy::ErrorReader;
use crate::link::Stamp;
use crate::link::port::Filter;
use crate::nmt::machine::StateClashes;
use crate::node::{Filters, FullDepth, Hardware, LinkEvent, Node, TimeKeeper};
use crate::profile::{MinimalNode, Profile};
use crate::redundancy::{MasterBoards, MasterRedundancy, OneBoard, Rescue};
use crate::store::Group;
use crate::sync;
use crate::time::{ClockCopies, LocalClock};
use crate::types::{Bus, CobId, Ecc, Frame, Instant, NodeId, Scet};

type Turn<'a> = super::Turn<'a, MasterEvent>;

/// Master of a spacecraft: NMT master, redundancy master, producer of SYNC and time, SDO client, CANopen device;
/// commands and telemetry.
///
/// `B` is [`TwoBoards`](crate::redundancy::TwoBoards) if another board may take over from this one.
#[doc(alias("NMT master", "redundancy master", "SYNC producer", "time producer"))]
#[derive(Debug)]
pub struct Master<D: SpacecraftDevice, B: MasterBoards = OneBoard> {
    services: Services<MasterObjects<D>>,
    boot: Timed<Boot>,
    transfers: Timed<Transfers>,
    redundancy: Timed<MasterRedundancy<B>>,
    clashes: StateClashes,
    /// Code of object 1F81h.
    assignments: Ecc,
    clock: ClockCopies,
    identification: Timed<Identification>,
    errors: Timed<ErrorReader>,
    budgets: Timed<Budgets>,
    rescue: Timed<Rescue>,
    sync: Timed<sync::machine::Producer>,
    /// COB-IDs of [`Profile::stamped`].
    stamped: &'static [CobId],
    /// [`Profile::minimal`].
    minimal: &'static [MinimalNode],
    /// Neither its boot-up message nor a later heartbeat was acknowledged: emergencies, which would win
    /// arbitration, wait.
    is_booting: bool,
    filters: Timed<ChangedFilters>,
    initial: Initial,
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    // One expression of calls, inlined where the master stays, so that each part is made in its place (row
    // `size.pyboard-v11.master.stack`). With `inline(never)` here alone the master of the pyboard does not start.
    fn new(boards: B, profile: &Profile, device: D, hardware: Hardware) -> Self {
        let Hardware { store, post_mortem, upsets, .. } = hardware;
        let initial = Initial::new(profile);
        Master {
            clashes: StateClashes::default(),
            // Computed at power-on.
            assignments: Ecc::default(),
            clock: ClockCopies::default(),
            identification: Timed::new(Identification::default()),
            errors: Timed::new(ErrorReader::new(requests::PERIOD)),
            budgets: Timed::new(Budgets::new(profile)),
            rescue: Timed::new(Rescue::default()),
            // Boot-up configures it by the objects.
            sync: Timed::new(sync::machine::Producer::with(sync::machine::Config::new(0, 0, 0))),
            stamped: profile.stamped,
            minimal: profile.minimal,
            is_booting: true,
            filters: Timed::new(ChangedFilters::default()),
            // Large ones last: the compiler makes them in their places where no loop follows.
            boot: Timed::new(requests::boot_at_power_on(profile)),
            transfers: Timed::new(Transfers::new(profile.sdo_timeout, profile.network.bit_rate)),
            redundancy: Timed::new(MasterRedundancy::new(boards, &initial::setup(profile))),
            services: Services::new(
                NodeId::MASTER,
                || initial.objects(profile, device, post_mortem),
                Stored::new(store),
                &settings::of_profile(profile, NodeId::MASTER),
                || State::new(profile, upsets),
            ),
            initial,
        }
    }

    /// Lends the redundancy for a change: the node runs at the end of its step. The others do so with their parts.
    fn redundancy_mut(&mut self) -> &mut MasterRedundancy<B> {
        self.redundancy.change(self.services.wakes_mut())
    }

    fn boot_mut(&mut self) -> &mut Boot {
        self.boot.change(self.services.wakes_mut())
    }

    fn transfers_mut(&mut self) -> &mut Transfers {
        self.transfers.change(self.services.wakes_mut())
    }

    fn errors_mut(&mut self) -> &mut ErrorReader {
        self.errors.change(self.services.wakes_mut())
    }

    fn power_on(&mut self, turn: &mut Turn) {
        if self.services.storage_mut().is_there() {
            self.services.load(Group::All);
            let redundancy = initial::written_redundancy(&self.services, &self.initial);
            self.redundancy_mut().restore(redundancy);
            self.note_filters();
        }
        self.take_assignments();
        if !self.redundancy_mut().start(turn.now) {
            return self.listen(turn);
        }
        self.services.buses_mut().join(self.redundancy.active(), turn.out);
        self.boot_up(turn);
        self.boot_mut().start(turn.now);
        self.run_all(turn);
    }

    /// Takes an event of a bus, except a received frame.
    fn on_bus_event(&mut self, bus: Bus, event: &LinkEvent, turn: &mut Turn) {
        match self.services.on_link(bus, event, turn.now) {
            Some(BusNews::Health(health)) if !self.is_active() => {
                self.services.on_health(bus, &health);
                turn.out.event(MasterEvent::Health { bus, health });
            }
            Some(BusNews::Health(health)) => self.on_health(bus, health, turn),
            Some(BusNews::Failed(health)) => {
                self.on_health(bus, health, turn);
                turn.out.event(MasterEvent::BusFailed { bus });
            }
            Some(BusNews::Stalled) => turn.out.event(MasterEvent::BusStalled { bus }),
            None => {}
        }
        match event {
            LinkEvent::Failed { frame, cause } => self.on_failed(bus, frame, *cause, turn),
            // Results of frames sent before this master became the standby.
            _ if !self.is_active() => {}
            LinkEvent::Transmitted { frame, stamp } => {
                self.on_transmitted(bus, frame, *stamp, turn);
                self.on_sdo_sent(bus, frame);
            }
            LinkEvent::Unsent { frames } => self.on_unsent(bus, *frames),
            LinkEvent::Overrun { .. } => self.lost(bus),
            LinkEvent::Counters(_) => self.services.refresh_health(),
            LinkEvent::Received { .. } | LinkEvent::Health(_) | LinkEvent::Stalled => {}
        }
        self.run_all(turn);
    }

    fn obey(&mut self, request: MasterRequest, turn: &mut Turn) {
        match request {
            MasterRequest::SetTime(scet) => self.services.set_time(scet.into(), turn),
            MasterRequest::StandBy => {
                let action = self.redundancy_mut().stand_by_commanded(turn.now);
                self.act_if(action, turn);
            }
            MasterRequest::Nmt(message) => self.on_nmt_request(message, turn),
            // A standby sends nothing.
            MasterRequest::Boot(node) if !self.is_active() => turn.out.event(MasterEvent::Refused { node }),
            _ if !self.is_active() => turn.out.event(MasterEvent::Refused { node: NodeId::MASTER }),
            MasterRequest::SwitchBus(bus) => self.redundancy_mut().request(bus),
            MasterRequest::Boot(node) => self.boot_mut().queue(node),
        }
    }

    /// Returns the spacecraft time at which the last SYNC was sent.
    pub fn scet_at_sync(&mut self) -> Option<Scet> {
        self.services.scet_at_sync()
    }

    /// Returns the state of the node at `now`.
    pub fn status(&self, now: Instant) -> Status {
        Status {
            uptime: now.since(Instant::ZERO),
            scet: self.services.scet(now),
            state: self.redundancy.state(),
            active: self.redundancy.active(),
            redundancy: *self.redundancy.parameters(),
            counters: *self.services.buses().counters(),
            health: *self.services.buses().health(),
        }
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> Node for Master<D, B> {
    type Event = MasterEvent;
    type Request = MasterRequest;
    type Depth = FullDepth;

    fn filters(&self) -> Filters {
        self.filters()
    }

    fn filter(&self, number: usize) -> Option<Filter> {
        (number <= FUNCTIONS).then(|| self.filter(number))
    }

    fn start(&mut self, turn: &mut Turn) {
        self.power_on(turn);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, turn: &mut Turn) {
        match event {
            LinkEvent::Received { frame, stamp } => self.on_received(bus, frame, stamp, turn),
            _ => self.on_bus_event(bus, event, turn),
        }
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        self.services.buses_mut().count_received(bus);
        // A frame is judged by its end.
        turn.until = stamp.at.min(turn.now);
        self.run(turn);
        turn.until = turn.now;
        if self.is_active() {
            self.on_frame(bus, frame, stamp, turn);
        } else {
            self.overhear(bus, frame, stamp, turn);
        }
        self.run(turn);
    }

    fn on_request(&mut self, request: MasterRequest, turn: &mut Turn) {
        self.obey(request, turn);
        self.run_all(turn);
    }

    fn poll(&mut self, turn: &mut Turn) {
        self.run_all(turn);
        self.advance_save(turn);
    }

    fn deadline(&self) -> Option<Instant> {
        self.services.with_save(self.services.wakes().deadline())
    }

    fn is_on_schedule(&self, now: Instant) -> bool {
        self.redundancy.is_on_schedule(now)
            && (!self.is_active() || !self.produces_sync() || self.sync.is_on_schedule(now))
    }

    fn charge(&mut self, frame: &Frame, turn: &mut Turn) -> bool {
        self.takes_token(frame.id(), turn)
    }

    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool {
        let id = frame.id();
        let is_measured = if self.services.is_sync(id) {
            sync::is_sync_length(frame)
        } else {
            self.stamped.contains(&id) || self.services.is_ranged(id)
        };
        is_measured && bus == self.redundancy.active()
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> TimeKeeper for Master<D, B> {
    fn spacecraft_clock(&self) -> &LocalClock {
        self.services.time().clock()
    }
}

impl Part for Rescue {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

impl<B: MasterBoards> Part for MasterRedundancy<B> {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}
