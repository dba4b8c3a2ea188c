//! Commands that must not be executed twice: a sequence byte, and a filter of repeats.

use crate::types::{Duration, Instant};

/// Time after the lifetime in which a frame may still arrive: it was on the wire, or a task of the consumer takes it
/// late.
const SLACK: Duration = Duration::from_millis(5);

/// Numbers the commands of one producer to one consumer under one COB-ID.
///
/// CAN delivers a frame *at least* once. A transmitter that sees an error in the last bit of EOF repeats a frame
/// that its receivers have already accepted (ISO 11898-1, 10.7). A repeated heartbeat, SYNC or telemetry does no
/// harm. A repeated command may. Therefore:
///
/// - The producer keeps a `Sequence` for each consumer and COB-ID, and puts its next number into each new command.
/// - The consumer keeps a [`RepeatFilter`] for each COB-ID. A repeat has the sequence and the bytes of the last
///   command. It arrives, on either bus, within the lifetime of that command. The filter drops and counts it.
///
/// ```
/// use async_canopen::pdo::{RepeatFilter, Sequence};
/// use async_canopen::types::{Duration, Instant};
///
/// let lifetime = Duration::from_millis(40);
/// let mut sequence = Sequence::new(Instant::ZERO, lifetime);
/// let now = sequence.ready_at();
/// let command = [0x12, 0x34, sequence.step(now).unwrap()];
///
/// let mut filter = RepeatFilter::new(lifetime);
/// assert!(filter.accept(command, now)); // execute it
/// assert!(!filter.accept(command, now + Duration::from_millis(1))); // a repeat
/// assert_eq!(filter.repeats(), 1);
/// ```
///
/// Only the last command is compared: frames of one COB-ID leave a node in order, and frames for a bus that was
/// left are aborted. So 256 numbers are enough at any rate. A producer that starts, after a reset or in place of
/// another one, begins at zero. It does not know which commands the producer before it sent. It therefore sends no
/// command until the lifetime of every such command has ended. So no consumer takes one of its commands for a
/// repeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sequence {
    next: u8,
    ready: Instant,
}

impl Sequence {
    /// Makes a sequence that begins at zero. `start`: reset or power-on of the producer, or the instant of its
    /// takeover. `lifetime`: time for which a command may wait for its bus.
    pub fn new(start: Instant, lifetime: Duration) -> Sequence {
        Sequence { next: 0, ready: start + Self::delay(lifetime) }
    }

    /// Returns the time from the start to the first command: the lifetime and 10 ms.
    pub const fn delay(lifetime: Duration) -> Duration {
        Duration::from_micros(lifetime.as_micros().saturating_add(2 * SLACK.as_micros()))
    }

    /// Brings the instant of the first command back if it is later than that of a sequence that starts now: a bit of it
    /// flipped.
    pub fn confine(&mut self, now: Instant, lifetime: Duration) {
        self.ready.confine(now + Self::delay(lifetime));
    }

    /// Returns the instant of the first command: the lifetime and 10 ms after the start.
    pub const fn ready_at(&self) -> Instant {
        self.ready
    }

    /// Returns the number of a new command: 0 to 255, then 0 again. `None` before [`Sequence::ready_at`]: a
    /// consumer might take the command for a repeat of a command of the producer before.
    pub fn step(&mut self, now: Instant) -> Option<u8> {
        if now < self.ready {
            return None;
        }
        let number = self.next;
        self.next = number.wrapping_add(1);
        Some(number)
    }
}

/// Separates new commands from repeats, under one COB-ID. `C` is a command with its sequence and all of its
/// bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RepeatFilter<C> {
    lifetime: Duration,
    last: Option<(C, Instant)>,
    repeats: u32,
}

impl<C: PartialEq> RepeatFilter<C> {
    /// Makes a filter that received no command yet. `lifetime`: the same as that of the producer.
    pub const fn new(lifetime: Duration) -> RepeatFilter<C> {
        RepeatFilter { lifetime, last: None, repeats: 0 }
    }

    /// Returns whether a command that was received at `at`, on either bus, is a new one: execute it. A repeat is
    /// counted.
    #[must_use]
    pub fn accept(&mut self, command: C, at: Instant) -> bool {
        if let Some((last, first_at)) = &self.last
            && *last == command
            && at.since(*first_at) <= self.lifetime + SLACK
        {
            self.repeats = self.repeats.saturating_add(1);
            return false;
        }
        self.last = Some((command, at));
        true
    }

    /// Returns the number of repeats since the start or [`RepeatFilter::reset_count`]. It stays at its maximum.
    pub const fn repeats(&self) -> u32 {
        self.repeats
    }

    /// Sets the count to zero. The last command stays known.
    pub const fn reset_count(&mut self) {
        self.repeats = 0;
    }
}
