//! Load of a bus: the share of a second of virtual time that completed frames take, from the start bit to the end of frame.
//!
//! Failed transmissions are counted separately. The pieces of a cut bus are separate buses: the busiest one counts, so
//! a load is 100 % at most.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;

const SECOND: Time = Time::from_ms(1_000);

/// Time after the end of a second within which its frames have ended: 160 bits at 10 kbit/s, and a step of the
/// spacecraft.
const LATEST: Time = Time::from_ms(20);

/// Shares of a second, each 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Share of completed frames.
    pub frames: f64,
    /// Share of transmissions that ended without success.
    pub failed: f64,
}

impl fmt::Display for Load {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.1} % (failed transmissions {:.1} %)", 100.0 * self.frames, 100.0 * self.failed)
    }
}

/// A transmission.
#[derive(Clone, Copy, Debug)]
struct Span {
    start: Time,
    end: Time,
    /// Piece of the cable, counted from the master's end.
    piece: usize,
    is_complete: bool,
}

/// Measures the load of one bus in each second of virtual time.
#[derive(Debug, Default)]
pub struct LoadMeter {
    /// Transmissions that may belong to a second that is not measured yet.
    spans: VecDeque<Span>,
    /// Seconds that are measured.
    seconds: u64,
    /// Load of the last measured second; `None` before the first one.
    pub last: Option<Load>,
    busiest: Load,
}

impl LoadMeter {
    /// Observes events of the bus, in chronological order.
    pub fn observe(&mut self, record: &Observation) {
        let span = match record {
            Observation::Completed { trace, segment, .. } => {
                Span { start: trace.start, end: trace.end, piece: *segment, is_complete: true }
            }
            Observation::Destroyed { start, at, segment, .. } => {
                Span { start: *start, end: *at, piece: *segment, is_complete: false }
            }
            _ => return,
        };
        self.spans.push_back(span);
    }

    /// Measures each second whose frames are all known at `now`.
    pub fn advance(&mut self, now: Time) {
        while Time(SECOND.0 * (self.seconds + 1)) + LATEST <= now {
            self.measure();
        }
    }

    /// Measures each second that has ended at `now`, the end of the flight.
    pub fn finish(&mut self, now: Time) {
        self.advance(now + LATEST);
    }

    /// The highest load of a second; `None` before the first one.
    pub fn busiest(&self) -> Option<Load> {
        self.last.map(|_| self.busiest)
    }

    /// Measures the next second.
    fn measure(&mut self) {
        let from = Time(SECOND.0 * self.seconds);
        let to = from + SECOND;
        let mut pieces: BTreeMap<(usize, bool), u64> = BTreeMap::new();
        for span in &self.spans {
            let part = span.end.min(to).since(span.start.max(from));
            *pieces.entry((span.piece, span.is_complete)).or_default() += part.0;
        }
        let highest = |complete: bool| {
            let parts = pieces.iter().filter(|((_, is_complete), _)| *is_complete == complete);
            // Two senders of one identifier can fail at the same time.
            parts.map(|(_, part)| *part).max().unwrap_or(0).min(SECOND.0) as f64 / SECOND.0 as f64
        };
        let load = Load { frames: highest(true), failed: highest(false) };
        if self.last.is_none() || load.frames > self.busiest.frames {
            self.busiest = load;
        }
        self.last = Some(load);
        self.seconds += 1;
        self.spans.retain(|span| span.end > to);
    }
}

#[cfg(test)]
mod tests {
    use can_twin::wire::controller::{ErrorKind, Trace};
    use can_twin::wire::frame::WireFrame;
    use can_twin::wire::record::Destruction;

    use super::*;

    fn heartbeat() -> WireFrame {
        WireFrame::standard(0x701, &[5])
    }

    /// Returns a frame that occupies the bus from `start` to `end`, in milliseconds.
    fn completed(start: u64, end: u64, segment: usize) -> Observation {
        let trace = Trace {
            frame: heartbeat(),
            transmitter: 0,
            start: Time::from_ms(start),
            end: Time::from_ms(end),
            bit_time: Time::from_us(1),
        };
        Observation::Completed { trace, receivers: Vec::new(), segment }
    }

    fn failed(start: u64, end: u64) -> Observation {
        Observation::Destroyed {
            frame: heartbeat(),
            transmitter: 0,
            start: Time::from_ms(start),
            at: Time::from_ms(end),
            cause: Destruction::Error(ErrorKind::Ack),
            receivers: Vec::new(),
            segment: 0,
        }
    }

    fn measured(records: &[Observation], end: u64) -> LoadMeter {
        let mut meter = LoadMeter::default();
        records.iter().for_each(|record| meter.observe(record));
        meter.finish(Time::from_ms(end));
        meter
    }

    #[test]
    fn load_is_known_after_the_first_second() {
        let mut meter = LoadMeter::default();
        meter.observe(&completed(0, 10, 0));
        meter.advance(Time::from_ms(1_000));
        assert_eq!((meter.last, meter.busiest()), (None, None));
        meter.advance(Time::from_ms(1_020));
        assert_eq!(meter.last, Some(Load { frames: 0.01, failed: 0.0 }));
    }

    /// Given a second with 200 ms of frames and one with 100 ms, then each second has its own load, not the mean of the
    /// flight.
    #[test]
    fn each_second_has_its_own_load() {
        let records = [completed(100, 200, 0), completed(300, 400, 0), completed(1_500, 1_600, 0)];
        let meter = measured(&records, 2_500);
        assert_eq!(meter.last.unwrap().frames, 0.1);
        assert_eq!(meter.busiest().unwrap().frames, 0.2);
        assert_eq!(measured(&records, 3_000).last, Some(Load::default()), "the last second is empty");
    }

    #[test]
    fn failed_transmissions_are_counted_apart() {
        let meter = measured(&[failed(0, 300), completed(300, 400, 0)], 1_000);
        assert_eq!(meter.last, Some(Load { frames: 0.1, failed: 0.3 }));
        assert_eq!(meter.last.unwrap().to_string(), "10.0 % (failed transmissions 30.0 %)");
    }

    #[test]
    fn a_frame_across_two_seconds_belongs_to_both() {
        let records = [completed(990, 1_015, 0)];
        assert_eq!(measured(&records, 1_000).last.unwrap().frames, 0.01);
        assert_eq!(measured(&records, 2_000).last.unwrap().frames, 0.015);
    }

    /// Given a cut bus with both pieces full, then its load is 100 %, not 200 %.
    #[test]
    fn busiest_piece_of_a_cut_bus_counts() {
        let meter = measured(&[completed(0, 1_000, 0), completed(0, 1_000, 1)], 1_000);
        assert_eq!(meter.last.unwrap().frames, 1.0);
        let meter = measured(&[completed(0, 200, 0), completed(0, 500, 1)], 1_000);
        assert_eq!(meter.last.unwrap().frames, 0.5);
    }
}
