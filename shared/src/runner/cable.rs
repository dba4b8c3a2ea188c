//! Measures the delay of the cable between the master and a slave, in both directions.
//!
//! A slave sets its clock by SYNCs of the master. So its clock is late by the delay of the cable, less the
//! correction in 2014h of the slave. By that clock, the end of a heartbeat of the slave is early by one delay. The
//! master receives the heartbeat one delay later. The delays of the receivers cancel, because each end stamps its
//! own frames by its own receiver.

use super::left::MEASUREMENT;
use super::{Handle, Platform};
use crate::node::{Device, Master, NetworkObjects, Ranging};
use crate::redundancy::MasterBoards;
use crate::sdo::Error;
use crate::time::{ClockObjects, TimeCorrection};
use crate::types::{Bus, Duration, NodeId};

/// Heartbeats that are measured.
const SAMPLES: u32 = 16;
/// Period at which the master checks for a heartbeat.
const LOOK: Duration = Duration::from_millis(5);
/// Looks in all: 16 heartbeats, one each second.
const LOOKS: u32 = 3_200;
/// Two times that differ by more are of two heartbeats: 1 ms, in units of 2^-32 s.
const SAME: u64 = (1 << 32) / 1_000;

/// Result of the measurement of a cable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cable {
    /// Bus whose cable was measured.
    pub bus: Bus,
    /// Delay from the connector of the master to that of the slave, in nanoseconds.
    pub delay_ns: i32,
}

impl<B: Platform, D: Device, M: MasterBoards> Handle<B, Master<D, M>> {
    /// Measures the cable to a slave on the active bus by 16 of its heartbeats. Its clock has to follow the SYNCs
    /// of this master, and both have to stamp in hardware. For 2014h of the slave add the delay of its receiver,
    /// which this method does not measure.
    ///
    /// # Errors
    /// Those of the SDO client, which reads 2014h and 2016h. [`Error::BusChanged`]. [`Error::Timeout`] if there is
    /// no heartbeat that both have stamped.
    ///
    /// # Cancel safety
    /// A dropped future ends the measurement and aborts a transfer that is running. Call it again to measure from
    /// the start.
    pub async fn measure_cable(&self, node: NodeId) -> Result<Cable, Error> {
        self.range(node.get())?;
        let _ends = Ends(self);
        self.cable(node).await
    }

    fn range(&self, node: u8) -> Result<(), Error> {
        let at = NetworkObjects::RANGING.field(Ranging::NODE).address();
        self.write(at, &[node]).map_err(Error::Abort)
    }

    async fn cable(&self, node: NodeId) -> Result<Cable, Error> {
        let bus = self.with(|master, _| master.ranged().bus);
        let of_bus = match bus {
            Bus::Nominal => TimeCorrection::NOMINAL,
            Bus::Redundant => TimeCorrection::REDUNDANT,
        };
        let mut correction = [0; 4];
        self.sdo().read(node, ClockObjects::CORRECTION.field(of_bus).address(), &mut correction).await?;
        let (mut last, mut samples, mut sum) = (0, 0, 0_i64);
        for _ in 0..LOOKS {
            let now = self.now();
            self.wait_until(now + LOOK).await;
            let heard = self.with(|master, _| master.ranged().heard);
            if heard == last {
                continue;
            }
            last = heard;
            let mut sent = [0; 8];
            self.sdo().read(node, ClockObjects::HEARTBEAT_SENT.address(), &mut sent).await?;
            let difference = heard.wrapping_sub(u64::from_le_bytes(sent)) as i64;
            if difference.unsigned_abs() > SAME {
                continue;
            }
            sum += difference;
            samples += 1;
            if samples == SAMPLES {
                let ranged = self.with(|master, _| master.ranged());
                if ranged.bus != bus {
                    return Err(Error::BusChanged);
                }
                // The master's correction makes the time of a SYNC earlier, the slave's makes that of its clock later.
                let of_slave = TimeCorrection::known(i32::from_le_bytes(correction)).unwrap_or(0);
                let corrected = i64::from(of_slave) - i64::from(ranged.correction);
                let twice = nanoseconds(sum / i64::from(SAMPLES)) + corrected;
                return Ok(Cable { bus, delay_ns: (twice / 2) as i32 });
            }
        }
        Err(Error::Timeout)
    }
}

/// Ends a measurement: 2044h names no slave any more, also when its future is dropped.
struct Ends<'a, B: Platform, D: Device, M: MasterBoards>(&'a Handle<B, Master<D, M>>);

impl<B: Platform, D: Device, M: MasterBoards> Drop for Ends<'_, B, D, M> {
    fn drop(&mut self) {
        self.0.core.give_back(MEASUREMENT, |shared, _| shared.node.stop_ranging());
    }
}

/// Converts units of 2^-32 s.
fn nanoseconds(units: i64) -> i64 {
    (units * 1_000_000_000) >> 32
}
