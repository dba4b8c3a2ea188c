//! Objects 2010h to 2013h: spacecraft time, set and read.

use crate::od::{Objects, Record, U24};
use crate::types::{Scet, Utc};

/// The time objects of every node (ECSS 7.1.2).
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct LocalScet {
    /// Local SCET set
    #[object(0x2010, record)]
    pub scet_set: ScetSet,
    /// Local SCET get
    #[object(0x2011, record)]
    pub scet_get: ScetGet,
}

pub(super) const SCET_SET: u16 = LocalScet::SCET_SET.index();

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
    /// Microseconds of the millisecond, 0 to 999.
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
    /// Microseconds of the millisecond, 0 to 999.
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
        UtcGet { day: time.day(), ms: time.ms(), submilliseconds: time.micros() }
    }
}

/// More milliseconds than a day has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoTime;
