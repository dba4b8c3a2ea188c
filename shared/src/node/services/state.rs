//! State of a node of a spacecraft beside its objects.

use super::live::is_live;
use super::mapped::{MappedTime, carries_time, has};
use crate::node::Upsets;
use crate::node::index::CLOCK_QUALITY;
use crate::od::INVALID;
use crate::pdo::PdoSlots;
use crate::pdo::machine::rules::is_synchronous;
use crate::profile::Profile;
use crate::sdo::SdoServers;
use crate::time::{ClientSamples, TimeService};

/// State of a node of a spacecraft beside its objects.
#[derive(Debug)]
pub struct State<P: PdoSlots, S: SdoServers> {
    /// Clock and time service.
    time: TimeService,
    /// Samples of the time for a second client.
    other_client: S::Second<OtherClient>,
    /// The time that each receive PDO carries (2010h, 2012h).
    mapped_time: P::Receive<MappedTime>,
    /// `true`: one of them carries the time of the last SYNC.
    is_time_by_sync: bool,
    /// Transmit PDOs that carry the local time (2011h, 2013h).
    carries_time: P::Transmit<bool>,
    /// `true`: a transmit PDO carries a live value: the local time, 2015h, 2020h, 2021h.
    carries_live_value: bool,
    /// `true`: a transmit PDO carries 2015h, which takes a thousand instructions.
    carries_quality: bool,
    /// `true`: the time of SYNCs is needed, for a live value or for a time that a PDO brings.
    notes_syncs: bool,
    /// `true` until the boot-up message was sent: then the last reset is reported.
    is_reset_due: bool,
    /// Upsets that the board finds.
    upsets: Option<&'static Upsets>,
}

/// Samples of the time for a client that is not the last one to read it: that of another SDO server.
#[derive(Debug, Default)]
pub struct OtherClient {
    samples: ClientSamples,
    /// Number of the server whose client read the time last.
    reader: usize,
}

impl<P: PdoSlots, S: SdoServers> State<P, S> {
    /// Makes the state at power-on. The clock is not set. `upsets`: those that the board finds.
    pub fn new(profile: &Profile, upsets: Option<&'static Upsets>) -> Self {
        State {
            time: TimeService::new(&profile.clocks, profile.network.longest_delay()),
            other_client: S::second(OtherClient::default),
            mapped_time: P::receive(MappedTime::None),
            is_time_by_sync: false,
            carries_time: P::transmit(false),
            carries_live_value: false,
            carries_quality: false,
            notes_syncs: false,
            is_reset_due: true,
            upsets,
        }
    }

    /// Returns clock and time service.
    pub const fn time(&self) -> &TimeService {
        &self.time
    }

    /// Lends clock and time service.
    pub const fn time_mut(&mut self) -> &mut TimeService {
        &mut self.time
    }

    /// Notes which PDOs carry the time or live values. The master needs the time of SYNCs in any case.
    pub fn note_mappings(&mut self, pdos: &P, is_master: bool) {
        (self.is_time_by_sync, self.notes_syncs) = (false, is_master);
        let (parameters, mappings) = pdos.rpdos();
        for ((mapped_time, pdo), mapping) in
            self.mapped_time.as_mut().iter_mut().zip(parameters).zip(mappings)
        {
            *mapped_time = MappedTime::of(mapping);
            self.is_time_by_sync |= *mapped_time != MappedTime::None
                && pdo.cob_id & INVALID == 0
                && is_synchronous(pdo.transmission);
        }
        let (_, mappings) = pdos.tpdos();
        for (carries, mapping) in self.carries_time.as_mut().iter_mut().zip(mappings) {
            *carries = carries_time(mapping);
        }
        self.carries_live_value = mappings.iter().any(|mapping| has(mapping, is_live));
        self.carries_quality = mappings.iter().any(|mapping| has(mapping, |index| index == CLOCK_QUALITY));
        self.notes_syncs |= self.carries_live_value || self.is_time_by_sync;
    }

    /// Gives the time service the samples of the client of the SDO server with this number.
    pub fn choose_client(&mut self, server: usize) {
        if let Some(other) = self.other_client.as_mut().first_mut().filter(|other| other.reader != server) {
            core::mem::swap(&mut other.samples, self.time.samples_mut());
            other.reader = server;
        }
    }

    /// Returns whether the last reset is to be reported now, once.
    pub const fn take_reset(&mut self) -> bool {
        core::mem::replace(&mut self.is_reset_due, false)
    }

    /// Returns the upsets that the board finds.
    pub const fn upsets(&self) -> Option<&'static Upsets> {
        self.upsets
    }

    /// Returns whether a receive PDO carries the time of the last SYNC.
    pub const fn is_time_by_sync(&self) -> bool {
        self.is_time_by_sync
    }

    /// Returns whether a transmit PDO carries a live value.
    pub const fn carries_live_value(&self) -> bool {
        self.carries_live_value
    }

    /// Returns whether a transmit PDO carries the quality of the clock (2015h).
    pub const fn carries_quality(&self) -> bool {
        self.carries_quality
    }

    /// Returns the time that the receive PDO with this number carries.
    pub fn mapped_time(&self, number: usize) -> MappedTime {
        self.mapped_time.as_ref().get(number).copied().unwrap_or_default()
    }

    /// Returns whether the time of SYNCs is needed.
    pub const fn notes_syncs(&self) -> bool {
        self.notes_syncs
    }

    /// Returns whether the transmit PDO with this number carries the local time.
    pub fn carries_time(&self, number: usize) -> bool {
        self.carries_time.as_ref().get(number).is_some_and(|carries| *carries)
    }
}
