//! The delay of the cable between the master and a slave, measured both ways.
//!
//! A slave sets its clock by SYNCs of the master: it is late by the cable, less what 2014h of the slave corrects. So the end of a
//! heartbeat of this slave is one cable early by its clock, and the master receives it one cable later. What receivers delay
//! falls out, as each end stamps its own frames by its own receiver.

use super::Handle;
use super::resources::Platform;
use crate::node::{Device, Master, MasterBoards, NetworkObjects, Ranging};
use crate::sdo::Error;
use crate::time::{ClockObjects, TimeCorrection};
use crate::types::{Bus, Duration, NodeId};

/// Heartbeats that are measured.
const SAMPLES: u32 = 16;
/// How often the master looks for a heartbeat.
const LOOK: Duration = Duration::from_millis(5);
/// Looks in all: 16 heartbeats, one each second.
const LOOKS: u32 = 3_200;
/// Two times that differ by more are of two heartbeats: 1 ms, in units of 2^-32 s.
const SAME: u64 = (1 << 32) / 1_000;

/// A cable that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cable {
    /// The bus.
    pub bus: Bus,
    /// From the connector of the master to that of the slave, nanoseconds.
    pub delay_ns: i32,
}

impl<B: Platform, D: Device, M: MasterBoards> Handle<B, Master<D, M>> {
    /// Measures the cable to a slave on the active bus, by 16 of its heartbeats. Its clock follows SYNCs of this master, and both
    /// stamp in hardware. For 2014h of the slave add the delay of its receiver, which cannot be measured so.
    ///
    /// # Errors
    /// Those of the SDO client, which reads 2014h and 2016h; [`Error::BusChanged`]; [`Error::Timeout`] when there is no
    /// heartbeat that both have stamped.
    ///
    /// # Panics
    /// When its future is dropped from within [`Handle::with`].
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
        // The object takes a zero always.
        let _ = self.0.range(0);
    }
}

/// Of units of 2^-32 s.
fn nanoseconds(units: i64) -> i64 {
    (units * 1_000_000_000) >> 32
}
