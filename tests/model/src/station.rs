//! A node on its two buses, as the wire sees it.

use ecss_can::types::{Bus, Canonical, Frame, Instant, NmtState};

use crate::profile::LIFETIME;

/// A frame that waits for an acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct Waiting {
    /// Its bus.
    pub bus: Bus,
    /// The frame.
    pub frame: Frame,
    /// End of its lifetime.
    #[canonical(due)]
    pub expires: Instant,
}

/// Frames that a node wants to send, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Outgoing {
    frames: Vec<Waiting>,
}

impl Outgoing {
    /// Sends a frame within the lifetime of heartbeats.
    pub fn send(&mut self, bus: Bus, frame: Frame, now: Instant) {
        self.send_until(bus, frame, now + LIFETIME);
    }

    /// Sends a frame before `expires`.
    pub fn send_until(&mut self, bus: Bus, frame: Frame, expires: Instant) {
        self.frames.push(Waiting { bus, frame, expires });
    }

    /// Drops all frames of a bus that is left.
    pub fn abandon(&mut self, bus: Bus) {
        self.frames.retain(|waiting| waiting.bus != bus);
    }

    /// Drops all frames at a reset.
    pub fn clear(&mut self) {
        self.frames.clear();
    }

    /// Returns the frame of `bus` with the lowest COB-ID, the first of several.
    pub fn next(&self, bus: Bus) -> Option<Frame> {
        let frames = self.frames.iter().filter(|waiting| waiting.bus == bus);
        frames.map(|waiting| waiting.frame).min_by_key(Frame::id)
    }

    /// Removes an acknowledged frame.
    pub fn acknowledge(&mut self, bus: Bus, frame: &Frame) {
        if let Some(place) = self.frames.iter().position(|sent| sent.bus == bus && sent.frame == *frame) {
            self.frames.remove(place);
        }
    }

    /// Removes and returns an expired frame.
    pub fn take_expired(&mut self, now: Instant) -> Option<Waiting> {
        let place = self.frames.iter().position(|waiting| waiting.expires <= now)?;
        Some(self.frames.remove(place))
    }

    /// Returns the end of the next lifetime.
    pub fn deadline(&self) -> Option<Instant> {
        self.frames.iter().map(|waiting| waiting.expires).min()
    }
}

impl Canonical for Outgoing {
    type Context = ();

    fn canonical(&mut self, now: Instant, (): &()) {
        self.frames.iter_mut().for_each(|waiting| waiting.canonical(now, &()));
    }
}

/// A node, sans-IO.
pub trait Station {
    /// Starts at power-on or after a reset of its chip.
    fn start(&mut self, now: Instant);
    /// Loses the state that does not survive a loss of power.
    fn power_off(&mut self);
    /// Does the due actions.
    fn poll(&mut self, now: Instant);
    /// Handles a frame of another node that ended now.
    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// Handles the acknowledgement of a frame of this node.
    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// Handles the end of the lifetime of a frame of this node.
    fn on_expired(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// Handles a lost frame of this bus.
    fn on_overrun(&mut self, bus: Bus, now: Instant);
    /// Handles the start or end of error passive by missing acknowledgements on this bus.
    fn on_unacknowledged(&mut self, bus: Bus, unacknowledged: bool, now: Instant);
    /// Returns the next time to poll.
    fn deadline(&self) -> Option<Instant>;
    /// Returns whether its controller takes part in this bus.
    fn is_joined(&self, bus: Bus) -> bool;
    /// Returns whether it only listens and acknowledges no frame.
    fn is_silent(&self) -> bool;
    /// Returns the bus that it considers active.
    fn active(&self) -> Bus;
    /// Returns its NMT state.
    fn state(&self) -> NmtState;
    /// Returns the frames to be sent, for changes.
    fn outgoing(&mut self) -> &mut Outgoing;
    /// Returns the frames to be sent.
    fn waiting(&self) -> &Outgoing;
}
