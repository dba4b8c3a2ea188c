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
    /// It is given up then.
    #[canonical(due)]
    pub expires: Instant,
}

/// What a node wants sent, in order.
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

    /// Gives up all frames of a bus that is left.
    pub fn abandon(&mut self, bus: Bus) {
        self.frames.retain(|waiting| waiting.bus != bus);
    }

    /// Gives up everything, at a reset.
    pub fn clear(&mut self) {
        self.frames.clear();
    }

    /// The frame of `bus` with the lowest COB-ID, the first of several.
    pub fn next(&self, bus: Bus) -> Option<Frame> {
        let frames = self.frames.iter().filter(|waiting| waiting.bus == bus);
        frames.map(|waiting| waiting.frame).min_by_key(Frame::id)
    }

    /// This frame was acknowledged.
    pub fn acknowledge(&mut self, bus: Bus, frame: &Frame) {
        if let Some(place) = self.frames.iter().position(|sent| sent.bus == bus && sent.frame == *frame) {
            self.frames.remove(place);
        }
    }

    /// The next frame whose lifetime is over.
    pub fn take_expired(&mut self, now: Instant) -> Option<Waiting> {
        let place = self.frames.iter().position(|waiting| waiting.expires <= now)?;
        Some(self.frames.remove(place))
    }

    /// When the next lifetime is over.
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
    /// Power-on, or the reset of its chip.
    fn start(&mut self, now: Instant);
    /// Loses what does not outlive power.
    fn power_off(&mut self);
    /// Does what is due.
    fn poll(&mut self, now: Instant);
    /// A frame of another node ended now.
    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// A frame of this node was acknowledged.
    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// The lifetime of a frame of this node ended.
    fn on_expired(&mut self, bus: Bus, frame: &Frame, now: Instant);
    /// Its receiver lost a frame of this bus.
    fn on_overrun(&mut self, bus: Bus, now: Instant);
    /// Its controller is error passive for want of acknowledgements on this bus, or is so no more.
    fn on_unacknowledged(&mut self, bus: Bus, unacknowledged: bool, now: Instant);
    /// When to poll.
    fn deadline(&self) -> Option<Instant>;
    /// Whether its controller takes part in this bus.
    fn is_joined(&self, bus: Bus) -> bool;
    /// Whether it only listens there: it acknowledges nothing.
    fn is_silent(&self) -> bool;
    /// The bus that it considers active.
    fn active(&self) -> Bus;
    /// NMT state.
    fn state(&self) -> NmtState;
    /// What it wants sent.
    fn outgoing(&mut self) -> &mut Outgoing;
    /// What it wants sent.
    fn waiting(&self) -> &Outgoing;
}
