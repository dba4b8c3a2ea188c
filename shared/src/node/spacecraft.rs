//! Objects that a node of a spacecraft has beyond CANopen: redundancy, time, health of both buses, self-test,
//! parameter store.

use crate::emcy::{ErrorCode, PostMortem, PostMortemObjects};
use crate::heartbeat::HeartbeatTimes;
use crate::link::port::Health;
use crate::node::{Counters, UpsetObjects};
use crate::od::{Objects, Record};
use crate::redundancy::{Parameters, RedundancyObjects};
use crate::store::StoreObjects;
use crate::time::{ClockObjects, LocalScet, TimeCorrection, TimeService};
use crate::types::{Address, Bus, CobId, FineScet, Instant, NodeId};

/// Objects 2000h to 203Fh, 2046h, 2047h, 1010h and 1011h.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct Spacecraft {
    /// Objects of the redundancy
    #[objects]
    pub redundancy: RedundancyObjects,
    /// Objects of the spacecraft time
    #[objects]
    pub time: LocalScet,
    /// Objects of the clock
    #[objects]
    pub clock: ClockObjects,
    /// Objects of the parameter store
    #[objects]
    pub storage: StoreObjects,
    /// Health of the nominal bus
    #[object(0x2020, record)]
    pub health_nominal: BusHealth,
    /// Health of the redundant bus
    #[object(0x2021, record)]
    pub health_redundant: BusHealth,
    /// Self-test start
    ///
    /// Written with 1 it starts (ECSS 6.7b).
    #[object(0x2030, wo, low = 1, high = 1)]
    pub self_test_start: u8,
    /// Self-test result
    #[object(0x2031, record)]
    pub self_test: SelfTest,
    /// Objects of the last reset
    #[objects]
    pub post_mortem: PostMortemObjects,
    /// Protected identity
    #[object(0x2046, record)]
    pub identity: ProtectedIdentity,
    /// Transmit budget
    #[object(0x2047, record)]
    pub over_budget: OverBudget,
    /// Objects of upsets
    #[objects]
    pub upsets: UpsetObjects,
}

impl Spacecraft {
    /// Returns the redundancy parameters. `times` are those of 1016h and 1017h.
    pub(super) fn redundancy(&self, times: HeartbeatTimes) -> Parameters {
        self.redundancy.parameters.parameters(times.consumer, times.producer)
    }

    /// Writes the redundancy parameters. Returns the objects that changed and that a PDO may carry.
    pub(super) fn show_redundancy(
        &mut self,
        redundancy: &Parameters,
    ) -> impl Iterator<Item = Address> + use<> {
        let before = self.redundancy.parameters;
        self.set_redundancy(redundancy);
        self.redundancy.parameters.changes(&before)
    }

    pub(super) fn set_bdefault(&mut self, bus: Bus) {
        self.redundancy.parameters.bdefault = bus.bdefault();
    }

    /// Returns the correction of the stamps (2014h).
    pub(super) const fn correction(&self) -> &TimeCorrection {
        &self.clock.correction
    }

    /// Updates the quality of the clock (2015h).
    pub(super) fn show_quality(&mut self, time: &TimeService, now: Instant) {
        self.clock.quality = time.quality(&self.clock.correction, now);
    }

    /// Shows the local time at which the last heartbeat of this node ended (2016h).
    pub(super) fn show_heartbeat(&mut self, sent: FineScet) {
        self.clock.heartbeat_sent = sent.units();
    }

    /// Shows that the self-test runs.
    pub(super) fn start_self_test(&mut self) {
        self.self_test = SelfTest { progress: SelfTest::RUNNING, failures: 0 };
    }

    /// Counts a frame that the budget refused. `is_silenced`: it made the node silent.
    pub(super) fn count_refused(&mut self, id: CobId, is_silenced: bool) {
        let shown = &mut self.over_budget;
        (shown.refused, shown.last) = (shown.refused.saturating_add(1), id.raw());
        shown.silenced = shown.silenced.saturating_add(u16::from(is_silenced));
    }

    /// Shows the Node-ID that the store has (2046h).
    pub(super) fn show_node_id(&mut self, id: Option<NodeId>) {
        self.identity.stored = id.map_or(0, |id| id.get().into());
    }

    /// Takes the record of the last reset.
    pub(super) fn set_post_mortem(&mut self, record: PostMortem) {
        self.post_mortem.record = record;
    }

    /// Returns the emergency that reports the last reset. `None`: it had no cause.
    pub(super) const fn reset_emergency(&self) -> Option<(ErrorCode, [u8; 5])> {
        self.post_mortem.record.emergency()
    }

    /// Writes object 2000h.
    pub(super) fn set_redundancy(&mut self, redundancy: &Parameters) {
        self.redundancy.parameters = redundancy.into();
    }
}

/// Node-ID and COB-IDs that are protected against failures (2046h; ECSS 6.10d, g, k).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct ProtectedIdentity {
    /// Stored Node-ID
    ///
    /// Reads 0 where none is stored. Written in maintenance mode only: Node-ID, its complement, 49h, 44h from the
    /// lowest byte on; Node-ID 0 stores none. Takes effect with the next reset.
    #[sub(1, rw, volatile)]
    pub stored: u32,
    /// Flipped bits mended
    ///
    /// In Node-ID and COB-IDs, since power-on or the last reset.
    #[sub(2, ro)]
    pub mended: u16,
}

/// Error state, error counters and lost frames of a bus (2020h, 2021h; ECSS 5.6.2).
#[doc(alias("2020h", "2021h"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct BusHealth {
    /// Error state
    ///
    /// 0 error active, 1 error passive, 2 bus-off.
    #[sub(1, ro, pdo)]
    pub state: u8,
    /// Transmit error counter
    #[sub(2, ro, pdo)]
    pub tec: u8,
    /// Receive error counter
    #[sub(3, ro, pdo)]
    pub rec: u8,
    /// Last error
    ///
    /// 0 none, 1 stuff, 2 form, 3 acknowledgement, 4 bit recessive, 5 bit dominant, 6 CRC.
    #[sub(4, ro, pdo)]
    pub last_error: u8,
    /// Frames received
    #[sub(5, ro, pdo)]
    pub received: u32,
    /// Frames sent
    #[sub(6, ro, pdo)]
    pub sent: u32,
    /// Frames lost in reception
    #[sub(7, ro, pdo)]
    pub lost: u16,
    /// Malformed frames
    #[sub(8, ro, pdo)]
    pub malformed: u16,
    /// Frames ignored
    #[sub(9, ro, pdo)]
    pub ignored: u16,
    /// Frames not sent
    #[sub(10, ro, pdo)]
    pub failed: u16,
}

impl BusHealth {
    /// Copies error state and counters of the node.
    pub fn new(health: &Health, counters: &Counters) -> BusHealth {
        BusHealth {
            state: health.state as u8,
            tec: health.tec,
            rec: health.rec,
            last_error: health.last_error as u8,
            received: counters.received,
            sent: counters.sent,
            lost: counters.lost,
            malformed: counters.malformed,
            ignored: counters.ignored,
            failed: counters.failed(),
        }
    }
}

/// Frames that this node did not send because it was above its budget (2047h; ECSS 5.3.3.1b).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct OverBudget {
    /// Frames refused
    #[sub(1, ro)]
    pub refused: u32,
    /// COB-ID of the last one
    #[sub(2, ro)]
    pub last: u16,
    /// Times that the node silenced itself
    #[sub(3, ro)]
    pub silenced: u16,
}

/// Built-in self-test (2031h; ECSS 6.7c).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct SelfTest {
    /// Progress
    ///
    /// 0 never run, 1 running, 2 passed, 3 failed.
    #[sub(1, ro, pdo)]
    pub progress: u8,
    /// Failures
    ///
    /// A bit for each check that failed.
    #[sub(2, ro, pdo)]
    pub failures: u32,
}

impl SelfTest {
    /// Value of `progress`: the self-test is running.
    pub const RUNNING: u8 = 1;
    /// Value of `progress`: no check failed.
    pub const PASSED: u8 = 2;
    /// Value of `progress`: at least one check failed.
    pub const FAILED: u8 = 3;
}
