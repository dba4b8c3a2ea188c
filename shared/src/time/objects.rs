//! Objects 2010h to 2016h: spacecraft time, set and read; correction of stamps; quality of the clock.

use thiserror::Error;

use super::Quality;
use crate::od::{Objects, Record, U24};
use crate::types::{Bus, Scet, Utc};

/// Time objects of every node (ECSS 7.1.2).
#[doc(alias("2010h", "2011h", "SCET", "Local SCET"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct LocalScet {
    /// Local SCET set
    ///
    /// A write of one sub-index waits for the other, at most 10 s: the clock is set once, when the second one comes.
    #[object(0x2010, record)]
    pub scet_set: ScetSet,
    /// Local SCET get
    ///
    /// The sub-index that is read first takes a sample, of which the other one is read within 10 s.
    #[object(0x2011, record)]
    pub scet_get: ScetGet,
}

/// Objects of the correction of stamps and of the quality of the clock (2014h to 2016h).
#[doc(alias("2014h", "2015h", "2016h"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct ClockObjects {
    /// Time correction
    #[object(0x2014, record)]
    pub correction: TimeCorrection,
    /// Clock quality
    #[object(0x2015, record)]
    pub quality: ClockQuality,
    /// Time of the last heartbeat
    ///
    /// Local SCET at the end of a heartbeat that this node has sent, units of 2^-32 s: of the last one, while this
    /// is read at least with every eighth.
    #[object(0x2016, ro)]
    pub heartbeat_sent: u64,
}

impl LocalScet {
    /// Sub-indices of each of its records.
    pub(crate) const PARTS: u8 = 2;
}

/// Spacecraft elapsed time that a client or a PDO sets (record 0040h, ECSS 7.1.2).
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

/// Spacecraft elapsed time that a client or a PDO reads (record 0040h, ECSS 7.1.2).
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

/// Delays of the stamps of a node, and resolution of the received spacecraft time (2014h). A delay of more than 1 ms counts as not
/// known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct TimeCorrection {
    /// Delay on the nominal bus
    ///
    /// How much later than at the connector of the producer of SYNC this node sees it: cable and receiver,
    /// nanoseconds. At the producer: its receiver. 80000000h: not known, the error bound includes the longest of
    /// the network.
    #[sub(1, rw, default = i32::MIN)]
    pub nominal: i32,
    /// Delay on the redundant bus
    ///
    /// As on the nominal bus.
    #[sub(2, rw, default = i32::MIN)]
    pub redundant: i32,
    /// Bits of fine time that the time producer sends
    #[sub(3, rw, low = 0, high = 24, default = 24)]
    pub fine_bits: u8,
}

/// Longest delay that a correction may have, nanoseconds: that of 200 km of cable.
const LONGEST_DELAY: u32 = 1_000_000;

impl TimeCorrection {
    /// Returns the delay on a bus in nanoseconds, if it is known.
    pub const fn of(&self, bus: Bus) -> Option<i32> {
        Self::known(match bus {
            Bus::Nominal => self.nominal,
            Bus::Redundant => self.redundant,
        })
    }

    /// A delay as it stands in the object. One that no cable has is not known: a bit of it flipped.
    pub(crate) const fn known(delay: i32) -> Option<i32> {
        if delay.unsigned_abs() > LONGEST_DELAY { None } else { Some(delay) }
    }
}

/// Quality of the clock of a node (2015h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct ClockQuality {
    /// Bound of the error
    ///
    /// Against the spacecraft time, nanoseconds; FFFFFFFFh: none.
    #[sub(1, ro, pdo)]
    pub bound: u32,
    /// Source
    ///
    /// 0 never set, 1 command, 2 SYNC stamped in hardware, 3 SYNC stamped in its interrupt, 4 arrival of the time.
    #[sub(2, ro, pdo)]
    pub source: u8,
    /// Age
    ///
    /// Since the source sent a time last, milliseconds.
    #[sub(3, ro, pdo)]
    pub age: u32,
    /// Rate
    ///
    /// Rate of the spacecraft time against the oscillator of the node, parts per billion. Positive: the oscillator
    /// is slow.
    #[sub(4, ro, pdo)]
    pub rate: i32,
    /// Steps
    ///
    /// How often the clock was set instead of steered.
    #[sub(5, ro, pdo)]
    pub steps: u16,
    /// Late spacecraft times
    ///
    /// Those that came after the next SYNC, and were not used.
    #[sub(6, ro, pdo)]
    pub late: u16,
    /// Refused spacecraft times
    ///
    /// Those that did not agree with the others, and were not used.
    #[sub(7, ro, pdo)]
    pub refused: u16,
}

impl ClockQuality {
    pub(super) fn new(quality: &Quality, late: u16) -> Self {
        ClockQuality {
            bound: quality.bound_ns,
            source: quality.source as u8,
            age: quality.age_ms,
            rate: quality.rate_ppb,
            steps: quality.steps,
            late,
            refused: quality.refused,
        }
    }
}

/// Time objects of a device that keeps UTC (ECSS 7.1.3). The device has it as a field with `#[objects]` and
/// returns it from [`DeviceTime::utc`](crate::node::DeviceTime::utc).
#[doc(alias("2012h", "2013h", "UTC", "Local UTC"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct LocalUtc {
    /// Local UTC set
    ///
    /// A write of one sub-index waits for the others, at most 10 s: the clock is set once, when the last one comes.
    #[object(0x2012, record)]
    pub utc_set: UtcSet,
    /// Local UTC get
    ///
    /// The sub-index that is read first takes a sample, of which the others are read within 10 s.
    #[object(0x2013, record)]
    pub utc_get: UtcGet,
}

impl LocalUtc {
    /// Sub-indices of each of its records.
    pub(crate) const PARTS: u8 = 3;
}

/// Spacecraft UTC that a client or a PDO sets (record 0041h, ECSS 7.1.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x41)]
pub struct UtcSet {
    /// Day
    ///
    /// Since the epoch of the mission.
    #[sub(1, rww, pdo)]
    pub day: u16,
    /// Milliseconds of day
    #[sub(2, rww, pdo, low = 0, high = 86_400_999)]
    pub ms: u32,
    /// Submilliseconds of ms
    ///
    /// Microseconds of the millisecond, 0 to 999. A device without submilliseconds takes any value, and ignores it.
    #[sub(3, rww, pdo)]
    pub submilliseconds: u16,
}

/// Spacecraft UTC that a client or a PDO reads (record 0041h, ECSS 7.1.3).
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

/// Error: more milliseconds than a day has, or more microseconds than a millisecond.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("more milliseconds than a day has, or more microseconds than a millisecond")]
pub struct NoTime;
