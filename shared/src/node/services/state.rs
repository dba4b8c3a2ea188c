//! State of a node of a spacecraft beside its objects.

use super::mapped::MappedTime;
use crate::pdo::PdoSlots;
use crate::profile::Profile;
use crate::sdo::SdoServers;
use crate::time::{ClientSamples, TimeService};

/// State of a node of a spacecraft beside its objects.
#[derive(Debug)]
pub struct State<P: PdoSlots, S: SdoServers> {
    /// Clock and time service.
    pub time: TimeService,
    /// Samples of the time for a second client.
    pub(super) other_client: S::Second<OtherClient>,
    /// The time that each receive PDO carries (2010h, 2012h).
    pub(super) mapped_time: P::Receive<MappedTime>,
    /// `true`: one of them carries the time of the last SYNC.
    pub(super) is_time_by_sync: bool,
    /// Transmit PDOs that carry the local time (2011h, 2013h).
    pub(super) carries_time: P::Transmit<bool>,
    /// `true`: a transmit PDO carries a live value: the local time, 2015h, 2020h, 2021h.
    pub(super) carries_live_value: bool,
    /// `true`: a transmit PDO carries 2015h, which takes a thousand instructions.
    pub(super) carries_quality: bool,
    /// `true`: the time of SYNCs is needed, for a live value or for a time that a PDO brings.
    pub(super) notes_syncs: bool,
    /// `true` until the boot-up message was sent: then the last reset is reported.
    pub(super) is_reset_due: bool,
}

/// Samples of the time for a client that is not the last one to read it: that of another SDO server.
#[derive(Debug, Default)]
pub struct OtherClient {
    pub(super) samples: ClientSamples,
    /// Number of the server whose client read the time last.
    pub(super) reader: usize,
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
            is_reset_due: true,
        }
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
