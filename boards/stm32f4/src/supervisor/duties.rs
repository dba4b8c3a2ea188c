//! Duties: work that has to be done again within a time.
//!
//! A *duty* counts ticks of the supervisor down, and starts again when it is done. At zero it is late.

use core::sync::atomic::{AtomicU32, Ordering};

#[cfg(feature = "full")]
use ecss_can::types::Duration;

/// Number of duties of applications.
#[cfg(feature = "full")]
const DUTIES: usize = 4;

/// The duty of the node: its heartbeats, SYNC and time are on schedule. It is done in each turn of the node's task of
/// deadlines, which the supervisor wakes within 1.6 s, because it asks at most 16 tasks in turn.
pub static NODE: Place = Place::new(u32::from_le_bytes(*b"node"), 20);

#[cfg(feature = "full")]
static PLACES: [Place; DUTIES] = [const { Place::new(0, 0) }; DUTIES];

/// Place of a duty.
pub struct Place {
    /// First characters of its name; zero if the place is free.
    name: AtomicU32,
    /// Ticks within which it has to be done again.
    within: AtomicU32,
    /// Ticks left; zero while the duty rests.
    left: AtomicU32,
}

impl Place {
    const fn new(name: u32, within: u32) -> Place {
        Place { name: AtomicU32::new(name), within: AtomicU32::new(within), left: AtomicU32::new(0) }
    }

    /// Notes that the duty was done.
    pub fn done(&self) {
        self.left.store(self.within.load(Ordering::Relaxed), Ordering::Relaxed);
    }

    /// Counts a tick. Returns the name when the duty is late.
    fn late(&self) -> Option<u32> {
        let left = self.left.load(Ordering::Relaxed);
        self.left.store(left.saturating_sub(1), Ordering::Relaxed);
        (left == 1).then(|| self.name.load(Ordering::Relaxed))
    }
}

/// Counts a tick. Returns the name of a duty that is late.
pub fn late() -> Option<u32> {
    let late = NODE.late();
    #[cfg(feature = "full")]
    let late = PLACES.iter().fold(late, |late, place| place.late().or(late));
    late
}

/// Duty of an application, from [`supervise`]. It rests until it is done for the first time, and when it is dropped.
#[cfg(feature = "full")]
#[derive(Debug)]
pub struct Duty(usize);

/// Supervises periodic work: if it is not done again `within` this time, the chip is reset, and the record of the reset has
/// the cause "late task" and the first four characters of `name`. The time is counted in ticks of 99.9 ms; it is at least
/// one and at most 4,294 s.
///
/// At most 4 duties are supervised. A further one has no effect.
///
/// ```ignore (a task of an image)
/// let duty = supervise("samples", Duration::from_millis(300));
/// loop {
///     timer.next().await;
///     sample();
///     duty.done();
/// }
/// ```
#[cfg(feature = "full")]
pub fn supervise(name: &'static str, within: Duration) -> Duty {
    let us = within.as_micros().min(u32::MAX.into()) as u32;
    let free = PLACES.iter().position(|place| place.name.load(Ordering::Relaxed) == 0);
    let index = free.unwrap_or(DUTIES);
    if let Some(place) = PLACES.get(index) {
        place.name.store(super::first_characters(name), Ordering::Relaxed);
        // One more: the first tick comes at once. A tick has 99,864 µs.
        place.within.store(us / 99_864 + 2, Ordering::Relaxed);
    }
    Duty(index)
}

#[cfg(feature = "full")]
impl Duty {
    /// Notes that the work was done. It has to be done again.
    pub fn done(&self) {
        if let Some(place) = PLACES.get(self.0) {
            place.done();
        }
    }

    /// Notes that there is nothing to do until the work is done the next time.
    pub fn rest(&self) {
        if let Some(place) = PLACES.get(self.0) {
            place.left.store(0, Ordering::Relaxed);
        }
    }
}

#[cfg(feature = "full")]
impl Drop for Duty {
    fn drop(&mut self) {
        self.rest();
        if let Some(place) = PLACES.get(self.0) {
            place.name.store(0, Ordering::Relaxed);
        }
    }
}
