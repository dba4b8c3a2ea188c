//! Objects that ECSS-E-ST-50-15C adds to CANopen: redundancy, time, health of both buses, self-test.

use super::{Objects, Record, U24};
use crate::link::port::Health;
use crate::node::Counters;
use crate::time::{Scet, Utc};

/// The objects 2000h to 203Fh of every node.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct Spacecraft {
    /// Redundancy
    #[object(0x2000, record)]
    pub redundancy: Redundancy,
    /// Local SCET set
    #[object(0x2010, record)]
    pub scet_set: ScetSet,
    /// Local SCET get
    #[object(0x2011, record)]
    pub scet_get: ScetGet,
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
}

/// Redundancy parameters (2000h, ECSS 8.3.1).
///
/// Written by SDO only, which the redundancy hears of; a PDO would change no more than the value here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Redundancy {
    /// Bdefault
    ///
    /// 0 nominal, 1 redundant.
    #[sub(1, rwr, pdo)]
    pub bdefault: u8,
    /// Ttoggle
    ///
    /// Consumer times.
    #[sub(2, rw)]
    pub ttoggle: u8,
    /// Ntoggle
    #[sub(3, rw)]
    pub ntoggle: u8,
    /// Ctoggle
    #[sub(4, rwr, pdo)]
    pub ctoggle: u8,
}

/// Spacecraft elapsed time as it is set (0040h, ECSS 7.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x40)]
pub struct ScetSet {
    /// Coarse time
    ///
    /// Seconds.
    #[sub(1, rww, pdo)]
    pub coarse: u32,
    /// Fine time
    ///
    /// Units of 2^-24 s.
    #[sub(2, rww, pdo)]
    pub fine: U24,
}

/// Spacecraft elapsed time as it is read (0040h, ECSS 7.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x40)]
pub struct ScetGet {
    /// Coarse time
    ///
    /// Seconds.
    #[sub(1, ro, pdo)]
    pub coarse: u32,
    /// Fine time
    ///
    /// Units of 2^-24 s.
    #[sub(2, ro, pdo)]
    pub fine: U24,
}

impl From<ScetSet> for Scet {
    fn from(value: ScetSet) -> Scet {
        Scet::new(value.coarse, value.fine.get() as u32).unwrap_or_default()
    }
}

impl From<Scet> for ScetGet {
    fn from(time: Scet) -> ScetGet {
        ScetGet { coarse: time.coarse(), fine: U24::new(u64::from(time.fine())) }
    }
}

/// The time objects of a device that keeps UTC (ECSS 7.1.3): for its own `#[objects]`.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct LocalUtc {
    /// Local UTC set
    #[object(0x2012, record)]
    pub utc_set: UtcSet,
    /// Local UTC get
    #[object(0x2013, record)]
    pub utc_get: UtcGet,
}

/// Spacecraft UTC as it is set (0041h, ECSS 7.1.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x41)]
pub struct UtcSet {
    /// Day
    ///
    /// Since the epoch of the mission.
    #[sub(1, rww, pdo)]
    pub day: u16,
    /// Milliseconds of day
    #[sub(2, rww, pdo)]
    pub ms: u32,
    /// Submilliseconds of ms
    ///
    /// Units of 2^-16 ms.
    #[sub(3, rww, pdo)]
    pub submilliseconds: u16,
}

/// Spacecraft UTC as it is read (0041h, ECSS 7.1.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x41)]
pub struct UtcGet {
    /// Day
    ///
    /// Since the epoch of the mission.
    #[sub(1, ro, pdo)]
    pub day: u16,
    /// Milliseconds of day
    #[sub(2, ro, pdo)]
    pub ms: u32,
    /// Submilliseconds of ms
    ///
    /// Units of 2^-16 ms.
    #[sub(3, ro, pdo)]
    pub submilliseconds: u16,
}

impl TryFrom<UtcSet> for Utc {
    type Error = NoTime;

    fn try_from(value: UtcSet) -> Result<Utc, NoTime> {
        Utc::new(value.day, value.ms, value.submilliseconds).ok_or(NoTime)
    }
}

impl From<Utc> for UtcGet {
    fn from(time: Utc) -> UtcGet {
        UtcGet { day: time.day(), ms: time.ms(), submilliseconds: time.submilliseconds() }
    }
}

/// More milliseconds than a day has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoTime;

/// Error state, error counters and lost frames of a bus (ECSS 5.6.2).
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
    /// As the node has it.
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

/// The built-in self-test (ECSS 6.7c).
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
    /// Value of the progress: it runs.
    pub const RUNNING: u8 = 1;
    /// Value of the progress: no check failed.
    pub const PASSED: u8 = 2;
    /// Value of the progress: some check failed.
    pub const FAILED: u8 = 3;
}
