//! Compares stamps of frames with the true instants, on a bus with traffic and bit errors.
//!
//! A frame ends at a board when its last bit of EOF ends by the clock of the transmitter, plus the propagation delay to
//! the board. A correct stamp is that instant on the board's own timer. The twin does not know how a program reports
//! its stamps: the user of a [`Trial`] reads them.

use crate::board::{AccessError, EmulatedBoard};
use crate::spacecraft::{BoardId, Bus, Spacecraft, WireRecord};
use crate::traffic::Traffic;
use crate::wire::encode::encode;
use crate::wire::fault::{Fault, FaultError};
use crate::wire::frame::{WireFrame, WireId};
use crate::wire::record::Observation;
use crate::wire::time::Time;

/// Counts per second of the capture timer, Hz.
const RATE: f64 = 84e6;

/// Error from which on a stamp belongs to another frame: half a bit.
const OTHER_FRAME_NS: f64 = 500.0;

/// Intervals at which stamps are read: far from a stamped frame, and close to one.
const COARSE: Time = Time::from_ms(1);
const NARROW: Time = Time::from_us(20);

/// Counters of stamps that a program reports, since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames stamped by capture.
    pub captured: u32,
    /// Frames without captured stamp, by reason.
    pub missed: [u32; 4],
    /// The last stamp, counts of the capture timer.
    pub last: u32,
}

/// Disturbance of the nominal bus in a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Share of the time for which foreign frames keep the bus busy, 0 to 1.
    pub load: f64,
    /// Bit error rate of every node.
    pub error_rate: f64,
    /// Seed of traffic and errors.
    pub seed: u64,
    /// Start of both.
    pub from: Time,
}

/// Result for the stamps of all boards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Frames to be stamped that reached all boards.
    pub frames: u64,
    /// Error of each captured stamp against the true end, in ns; late ones are positive.
    pub errors_ns: Vec<f64>,
    /// Captured stamps that match no frame that had just ended.
    pub wrong: u64,
    /// Captured stamps that were overwritten before they could be read.
    pub unread: u64,
    /// Frames without captured stamp, by reason.
    pub missed: [u64; 4],
    /// Busy share of the nominal bus while it was disturbed.
    pub load: f64,
    /// Transmissions destroyed by errors meanwhile.
    pub destroyed: u64,
}

impl Outcome {
    /// Largest distance from the truth, ns.
    pub fn worst_ns(&self) -> f64 {
        self.errors_ns.iter().fold(0.0, |worst, error| error.abs().max(worst))
    }

    /// Root of the mean square, ns.
    pub fn rms_ns(&self) -> f64 {
        let squares: f64 = self.errors_ns.iter().map(|error| error * error).sum();
        (squares / self.errors_ns.len().max(1) as f64).sqrt()
    }

    /// Returns the share of stamps by capture among all stamps, 0 to 1.
    pub fn captured_share(&self) -> f64 {
        let captured = self.errors_ns.len() as u64 + self.wrong + self.unread;
        captured as f64 / (captured + self.missed.iter().sum::<u64>()).max(1) as f64
    }
}

/// A spacecraft whose frames with one identifier on the nominal bus are stamped by all boards.
pub struct Trial {
    spacecraft: Spacecraft,
    id: u16,
    disturbance: Disturbance,
    traffic: Traffic,
    boards: Vec<Ledger>,
    outcome: Outcome,
    last_end: Option<Time>,
}

/// State of one board.
#[derive(Debug, Default)]
struct Ledger {
    /// Ends of frames that it has not stamped yet, by its capture timer.
    ends: Vec<f64>,
    /// Counters of the last read.
    said: Counts,
    /// The last read occurred while the board counted a stamp.
    torn: bool,
}

impl Trial {
    /// Makes a trial for stamps of frames `id`, which the boards send. Foreign traffic is sent at 2 m and 33 m.
    ///
    /// # Errors
    /// [`FaultError`] if the error rate is invalid.
    pub fn new(mut spacecraft: Spacecraft, id: u16, disturbance: Disturbance) -> Result<Trial, FaultError> {
        let Disturbance { load, error_rate: rate, seed, from } = disturbance;
        let traffic = Traffic::new(&mut spacecraft, Bus::Nominal, load, seed, from);
        spacecraft.wire_mut(Bus::Nominal).schedule(from, Fault::BitErrors { rate, seed })?;
        let boards = spacecraft.boards().map(|_| Default::default()).collect();
        Ok(Trial {
            spacecraft,
            id,
            disturbance,
            traffic,
            boards,
            outcome: Outcome::default(),
            last_end: None,
        })
    }

    /// Runs until `frames` frames have been sent under disturbance, one every `period`; `read` reads the counters of a
    /// board. It also ends if frames are missing: see [`Outcome::frames`].
    ///
    /// # Errors
    /// [`AccessError`] when a program made an access that the model refuses, and errors of `read`.
    pub fn run<E: From<AccessError>>(
        mut self,
        frames: u64,
        period: Time,
        read: impl Fn(&EmulatedBoard) -> Result<Counts, E>,
    ) -> Result<Outcome, E> {
        self.fly(self.disturbance.from, &read)?;
        self.outcome = Outcome::default();
        self.boards.iter_mut().for_each(|board| board.ends.clear());
        let before = self.spacecraft.wire(Bus::Nominal).counters();
        let start = self.spacecraft.now();
        let patience = start + Time((frames + 10) * period.0);
        while self.outcome.frames < frames && self.spacecraft.now() < patience {
            let now = self.spacecraft.now();
            // Stamps are read at once where frames are expected, and rarely elsewhere.
            let since = now.since(self.last_end.unwrap_or(now));
            let quiet = since > COARSE + COARSE && since + COARSE + COARSE < period;
            self.fly(now + if quiet { COARSE } else { NARROW }, &read)?;
        }
        // The boards have to handle the last frame.
        self.fly(self.spacecraft.now() + COARSE, &read)?;
        let after = self.spacecraft.wire(Bus::Nominal).counters();
        let flown = self.spacecraft.now().since(start).as_secs_f64();
        self.outcome.load = after.busy.since(before.busy).as_secs_f64() / flown;
        self.outcome.destroyed = after.destroyed - before.destroyed;
        Ok(self.outcome)
    }

    fn fly<E: From<AccessError>>(
        &mut self,
        until: Time,
        read: &impl Fn(&EmulatedBoard) -> Result<Counts, E>,
    ) -> Result<(), E> {
        self.traffic.hand_over(&mut self.spacecraft, until);
        self.spacecraft.run_until(until)?;
        self.spacecraft.take_logs();
        for record in self.spacecraft.take_frames() {
            self.note_ends(&record);
        }
        for (id, board) in self.spacecraft.boards() {
            self.boards[id.0].judge(read(board)?, &mut self.outcome);
        }
        Ok(())
    }

    /// Records when a frame ended at the boards that received it.
    fn note_ends(&mut self, record: &WireRecord) {
        let stamped = WireId::Standard(self.id);
        match &record.record {
            Observation::Completed { trace, receivers, .. }
                if record.bus == Bus::Nominal && trace.frame.id == stamped =>
            {
                let boards = self.boards.len();
                let reached = receivers.iter().filter(|(node, _)| *node < boards).count();
                self.outcome.frames += u64::from(reached + 1 == boards);
                self.last_end = Some(trace.end);
                self.note_end(trace.transmitter, trace.transmitter, trace.end);
                for (node, _) in receivers {
                    self.note_end(*node, trace.transmitter, trace.end);
                }
            }
            // Destroyed in its last bit, after receivers had accepted it.
            Observation::Destroyed { frame, transmitter, start, receivers, .. }
                if record.bus == Bus::Nominal && frame.id == stamped =>
            {
                for (node, _) in receivers {
                    self.note_end(*node, *transmitter, end_of(frame, *start));
                }
            }
            Observation::ReceivedLate { node, frame, transmitter, start, .. }
                if record.bus == Bus::Nominal && frame.id == stamped =>
            {
                self.note_end(*node, *transmitter, end_of(frame, *start));
            }
            _ => {}
        }
    }

    fn note_end(&mut self, node: usize, transmitter: usize, end: Time) {
        if let Some(board) = self.boards.get_mut(node) {
            let at = end + self.spacecraft.wire(Bus::Nominal).delay(transmitter, node);
            board.ends.push(self.spacecraft.board(BoardId(node)).capture_clock(at));
        }
    }
}

impl Ledger {
    /// Compares the board's counters `now` with the ends that it should have stamped, and removes these.
    fn judge(&mut self, now: Counts, outcome: &mut Outcome) {
        let captured = now.captured - self.said.captured;
        // A board counts a stamp before it stores it: the next read has both.
        if captured > 0 && now.last == self.said.last && !self.torn {
            self.torn = true;
            return;
        }
        if captured > 0 {
            outcome.unread += u64::from(captured - 1);
            let errors = self.ends.iter().map(|end| apart_ns(now.last, *end)).enumerate();
            match errors.min_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs())) {
                Some((n, error)) if error.abs() < OTHER_FRAME_NS => {
                    outcome.errors_ns.push(error);
                    self.ends.drain(..=n);
                }
                _ => outcome.wrong += 1,
            }
        }
        for (reason, count) in outcome.missed.iter_mut().enumerate() {
            let missed = now.missed[reason] - self.said.missed[reason];
            *count += u64::from(missed);
            self.ends.drain(..self.ends.len().min(missed as usize));
        }
        (self.said, self.torn) = (now, false);
    }
}

/// End of a frame at its transmitter, by its SOF there.
fn end_of(frame: &WireFrame, start: Time) -> Time {
    start + Time::from_us(encode(frame).bits().len() as u64)
}

/// Returns the time from the `end` of a frame to its `stamp`, both by a timer of 32 bits, in ns.
fn apart_ns(stamp: u32, end: f64) -> f64 {
    const ROUND: f64 = (1_u64 << 32) as f64;
    let apart = f64::from(stamp) - end;
    (apart - ROUND * (apart / ROUND).round()) * 1e9 / RATE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn says(captured: u32, last: u32) -> Counts {
        Counts { captured, missed: [0; 4], last }
    }

    #[test]
    fn stamps_are_compared_with_the_ends_of_their_time() {
        let mut outcome = Outcome::default();
        let mut board = Ledger { ends: vec![1000.0, 9400.5], ..Ledger::default() };
        board.judge(says(1, 1004), &mut outcome);
        board.judge(says(2, 9397), &mut outcome);
        assert!(board.ends.is_empty());
        let expected = [4.0 * 1e3 / 84.0, -3.5 * 1e3 / 84.0];
        assert!(outcome.errors_ns.iter().zip(expected).all(|(error, it)| (error - it).abs() < 1e-6));
        assert!((outcome.worst_ns() - expected[0]).abs() < 1e-6);
    }

    #[test]
    fn a_stamp_of_another_frame_is_wrong() {
        let mut outcome = Outcome::default();
        let mut board = Ledger { ends: vec![1000.0], ..Ledger::default() };
        board.judge(says(1, 1000 + 84), &mut outcome);
        assert_eq!((outcome.wrong, &outcome.errors_ns), (1, &vec![]));
        // The same stamp again: not judged at the first read, when it may not be stored yet.
        board.judge(says(2, 1000 + 84), &mut outcome);
        assert_eq!(outcome.wrong, 1);
        board.judge(says(2, 1000 + 84), &mut outcome);
        assert_eq!(outcome.wrong, 2);
    }

    #[test]
    fn a_stamp_may_be_counted_before_it_is_kept() {
        let mut outcome = Outcome::default();
        let mut board = Ledger { ends: vec![1000.0], ..Ledger::default() };
        board.judge(says(1, 0), &mut outcome);
        board.judge(says(1, 1000), &mut outcome);
        assert_eq!((outcome.wrong, outcome.errors_ns), (0, vec![0.0]));
    }

    #[test]
    fn a_miss_takes_the_oldest_end_away() {
        let mut outcome = Outcome::default();
        let mut board = Ledger { ends: vec![1000.0, 9400.0], ..Ledger::default() };
        board.judge(Counts { missed: [0, 1, 0, 0], ..says(0, 0) }, &mut outcome);
        assert_eq!((board.ends, outcome.missed, outcome.captured_share()), (vec![9400.0], [0, 1, 0, 0], 0.0));
    }

    #[test]
    fn the_timer_may_wrap_in_between() {
        assert!((apart_ns(2, 4_294_967_295.0) - 3.0 * 1e3 / 84.0).abs() < 1e-6);
        assert!((apart_ns(u32::MAX, 1.0) + 2.0 * 1e3 / 84.0).abs() < 1e-6);
    }
}
