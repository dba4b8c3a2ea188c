//! Shared state of the engines of a wire, and their interface to controllers and observers.

use std::sync::Arc;

use crate::wire::controller::Controllers;
use crate::wire::controller::{ErrorKind, NodeIndex, Trace, WireEvent};
use crate::wire::encode::{INTERMISSION_BITS, encode};
use crate::wire::fault::Flip;
use crate::wire::fine::Fine;
use crate::wire::frame::WireFrame;
use crate::wire::mac::Transmission;
use crate::wire::node::Node;
use crate::wire::record::{Counters, Destruction, Observation};
use crate::wire::time::Time;
use crate::wire::waveform::Waveform;

/// Data for observers.
#[derive(Clone, Debug, Default)]
pub(in crate::wire) struct Observed {
    pub(in crate::wire) records: Vec<Observation>,
    /// Totals without the busy time.
    pub(in crate::wire) counters: Counters,
    pub(in crate::wire) busy: Fine,
}

/// The surroundings of a segment while it runs.
pub(in crate::wire) struct Stage<'a> {
    pub(in crate::wire) nodes: &'a mut [Node],
    pub(in crate::wire) controllers: &'a mut dyn Controllers,
    pub(in crate::wire) observed: &'a mut Observed,
    pub(in crate::wire) flips: &'a mut Vec<Flip>,
    /// Instant of the next fault.
    pub(in crate::wire) horizon: Fine,
    /// Undisturbed frames may be computed as a whole.
    pub(in crate::wire) fast: bool,
    /// Recorder of every bit, while a waveform is recorded.
    pub(in crate::wire) recorder: Option<&'a mut Waveform>,
    /// Index of the segment, for the records.
    pub(in crate::wire) segment: usize,
}

/// State of a segment's records.
#[derive(Clone, Debug, Default)]
pub(in crate::wire) struct Ledger {
    /// Instant up to which events have been reported and recorded. A replay does not report them again.
    pub(in crate::wire) told_until: Option<Fine>,
    start: Fine,
    /// Transmissions since then that have been recorded; there may be two after a cut was repaired.
    recorded: Vec<Recorded>,
    deliveries: Vec<(NodeIndex, Time, WireFrame)>,
    /// Start of the present busy time.
    busy_from: Option<Fine>,
}

/// A transmission that has been recorded.
#[derive(Clone, Debug)]
struct Recorded {
    sof: Fine,
    frame: WireFrame,
    transmitter: NodeIndex,
}

impl Ledger {
    pub(in crate::wire) fn is_news(&self, at: Fine) -> bool {
        self.told_until.is_none_or(|told| at > told)
    }

    /// Records the start of a frame at `at`; `bit` is its bit time.
    pub(in crate::wire) fn start(&mut self, at: Fine, bit: Fine, observed: &mut Observed) {
        if self.is_news(at) && (at > self.start + bit + bit || !self.recorded.is_empty()) {
            self.calm(at, observed);
            self.start = at;
            self.recorded.clear();
        }
    }

    /// Records `own` of `transmitter`. Returns `false` if it was recorded already: itself, the same frame of a
    /// contender, or with `any` another frame that began at the same time.
    fn record(&mut self, own: &Transmission, transmitter: NodeIndex, any: bool) -> bool {
        let same = |other: &Recorded| {
            other.sof.0.abs_diff(own.start.0) <= own.bit.times(2).0 && (any || other.frame == own.frame)
        };
        let is_new = !self.recorded.iter().any(same);
        if is_new {
            self.recorded.push(Recorded { sof: own.start, frame: own.frame, transmitter });
        }
        is_new
    }

    /// Records that `node` received `frame`.
    fn received(&mut self, at: Time, node: NodeIndex, frame: WireFrame, observed: &mut Observed) {
        match self.recorded.iter().find(|recorded| recorded.frame == frame) {
            Some(&Recorded { sof, transmitter, .. }) => {
                let start = sof.floor();
                observed.records.push(Observation::ReceivedLate { at, node, frame, transmitter, start });
            }
            None => self.deliveries.push((node, at, frame)),
        }
    }

    /// Ends the busy time at `at`.
    pub(in crate::wire) fn calm(&mut self, at: Fine, observed: &mut Observed) {
        if let Some(from) = self.busy_from.take() {
            observed.busy = observed.busy + Fine(at.0.saturating_sub(from.0));
        }
        for (node, at, frame) in self.deliveries.drain(..) {
            // Without any record the transmitter is on the other side of a cut.
            if !self.recorded.is_empty() && !self.recorded.iter().any(|sent| sent.frame == frame) {
                observed.records.push(Observation::Misread { at, node, frame });
            }
        }
    }
}

impl Stage<'_> {
    /// Reports an `event` at `at` to `node`, and records it for observers if relevant.
    pub(in crate::wire) fn tell(
        &mut self,
        ledger: &mut Ledger,
        at: Fine,
        node: NodeIndex,
        event: WireEvent,
        transmission: Option<&Transmission>,
    ) {
        if !ledger.is_news(at) {
            return;
        }
        let time = at.floor();
        if let Some(recorder) = &mut self.recorder {
            recorder.lanes[node].events.push((time, event));
        }
        match event {
            WireEvent::Received(frame) => ledger.received(time, node, frame, self.observed),
            WireEvent::Transmitted => self.completed(ledger, node, transmission),
            WireEvent::TransmitError(kind) => {
                self.error(time, node, kind, true);
                self.destroyed(ledger, at, node, transmission, Destruction::Error(kind));
            }
            WireEvent::ReceiveError(kind) => self.error(time, node, kind, false),
            _ => {}
        }
        let about_frame = matches!(
            event,
            WireEvent::Started
                | WireEvent::ArbitrationLost
                | WireEvent::Transmitted
                | WireEvent::TransmitError(_)
        );
        let babbled = match transmission {
            Some(own) => own.babbled,
            None => self.nodes[node].condition.babbles.is_some(),
        };
        if about_frame && babbled {
            return;
        }
        self.controllers.with(node, |controller| controller.on_wire(time, &event));
    }

    /// Handles the entry of `node` at `at` into an arbitration whose SOF was at `sof`.
    pub(in crate::wire) fn started(&mut self, ledger: &mut Ledger, at: Fine, sof: Fine, node: NodeIndex) {
        if !ledger.is_news(at) {
            return;
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.lanes[node].events.push((sof.floor(), WireEvent::Started));
        }
        if self.nodes[node].condition.babbles.is_none() {
            self.controllers.with(node, |controller| controller.on_wire(sof.floor(), &WireEvent::Started));
        }
    }

    fn error(&mut self, at: Time, node: NodeIndex, kind: ErrorKind, transmitting: bool) {
        self.observed.records.push(Observation::Error { at, node, kind, transmitting });
    }

    fn completed(&mut self, ledger: &mut Ledger, node: NodeIndex, transmission: Option<&Transmission>) {
        let Some(own) = transmission else { return };
        if !ledger.record(own, node, false) {
            return;
        }
        let bit = own.bit;
        let bits = own.encoded.bits().len() as u64;
        let trace = Trace {
            frame: own.frame,
            transmitter: node,
            start: own.start.floor(),
            end: (own.start + bit.times(bits)).nearest(),
            bit_time: bit.nearest(),
        };
        self.observed.counters.completed += 1;
        self.observed.busy = self.observed.busy + bit.times(bits + INTERMISSION_BITS);
        let receivers = take_deliveries(ledger, own.frame);
        self.observed.records.push(Observation::Completed { trace, receivers, segment: self.segment });
    }

    /// Records a transmission that ended without success.
    pub(in crate::wire) fn destroyed(
        &mut self,
        ledger: &mut Ledger,
        at: Fine,
        node: NodeIndex,
        transmission: Option<&Transmission>,
        cause: Destruction,
    ) {
        let Some(own) = transmission else { return };
        let is_news = cause == Destruction::TransmitterLeft || ledger.is_news(at);
        if !is_news || !ledger.record(own, node, true) {
            return;
        }
        ledger.busy_from.get_or_insert(own.start);
        if cause == Destruction::Error(ErrorKind::Ack) {
            self.observed.counters.ack_errors += 1;
        } else {
            self.observed.counters.destroyed += 1;
        }
        let receivers = take_deliveries(ledger, own.frame);
        self.observed.records.push(Observation::Destroyed {
            frame: own.frame,
            transmitter: node,
            start: own.start.floor(),
            at: at.floor(),
            cause,
            receivers,
            segment: self.segment,
        });
    }

    /// Returns when `node` would start a frame if its line stayed recessive from `cursor` on.
    pub(in crate::wire) fn start_of(&mut self, node: NodeIndex, cursor: Fine) -> Option<Fine> {
        let mac = &self.nodes[node].mac;
        let idle_from = mac.idle_from()?;
        if mac.is_silent() {
            return None;
        }
        if self.nodes[node].condition.babbles.is_some() {
            return Some(idle_from.max(cursor));
        }
        let request = self.request_at(node)?;
        Some(request.max(idle_from).max(cursor)).filter(|&at| at != Fine::NEVER)
    }

    /// Earliest instant from which a frame of `node` waits for transmission.
    pub(in crate::wire) fn request_at(&mut self, node: NodeIndex) -> Option<Fine> {
        self.controllers.with(node, |controller| controller.request_at()).map(Fine::from_time)
    }

    /// The frame with which `node` enters an arbitration at `at`.
    pub(in crate::wire) fn contend(&mut self, node: NodeIndex, at: Fine) -> Option<Transmission> {
        let attachment = self.nodes[node].mac.attachment.filter(|attachment| !attachment.silent)?;
        let frame = match self.nodes[node].condition.babbles {
            Some(frame) => frame,
            None => self.controllers.with(node, |controller| controller.contend(at.floor()))?,
        };
        let bit = attachment.timing.bit();
        let babbled = self.nodes[node].condition.babbles.is_some();
        Some(Transmission { frame, encoded: Arc::new(encode(&frame)), start: at, bit, babbled })
    }
}

/// Takes the nodes that received `frame`.
fn take_deliveries(ledger: &mut Ledger, frame: WireFrame) -> Vec<(NodeIndex, Time)> {
    let received = ledger.deliveries.extract_if(.., |&mut (_, _, got)| got == frame);
    received.map(|(node, at, _)| (node, at)).collect()
}
