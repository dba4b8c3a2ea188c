//! Response times, by R. Davis, A. Burns, R. Bril and J. Lukkien: "Controller Area Network (CAN) schedulability analysis: refuted,
//! revisited and revised", Real-Time Systems 35 (2007), 239 to 272. Symbols: B blocking, C transmission, J jitter, T period,
//! R response time, w queuing delay, q instance.

use std::time::Duration;

use super::message::{Message, Network, nanos};

/// Longest error frame with the intermission behind it, bits: what an error costs beside the frame that is repeated.
const ERROR_BITS: u64 = 31;

/// A busy period of ten seconds is without end for any mission.
const ENDLESS: u64 = 10_000_000_000;

/// Rounds in which jitters that follow response times settle, or never.
const ROUNDS: usize = 1_000;

/// Longest response time of each message, from its event to the end of its frame on the bus. `None`: no bound exists, because the
/// bus cannot carry what is at least as urgent.
///
/// Every instance of a message within its busy period counts, not only the first: the second may be the latest.
pub fn response_times(messages: &[Message], network: &Network) -> Vec<Option<Duration>> {
    let mut streams: Vec<Stream> = messages.iter().map(|message| Stream::new(message, network)).collect();
    for _ in 0..ROUNDS {
        let times: Vec<Option<u64>> =
            streams.iter().map(|stream| Contest::new(stream, &streams, network).response_time()).collect();
        let mut has_settled = true;
        for (stream, message) in streams.iter_mut().zip(messages) {
            if let Some(trigger) = message.after {
                let jitter = nanos(message.jitter) + times[trigger].unwrap_or(ENDLESS);
                has_settled &= jitter == stream.jitter;
                stream.jitter = jitter;
            }
        }
        if has_settled {
            return times.into_iter().map(|time| time.map(Duration::from_nanos)).collect();
        }
    }
    vec![None; messages.len()]
}

/// A message in nanoseconds.
#[derive(Clone, Copy)]
struct Stream {
    id: u16,
    /// C, with stuff bits and intermission.
    transmission: u64,
    /// T.
    period: u64,
    /// J, with the response time of what releases it.
    jitter: u64,
}

impl Stream {
    fn new(message: &Message, network: &Network) -> Stream {
        Stream {
            id: message.id,
            transmission: network.bits(message.longest_bits()),
            period: nanos(message.period),
            jitter: nanos(message.jitter),
        }
    }

    /// Time on the bus of all instances that are released in an interval.
    fn load(&self, span: u64) -> u64 {
        (span + self.jitter).div_ceil(self.period) * self.transmission
    }
}

/// A message against all others.
struct Contest<'a> {
    network: &'a Network,
    own: Stream,
    /// All that win against it, and those of the same identifier.
    as_urgent: Vec<Stream>,
    /// B: the longest frame of lower priority may have begun just before.
    blocking: u64,
    /// What an error costs: its error frame, and the longest of the frames that may be on the bus.
    recovery: u64,
}

impl Contest<'_> {
    fn new<'a>(own: &Stream, all: &[Stream], network: &'a Network) -> Contest<'a> {
        let as_urgent: Vec<Stream> =
            all.iter().filter(|other| other.id <= own.id && !std::ptr::eq(*other, own)).copied().collect();
        let lower = all.iter().filter(|other| other.id > own.id);
        let longest = |streams: &mut dyn Iterator<Item = &Stream>| {
            streams.map(|stream| stream.transmission).max().unwrap_or(0)
        };
        let recovery = network.bits(ERROR_BITS) + longest(&mut as_urgent.iter().chain([own]));
        Contest { network, own: *own, as_urgent, blocking: longest(&mut lower.into_iter()), recovery }
    }

    fn response_time(&self) -> Option<u64> {
        let Stream { transmission, period, jitter, .. } = self.own;
        if jitter >= ENDLESS || !self.has_end() {
            return None;
        }
        // Q: instances that become ready before the busy period ends.
        let instances = (self.busy_period()? + jitter).div_ceil(period);
        (0..instances)
            .map(|q| Some((jitter + self.queuing_delay(q)? + transmission).saturating_sub(q * period)))
            .max()?
    }

    /// Whether the bus has time left beside what is as urgent and its errors.
    fn has_end(&self) -> bool {
        let share = |stream: &Stream| stream.transmission as f64 / stream.period as f64;
        let interval = self.network.errors.interval;
        let errors = interval.map_or(0.0, |interval| self.recovery as f64 / nanos(interval) as f64);
        self.as_urgent.iter().chain([&self.own]).map(share).sum::<f64>() + errors < 1.0
    }

    /// t: from the start of the blocking until nothing as urgent waits.
    fn busy_period(&self) -> Option<u64> {
        let next = |t| self.errors(t) + self.blocking + self.ahead(t) + self.own.load(t);
        fixed_point(self.own.transmission, next)
    }

    /// w(q): from the start of the busy period to that of the transmission of instance `q`.
    fn queuing_delay(&self, q: u64) -> Option<u64> {
        let (before, bit) = (self.blocking + q * self.own.transmission, self.network.bits(1));
        fixed_point(before, |w| self.errors(w + self.own.transmission) + before + self.ahead(w + bit))
    }

    fn ahead(&self, span: u64) -> u64 {
        self.as_urgent.iter().map(|stream| stream.load(span)).sum()
    }

    fn errors(&self, span: u64) -> u64 {
        self.network.errors.within(span) * self.recovery
    }
}

/// The smallest fixed point from `start` on; `None` when there is none within ten seconds.
fn fixed_point(start: u64, next: impl Fn(u64) -> u64) -> Option<u64> {
    let mut value = start;
    loop {
        let following = next(value);
        if following >= ENDLESS {
            return None;
        }
        if following <= value {
            return Some(value);
        }
        value = following;
    }
}
