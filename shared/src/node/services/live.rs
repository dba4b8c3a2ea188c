//! Live objects: local time, quality of the clock, health of the buses. They are sampled when they are read or sent.

use async_canopen::node::extend;
use easy_ext::ext;

use super::Services;
use super::time::{self, MappedTime, TimeServices, is_local_time};
use crate::node::index::{CLOCK_QUALITY, HEALTH_NOMINAL, HEALTH_REDUNDANT, HEARTBEAT_SENT};
use crate::node::{NodeObjects, SpacecraftDevice};
use crate::od::INVALID;
use crate::pdo::rules::is_synchronous;
use crate::pdo::{Mapping, PdoSlots};
use crate::profile::Profile;
use crate::sdo::SdoServers;
use crate::time::{ClientSamples, TimeService};
use crate::types::{CobId, FineInstant, Frame, Instant, NodeId};

/// State of a node of a spacecraft beside its objects.
#[derive(Debug)]
pub struct State<P: PdoSlots, S: SdoServers> {
    /// Clock and time service.
    pub time: TimeService,
    /// Samples of the time for a second client.
    other_client: S::Second<OtherClient>,
    /// The time that each receive PDO carries (2010h, 2012h).
    pub(super) mapped_time: P::Receive<MappedTime>,
    /// `true`: one of them carries the time of the last SYNC.
    pub(super) is_time_by_sync: bool,
    /// Transmit PDOs that carry the local time (2011h, 2013h).
    pub(super) carries_time: P::Transmit<bool>,
    /// `true`: a transmit PDO carries a live value: the local time, 2015h, 2020h, 2021h.
    pub(super) carries_live_value: bool,
    /// `true`: a transmit PDO carries 2015h, which takes a thousand instructions.
    carries_quality: bool,
    /// `true`: the time of SYNCs is needed, for a live value or for a time that a PDO brings.
    notes_syncs: bool,
    /// The last reset is reported when the boot-up message was sent.
    pub(super) is_reset_due: bool,
}

/// Samples of the time for a client that is not the last one to read it: that of another SDO server.
#[derive(Debug, Default)]
pub struct OtherClient {
    samples: ClientSamples,
    /// Number of the server whose client read the time last.
    reader: usize,
}

impl<P: PdoSlots, S: SdoServers> State<P, S> {
    /// Makes the state at power-on. The clock is not set.
    pub fn new(profile: &Profile) -> Self {
        State {
            time: TimeService::new(&profile.clocks, profile.network.longest_delay()),
            other_client: S::second(OtherClient::default),
            mapped_time: P::receive(MappedTime::None),
            is_time_by_sync: false,
            carries_time: P::transmit(false),
            carries_live_value: false,
            carries_quality: false,
            notes_syncs: false,
            is_reset_due: false,
        }
    }

    /// Returns the time that the receive PDO with this number carries.
    #[inline]
    pub fn mapped_time(&self, number: usize) -> MappedTime {
        self.mapped_time.as_ref().get(number).copied().unwrap_or_default()
    }

    /// Returns whether the time of SYNCs is needed.
    pub const fn notes_syncs(&self) -> bool {
        self.notes_syncs
    }

    /// Returns whether the transmit PDO with this number carries the local time.
    #[inline]
    pub fn carries_time(&self, number: usize) -> bool {
        self.carries_time.as_ref().get(number).is_some_and(|carries| *carries)
    }
}

/// Returns whether an object is sampled when it is read: local time, quality of the clock, health of the buses.
pub fn is_live(index: u16) -> bool {
    is_local_time(index)
        || matches!(index, CLOCK_QUALITY | HEARTBEAT_SENT | HEALTH_NOMINAL | HEALTH_REDUNDANT)
}

/// Returns whether a mapping has an object for which `is_it` holds.
fn has(mapping: &impl Mapping, is_it: impl Fn(u16) -> bool) -> bool {
    mapping.objects().iter().any(|object| is_it((object >> 16) as u16))
}

#[ext(LiveServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Notes which PDOs carry the time or live values.
    pub fn note_live_values(&mut self) {
        let is_master = self.id() == NodeId::MASTER;
        let (NodeObjects { pdos, .. }, state) = (&self.dictionary.objects, &mut self.state);
        (state.is_time_by_sync, state.notes_syncs) = (false, is_master);
        let (parameters, mappings) = pdos.rpdos();
        for ((mapped_time, pdo), mapping) in
            state.mapped_time.as_mut().iter_mut().zip(parameters).zip(mappings)
        {
            *mapped_time = MappedTime::of(mapping);
            state.is_time_by_sync |= *mapped_time != MappedTime::None
                && pdo.cob_id & INVALID == 0
                && is_synchronous(pdo.transmission);
        }
        for (carries_time, mapping) in state.carries_time.as_mut().iter_mut().zip(pdos.tpdos().1) {
            *carries_time = time::carries_time(mapping);
        }
        let mut carried = pdos.tpdos().1.iter();
        state.carries_live_value = carried.clone().any(|mapping| has(mapping, is_live));
        state.carries_quality = carried.any(|mapping| has(mapping, |index| index == CLOCK_QUALITY));
        state.notes_syncs |= state.carries_live_value || state.is_time_by_sync;
        let notes_syncs = state.notes_syncs;
        self.watch_syncs(notes_syncs);
    }

    /// Samples the live objects for transmit PDOs.
    pub fn refresh(&mut self, at: FineInstant) {
        self.refresh_time(at);
        self.refresh_carried(at.instant());
    }

    /// Those that are no time.
    pub fn refresh_carried(&mut self, now: Instant) {
        if self.state.carries_quality {
            self.refresh_quality(now);
        }
        self.refresh_health();
    }

    /// Samples the live objects if an SDO request is for one of them.
    #[inline] // row `instructions.sdo_upload`
    pub fn refresh_for(&mut self, request: &Frame, now: Instant) {
        if is_live((request.bits() >> 8) as u16) {
            self.refresh_time_for(request, now);
            self.refresh_health();
        }
    }

    /// Gives the time service the samples of the client that sends requests with this COB-ID: parts that a client reads one by
    /// one belong to one sample, whatever the other client reads between them.
    #[inline]
    pub fn choose_client(&mut self, request: CobId) {
        let nth = self.server_of(request);
        let State { other_client, time, .. } = &mut self.state;
        if let Some(other) = other_client.as_mut().first_mut().filter(|other| other.reader != nth) {
            core::mem::swap(&mut other.samples, time.samples_mut());
            other.reader = nth;
        }
    }

    /// Samples the live objects for transmit PDOs that are due by an event or a timer.
    pub fn sample_events(&mut self, until: Instant) {
        if self.state.carries_live_value && self.dictionary.tpdos.deadline().is_some_and(|due| due <= until) {
            self.refresh_time_of_events(until);
            self.refresh_carried(until);
        }
    }

    /// Triggers the transmit PDOs that carry the time.
    pub fn trigger_time(&mut self, now: Instant) {
        let extend::Services { dictionary, state, wakes, .. } = self;
        for (number, carries_time) in state.carries_time.as_ref().iter().enumerate() {
            if *carries_time {
                dictionary.tpdos.change(wakes).trigger(number, now);
            }
        }
    }
}
