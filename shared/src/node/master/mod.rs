//! The master node.

mod actions;
mod boot;
mod budget;
mod declared;
mod errors;
mod filters;
mod identify;
mod network;
mod objects;
mod ranging;
mod reception;
mod role;
mod sending;
mod transfers;

pub use declared::MasterObjects;

use self::budget::Budgets;
use self::filters::FUNCTIONS;
use self::identify::Identification;
use self::objects::Initial;
use self::transfers::Transfers;
use super::buses::BusNews;
use super::services::Services;
use super::{Device, MasterEvent, MasterRequest, Status};
use crate::boot::Boot;
use crate::emcy::ErrorReader;
use crate::link::Stamp;
use crate::link::port::Filter;
use crate::nmt::StateClashes;
use crate::node::{Filters, FullDepth, LinkEvent, Node, Outbox, TimeKeeper};
use crate::profile::{MinimalNode, Profile};
use crate::redundancy::{MasterBoards, MasterRedundancy, OneBoard, Strap, TwoBoards};
use crate::store::{Group, ParameterStore};
use crate::sync;
use crate::time::LocalClock;
use crate::types::{Bus, CobId, Frame, Instant, NodeId, Scet, earliest};

type Out = Outbox<MasterEvent>;

/// Master of a spacecraft: NMT master, redundancy master, producer of SYNC and time, SDO client, CANopen device;
/// commands and telemetry.
///
/// `B` is [`TwoBoards`] if another board may take over from this one.
#[doc(alias("NMT master", "redundancy master", "SYNC producer", "time producer"))]
#[derive(Debug)]
pub struct Master<D: Device, B: MasterBoards = OneBoard> {
    services: Services<MasterObjects<D>>,
    boot: Boot,
    transfers: Transfers,
    redundancy: MasterRedundancy<B>,
    clashes: StateClashes,
    identification: Identification,
    errors: ErrorReader,
    budgets: Budgets,
    sync: sync::Producer,
    /// COB-IDs of [`Profile::stamped`].
    stamped: &'static [CobId],
    /// [`Profile::minimal`].
    minimal: &'static [MinimalNode],
    /// Neither its boot-up message nor a later heartbeat was acknowledged: emergencies, which would win
    /// arbitration, wait.
    is_booting: bool,
    /// COB-IDs of RPDOs changed: the filters have to be set.
    are_filters_due: bool,
    /// Filters that the buses have, without the last one.
    filters_set: [Filter; FUNCTIONS as usize],
    initial: Initial,
}

impl<D: Device> Master<D> {
    /// Makes a master before power-on. With a parameter store objects 1010h and 1011h work, and the stored
    /// parameters apply from power-on.
    #[inline(always)] // a copy of a master is 20 kB of stack
    pub fn new(
        profile: &Profile,
        device: D,
        store: Option<&'static mut (dyn ParameterStore + Send)>,
    ) -> Self {
        Master::with(OneBoard, profile, device, store)
    }
}

impl<D: Device> Master<D, TwoBoards> {
    /// Makes one of two masters before power-on. `strap` is the number of the board (ECSS 8.1a, Figure 4-2). The
    /// board listens first, and then becomes active or the standby. With a profile that has no numbers for two
    /// boards ([`Profile::standby`]) it is the same as [`Master::new`].
    #[inline(always)] // a copy of a master is 20 kB of stack
    pub fn of_two(
        profile: &Profile,
        strap: Strap,
        device: D,
        store: Option<&'static mut (dyn ParameterStore + Send)>,
    ) -> Self {
        Master::with(TwoBoards::new(profile.standby, strap), profile, device, store)
    }
}

impl<D: Device, B: MasterBoards> Master<D, B> {
    // One expression of calls: each part is made in its place, and a copy of a master is 20 kB of stack.
    #[inline(never)]
    fn with(
        boards: B,
        profile: &Profile,
        device: D,
        store: Option<&'static mut (dyn ParameterStore + Send)>,
    ) -> Self {
        let initial = Initial::new(profile);
        Master {
            clashes: StateClashes::default(),
            identification: Identification::default(),
            errors: ErrorReader::new(errors::PERIOD),
            budgets: Budgets::new(profile),
            sync: sync::Producer::with(initial.communication::<D>().sync.config()),
            stamped: profile.stamped,
            minimal: profile.minimal,
            is_booting: true,
            are_filters_due: false,
            filters_set: [Filter::exact(CobId::NMT); FUNCTIONS as usize],
            // Large ones last: the compiler makes them in their places where no loop follows.
            boot: boot::at_power_on(profile),
            transfers: Transfers::new(profile.sdo_timeout, profile.network.bit_rate),
            redundancy: MasterRedundancy::new(boards, &objects::setup(profile)),
            services: Services::new(NodeId::MASTER, || initial.objects(profile, device), profile, store),
            initial,
        }
    }

    /// Does all that was due at `until`, which may be before `now`: a frame is judged as of its end.
    #[inline]
    fn run(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if until >= self.services.next {
            self.run_all(until, now, out);
        }
    }

    /// Polls every service, due or not.
    #[inline(never)] // most frames find nothing due
    fn run_all(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if self.is_active() {
            while let Some(bus) = self.services.buses.poll(until, out) {
                self.report_health(bus, now);
                out.event(MasterEvent::BusFailed { bus });
            }
            self.run_budget(until, now, out);
        }
        while let Some(action) = self.redundancy.poll(until, now) {
            self.act(action, now, out);
        }
        if !self.is_active() {
            self.services.next = self.run_filters(now, out);
            return self.services.wake(self.redundancy.deadline());
        }
        self.run_boot(until, now, out);
        self.run_device(until, now, out);
        if self.redundancy.is_announced() {
            let bus = self.redundancy.active();
            if self.produces_sync()
                && let Some(frame) = self.sync.poll(until)
            {
                out.send_for(bus, frame, now, self.services.sync_lifetime());
            }
        }
        self.services.wake(self.due());
    }

    fn due(&self) -> Option<Instant> {
        let all = [
            self.redundancy.deadline(),
            self.services.buses.deadline(),
            self.boot.deadline(),
            self.transfers.deadline(),
            self.identification_deadline(),
            self.errors_deadline(),
            self.budgets.deadline(),
            self.device_deadline(),
            self.sync.deadline().filter(|_| self.redundancy.is_announced() && self.produces_sync()),
        ];
        earliest(&all)
    }

    fn produces_sync(&self) -> bool {
        self.boot.is_released() && self.redundancy.state().allows_sync()
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
            counters: self.services.buses.counters,
            health: self.services.buses.health,
        }
    }
}

impl<D: Device, B: MasterBoards> Node for Master<D, B> {
    type Event = MasterEvent;
    type Request = MasterRequest;
    type Depth = FullDepth;

    fn filters(&self) -> Filters {
        self.filters()
    }

    fn filter(&self, number: usize) -> Option<Filter> {
        u16::try_from(number).ok().filter(|number| *number <= FUNCTIONS).map(|number| self.filter(number))
    }

    fn start(&mut self, now: Instant, out: &mut Out) {
        self.filters_set = core::array::from_fn(|number| self.filter(number as u16));
        if self.services.dictionary.stored.store.is_some() {
            self.services.load(Group::All);
            let objects = &self.services.dictionary.objects;
            let redundancy = objects::written_redundancy(objects, &self.initial);
            self.redundancy.restore(redundancy);
            self.are_filters_due = true;
        }
        self.take_assignments();
        if !self.redundancy.start(now) {
            return self.listen(now, out);
        }
        self.services.buses.join(self.redundancy.active(), out);
        self.boot_up(now, out);
        self.boot.start(now);
        self.run_all(now, now, out);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        if let LinkEvent::Received { frame, stamp } = event {
            return self.on_received(bus, frame, stamp, now, out);
        }
        match self.services.buses.on_link(bus, event, now) {
            Some(BusNews::Health(health)) if !self.is_active() => {
                self.services.on_health(bus, &health);
                out.event(MasterEvent::Health { bus, health });
            }
            Some(BusNews::Health(health)) => self.on_health(bus, health, now, out),
            Some(BusNews::Failed(health)) => {
                self.on_health(bus, health, now, out);
                out.event(MasterEvent::BusFailed { bus });
            }
            Some(BusNews::Stalled) => out.event(MasterEvent::BusStalled { bus }),
            None => {}
        }
        match event {
            LinkEvent::Failed { frame, cause } => self.on_failed(bus, frame, *cause, now, out),
            // Results of frames sent before this master became the standby.
            _ if !self.is_active() => {}
            LinkEvent::Transmitted { frame, stamp } => {
                self.on_transmitted(bus, frame, *stamp, now, out);
                self.on_sdo_sent(bus, frame);
            }
            LinkEvent::Unsent { frames } => self.on_unsent(bus, *frames),
            LinkEvent::Overrun { .. } => self.lost(bus),
            LinkEvent::Counters(_) => self.services.refresh_health(),
            LinkEvent::Received { .. } | LinkEvent::Health(_) | LinkEvent::Stalled => {}
        }
        self.run_all(now, now, out);
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        self.services.buses.received(bus);
        self.run(stamp.at.min(now), now, out);
        if self.is_active() {
            self.on_frame(bus, frame, stamp, now, out);
        } else {
            self.overhear(bus, frame, stamp, now, out);
        }
        self.run(now, now, out);
    }

    fn on_request(&mut self, request: MasterRequest, now: Instant, out: &mut Out) {
        match request {
            MasterRequest::SetTime(scet) => self.services.set_time(scet.into(), now, out),
            MasterRequest::StandBy => {
                if let Some(action) = self.redundancy.stand_by_commanded(now) {
                    self.act(action, now, out);
                }
            }
            MasterRequest::Nmt(message) => self.on_nmt_request(message, now, out),
            // A standby sends nothing.
            MasterRequest::Boot(node) if !self.is_active() => out.event(MasterEvent::Refused { node }),
            _ if !self.is_active() => out.event(MasterEvent::Refused { node: NodeId::MASTER }),
            MasterRequest::SwitchBus(bus) => self.redundancy.request(bus),
            MasterRequest::Boot(node) => self.boot.queue(node),
        }
        self.run_all(now, now, out);
    }

    fn poll(&mut self, now: Instant, out: &mut Out) {
        self.run_all(now, now, out);
        self.advance_save(now, out);
    }

    fn deadline(&self) -> Option<Instant> {
        let next = (self.services.next < Instant::NEVER).then_some(self.services.next);
        self.services.with_save(next)
    }

    fn charge(&mut self, frame: &Frame, now: Instant, out: &mut Out) -> bool {
        self.takes_token(frame.id(), now, out)
    }

    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool {
        let id = frame.id();
        let is_measured = if self.services.is_sync(id) {
            sync::is_sync_length(frame)
        } else {
            self.stamped.contains(&id) || self.is_ranged(id)
        };
        is_measured && bus == self.redundancy.active()
    }
}

impl<D: Device, B: MasterBoards> TimeKeeper for Master<D, B> {
    fn spacecraft_clock(&self) -> &LocalClock {
        self.services.time.clock()
    }
}
