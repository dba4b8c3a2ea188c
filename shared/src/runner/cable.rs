//! Measures the delay of the cable between the master and a slave, in both directions.
//!
//! A slave sets its clock by SYNCs of the master. So its clock is late by the delay of the cable, less the
//! correction in 2014h of the slave. By that clock, the end of a heartbeat of the slave is early by one delay. The
//! master receives the heartbeat one delay later. The delays of the receivers cancel, because each end stamps its
//! own frames by its own receiver.

use super::extend::{AtEnd, WholeNode};
use super::{Handle, Platform};
use crate::node::{Master, NetworkObjects, Ranging, SpacecraftDevice};
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

/// Measurement of a cable by a master.
pub(super) struct Measurement<B: Platform, D: SpacecraftDevice, M: MasterBoards>(
    pub(super) Handle<B, Master<D, M>>,
);

impl<B: Platform, D: SpacecraftDevice, M: MasterBoards> Measurement<B, D, M> {
    pub(super) async fn run(self, node: NodeId) -> Result<Cable, Error> {
        self.range(node.get())?;
        // 2044h names no slave any more afterwards, also when this future is dropped.
        let _end = AtEnd::new(self.0, Master::stop_ranging);
        self.cable(node).await
    }

    fn range(&self, node: u8) -> Result<(), Error> {
        let at = NetworkObjects::RANGING.field(Ranging::NODE).address();
        self.0.write(at, &[node]).map_err(Error::Abort)
    }

    async fn cable(&self, node: NodeId) -> Result<Cable, Error> {
        let (bus, _) = self.0.inspect(Master::active_correction);
        let of_bus = match bus {
            Bus::Nominal => TimeCorrection::NOMINAL,
            Bus::Redundant => TimeCorrection::REDUNDANT,
        };
        let slave = self.0.sdo(node);
        let correction = slave.read(ClockObjects::CORRECTION.field(of_bus)).await?;
        let (mut last, mut samples, mut sum) = (0, 0, 0_i64);
        for _ in 0..LOOKS {
            let now = self.0.now();
            self.0.wait_until(now + LOOK).await;
            let heard = self.0.inspect(|master| master.objects().application.network.ranging.heard);
            if heard == last {
                continue;
            }
            last = heard;
            let sent = slave.read(ClockObjects::HEARTBEAT_SENT).await?;
            let difference = heard.wrapping_sub(sent) as i64;
            if difference.unsigned_abs() > SAME {
                continue;
            }
            sum += difference;
            samples += 1;
            if samples == SAMPLES {
                let (active, of_master) = self.0.inspect(Master::active_correction);
                if active != bus {
                    return Err(Error::BusChanged);
                }
                // The master's correction makes the time of a SYNC earlier, the slave's makes that of its clock later.
                let of_slave = TimeCorrection::known(correction).unwrap_or(0);
                let corrected = i64::from(of_slave) - i64::from(of_master);
                let twice = nanoseconds(sum / i64::from(SAMPLES)) + corrected;
                return Ok(Cable { bus, delay_ns: (twice / 2) as i32 });
            }
        }
        Err(Error::Timeout)
    }
}

/// Converts units of 2^-32 s.
fn nanoseconds(units: i64) -> i64 {
    (units * 1_000_000_000) >> 32
}
