//! The axis of a waveform: bit times and microseconds.

use can_wire::controller::WireEvent;
use can_wire::time::{TICKS_PER_US, Time};
use can_wire::waveform::Waveform;

use super::{EDGE, MARGIN};
use crate::picture::Picture;
use crate::scale::{Range, Scale};

/// Narrowest bit with digits and resynchronisations in numbers, in SVG units.
const DETAILED: f64 = 9.0;

/// Times as places, with marks at bit times from the first SOF.
pub(super) struct Ruler {
    scale: Scale,
    /// SOF of the first frame.
    zero: Time,
    /// End of the span.
    pub(super) to: Time,
    bit: Time,
    pub(super) is_detailed: bool,
}

impl Ruler {
    pub(super) fn new(waveform: &Waveform, bit_width: f64) -> Self {
        let starts = waveform.lanes.iter().flat_map(|lane| &lane.events);
        let starts = starts.filter(|(at, event)| *event == WireEvent::Started && *at >= waveform.from);
        let zero = starts.map(|&(at, _)| at).min().unwrap_or(waveform.from);
        let bit = waveform.lanes.iter().map(|lane| lane.bit_time).min().unwrap_or(Time::from_us(1));
        let [from, to] = [waveform.from, waveform.to].map(|at| bits(at, zero, bit));
        let is_detailed = bit_width >= DETAILED;
        let every = if is_detailed { 5.0 } else { 10.0 * (DETAILED / bit_width).ceil() };
        let ends = (MARGIN, MARGIN + (to - from) * bit_width);
        let scale = Scale::new(Range::Linear(from, to, every), ends);
        Ruler { scale, zero, to: waveform.to, bit, is_detailed }
    }

    /// Place of an instant; those outside the span stand at its border.
    pub(super) fn x(&self, at: Time) -> f64 {
        self.scale.place(bits(at, self.zero, self.bit))
    }

    pub(super) fn right(&self) -> f64 {
        self.x(self.to)
    }

    /// Grid and axis: bit times from the first SOF, and microseconds.
    pub(super) fn draw(&self, picture: &mut Picture, top: f64, bottom: f64) {
        picture.text("soft", EDGE, top - 20.0, "bit times");
        picture.text("soft", EDGE, top - 7.0, "µs");
        for (bit, x) in self.scale.marks() {
            picture.line(if bit == 0.0 { "grid zero" } else { "grid" }, (x, top - 4.0), (x, bottom));
            picture.text("soft middle", x, top - 20.0, &format!("{bit:.0}"));
            let us = (self.zero.0 as f64 + bit * self.bit.0 as f64) / TICKS_PER_US as f64;
            picture.text("soft middle", x, top - 7.0, &((us * 10.0).round() / 10.0).to_string());
        }
    }
}

/// Bit times from `zero` to an instant.
fn bits(at: Time, zero: Time, bit: Time) -> f64 {
    (at.0 as f64 - zero.0 as f64) / bit.0 as f64
}
