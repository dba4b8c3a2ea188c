//! Response times, by R. Davis, A. Burns, R. Bril and J. Lukkien: "Controller Area Network (CAN) schedulability analysis: refuted,
//! revisited and revised", Real-Time Systems 35 (2007), 239 to 272. Symbols: B blocking, C transmission, J jitter, T period,
//! R response time, w queuing delay, q instance.

use std::time::Duration;

use super::message::{Message, Network, nanos};

/// Longest error frame with the intermission behind it, in bits: the cost of an error in addition to the repeated
/// frame.
const ERROR_BITS: u64 = 31;

/// Length of a busy period that counts as endless, in nanoseconds: ten seconds.
const ENDLESS: u64 = 10_000_000_000;

/// Greatest number of rounds in which jitters that depend on response times converge.
const ROUNDS: usize = 1_000;

/// Longest response time of each message, from its event to the end of its frame on the bus. `None`: no bound exists,
/// because the bus cannot carry all messages of at least this priority.
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
    /// J, including the response time of the message that releases it.
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

/// A message and those that delay it.
struct Contest<'a> {
    network: &'a Network,
    own: Stream,
    /// Messages of higher priority, and those of the same identifier.
    as_urgent: Vec<Stream>,
    /// B: the longest frame of lower priority, which may have begun just before.
    blocking: u64,
    /// Cost of an error: its error frame, and the longest of the frames that may be on the bus.
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

    /// Returns whether messages of at least this priority and errors leave time on the bus.
    fn has_end(&self) -> bool {
        let share = |stream: &Stream| stream.transmission as f64 / stream.period as f64;
        let interval = self.network.errors.interval;
        let errors = interval.map_or(0.0, |interval| self.recovery as f64 / nanos(interval) as f64);
        self.as_urgent.iter().chain([&self.own]).map(share).sum::<f64>() + errors < 1.0
    }

    /// Returns t: from the start of the blocking until no message of at least this priority waits.
    fn busy_period(&self) -> Option<u64> {
        let next = |t| self.errors(t) + self.blocking + self.ahead(t) + self.own.load(t);
        fixed_point(self.own.transmission, next)
    }

    /// Returns w(q): from the start of the busy period to the start of the transmission of instance `q`.
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

/// Returns the smallest fixed point from `start` on; `None` if there is none within ten seconds.
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
