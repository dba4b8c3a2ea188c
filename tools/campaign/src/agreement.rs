//! Agreement of the images with the machines of redundancy: sums over runs.

use ecss_can::types::Bus;
use replay::{Comparison, Stream};
use serde::{Deserialize, Serialize};

/// Sums of the comparisons of some runs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Agreement {
    /// Runs that were compared.
    pub runs: u64,
    /// Frames after which bus and state of a board were compared.
    pub frames: u64,
    /// Heartbeats and boot-up messages that agree.
    pub heartbeats: u64,
    /// NMT commands and claims of masters, and begins of their SDO transfers, that agree.
    pub commands: u64,
    /// EMCYs that agree.
    pub emergencies: u64,
    /// Lines of the log that agree.
    pub lines: u64,
    /// Lines among them that name the active bus.
    pub changes: u64,
    /// Of these, frames that waited for a mailbox or an inhibit time.
    pub waited: u64,
    /// Heartbeats and claims whose lifetime ended before there was a mailbox for them, and EMCYs that found the queue full.
    pub given_up: u64,
    /// Boards that agree if frames come before deadlines that were up to 10 us earlier.
    pub reordered: u64,
    /// Longest time from an output of a machine to that of its board, microseconds.
    pub latest_us: u64,
    /// Differences, each with its run.
    pub differences: Vec<(u64, String)>,
}

impl Agreement {
    /// Adds a run.
    pub fn add(&mut self, run: u64, comparison: &Comparison) {
        let count = |stream| comparison.outputs.get(&stream).copied().unwrap_or(0);
        self.runs += 1;
        self.frames += comparison.frames;
        self.heartbeats += count(Stream::Heartbeat);
        let claims: u64 = Bus::ALL.into_iter().map(|bus| count(Stream::Claim(bus))).sum();
        self.commands += count(Stream::Command) + claims + count(Stream::Question);
        self.emergencies += count(Stream::Emergency);
        self.lines += count(Stream::Line);
        self.changes += comparison.changes;
        self.waited += comparison.waited;
        self.given_up += comparison.given_up;
        self.reordered += comparison.reordered;
        self.latest_us = self.latest_us.max(comparison.latest.as_us());
        self.differences.extend(comparison.differences.iter().map(|one| (run, one.to_string())));
    }

    /// Adds the sums of a shard.
    pub fn add_all(&mut self, part: Agreement) {
        self.runs += part.runs;
        self.frames += part.frames;
        self.heartbeats += part.heartbeats;
        self.commands += part.commands;
        self.emergencies += part.emergencies;
        self.lines += part.lines;
        self.changes += part.changes;
        self.waited += part.waited;
        self.given_up += part.given_up;
        self.reordered += part.reordered;
        self.latest_us = self.latest_us.max(part.latest_us);
        self.differences.extend(part.differences);
    }

    /// Returns the sums for people.
    pub fn lines(&self) -> Vec<String> {
        let Agreement { runs, frames, heartbeats, commands, emergencies, lines, changes, .. } = self;
        let Agreement { waited, given_up, reordered, latest_us, differences, .. } = self;
        let mut text = vec![
            format!(
                "machines of redundancy against images: {runs} runs, bus and state after {frames} frames"
            ),
            format!(
                "agree: {heartbeats} heartbeats, {commands} commands and claims, {emergencies} EMCYs, {lines} lines of logs, \
                 {changes} of them with the active bus"
            ),
            format!(
                "{waited} frames waited for a mailbox or an inhibit time, {given_up} never had a place; all others came within \
                 {latest_us} us"
            ),
            format!("{reordered} boards agree if frames come before deadlines that were up to 10 us earlier"),
        ];
        text.extend(differences.iter().map(|(run, difference)| format!("run {run}, {difference}")));
        text.push(format!("{} differences", differences.len()));
        text
    }
}
