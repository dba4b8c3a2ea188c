//! Producer of a slave's heartbeat that sends some heartbeats late.

use super::Producer;
use crate::nmt::CROSSING;
use crate::types::{Canonical, Duration, Frame, Instant, NmtState, NodeId};

/// Produces heartbeats of which some are late, so that two slaves with one Node-ID detect each other.
///
/// Two slaves with one Node-ID that boot together with equal clocks send equal heartbeats. Equal frames that start
/// in the same bit merge on the wire, and neither node hears the other. Therefore each node sends some of its
/// heartbeats late, by a *pattern* of 32 bits that is different for each chip. If only one of the two sends a
/// heartbeat late, it hears the other one and yields ([`ClashWatch`](crate::nmt::machine::ClashWatch)).
///
/// Each heartbeat takes the next bit of the pattern, and is late if the bit is set. The first heartbeat after a
/// boot-up message is on time, and so is an announced one.
///
/// # Delay
///
/// The delay is fixed: four of the longest frames at the bit rate of the network, at most a tenth of the heartbeat
/// period. Two equal frames start together if both wait for the end of the same frame. The heartbeat on time waits
/// for at most one frame (135 bits) and takes 65 bits. So it is heard long before the delay of 540 bits has passed.
/// A burst of frames with higher priority may fill the whole delay. Then both heartbeats wait for its end, and the
/// pattern decides again in the next period.
///
/// Two patterns differ in at least one of 32 bits, on average in half of them. So one of the two nodes yields after
/// two periods on average, after 33 at most. The grid of the period does not move, so the mean period is exact.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct Staggered {
    producer: Producer,
    /// Bit 0 belongs to the last heartbeat, bit 1 to the next one.
    pattern: u32,
    /// Delay of a late heartbeat when the period is long, microseconds. 54,000 at 10 kbit/s.
    longest: u16,
    /// Delay of the next heartbeat, microseconds: it is in the deadline of the producer.
    delay: u16,
}

impl Staggered {
    /// Makes a producer that sends no heartbeat late until [`Staggered::set_pattern`]. `longest`: delay of a late
    /// heartbeat, at most a tenth of the period.
    pub const fn new(node: NodeId, period: Duration, longest: Duration) -> Self {
        let us = longest.as_micros();
        let longest = if us < u16::MAX as u64 { us as u16 } else { u16::MAX };
        Staggered { producer: Producer::new(node, period), pattern: 0, longest, delay: 0 }
    }

    /// Sets the pattern of late heartbeats. The heartbeat after heartbeat `n` is late if bit `n` is set. Bit 0
    /// follows bit 31.
    pub const fn set_pattern(&mut self, pattern: u32) {
        self.pattern = pattern;
    }

    /// Sets the Node-ID, as [`Producer::set_node`].
    pub(crate) const fn set_node(&mut self, node: NodeId) {
        self.producer.set_node(node);
    }

    /// Makes the next heartbeat due at once, as [`Producer::announce`].
    #[inline(never)] // of five callers: row `size.pyboard-v11.slave.flash`
    pub fn announce(&mut self, now: Instant) {
        self.delay = 0;
        self.producer.announce(now);
    }

    /// Makes the next heartbeat due a period from `now`, as [`Producer::restart`].
    pub fn restart(&mut self, now: Instant) {
        self.delay = 0;
        self.producer.restart(now);
    }

    /// Stops the heartbeats, as [`Producer::stop`].
    pub fn stop(&mut self) {
        self.producer.stop();
    }

    /// Takes a new period of at most 4,294 s, as [`Producer::set_period`].
    pub fn set_period(&mut self, period: Duration, now: Instant) {
        self.delay = 0;
        self.producer.set_period(period, now);
    }

    /// Returns the period, zero for none.
    pub const fn period(&self) -> Duration {
        self.producer.period()
    }

    /// Returns the heartbeat when it is due. Call [`Staggered::arrange_next`] afterwards.
    pub fn poll(&mut self, now: Instant, state: NmtState) -> Option<Frame> {
        self.producer.poll(now, state)
    }

    /// Delays the next heartbeat if it is a late one. The grid of the period does not move.
    pub fn arrange_next(&mut self) {
        self.pattern = self.pattern.rotate_right(1);
        let tenth = self.producer.period().as_micros() as u32 / 10;
        let delay = self.pattern % 2 * u32::from(self.longest).min(tenth);
        self.producer.shift(delay as i32 - i32::from(self.delay));
        self.delay = delay as u16;
    }

    /// Returns whether the heartbeats are on schedule, as [`Producer::is_on_schedule`].
    pub fn is_on_schedule(&self, now: Instant) -> bool {
        self.producer.is_on_schedule(now)
    }

    /// Returns when the next heartbeat is due, on time or late.
    pub fn deadline(&self) -> Option<Instant> {
        self.producer.deadline()
    }

    /// Returns whether a heartbeat was due before `at` and waits because it is a late one.
    pub fn is_held_back(&self, at: Instant) -> bool {
        let due = self.deadline().unwrap_or(Instant::NEVER);
        // In 32 bits: the period is shorter.
        (due.as_micros() as u32).wrapping_sub(at.as_micros() as u32) < self.delay.into()
    }

    /// Returns whether a heartbeat was due on time just before `at`: it may be late, or wait for the bus.
    pub fn is_just_due(&self, at: Instant) -> bool {
        let due = self.deadline().unwrap_or(Instant::NEVER);
        let last = (due.as_micros() as u32)
            .wrapping_sub(self.delay.into())
            .wrapping_sub(self.period().as_micros() as u32);
        (at.as_micros() as u32).wrapping_sub(last) < u32::from(self.longest) + CROSSING.as_micros() as u32
    }
}
