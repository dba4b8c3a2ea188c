//! The flight: the real images on the twin, observed from outside.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

use anyhow::Context;
use can_twin::board::{BoardConfig, EmulatedBoard, State};
use can_twin::bxcan::{Aborted, Side};
use can_twin::spacecraft::{BoardId, LogRecord, Spacecraft, SpacecraftConfig};
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;

use super::clocks::ClockWatch;
use super::command::Operator;
use super::fault::{self, Cause, Fault};
use super::flight::{AbortedFrame, BoardCount, Flight, Interruption};
use super::line::Line;
use super::narrator::Narrator;
use super::observer::Observer;
use super::plan::{BoardPlan, Plan};
use super::record::{Bus, FlightEvent, Level, Node, Occurrence, Seen};
use super::stack;
use super::stamps::StampWatch;
use crate::images::support::counters::Counters;
use crate::images::support::diagnostics::Diagnostics;
use crate::images::support::fleet::Images;

/// Interval in which the watchers read the spacecraft.
const STEP: Time = Time::from_ms(10);

/// Time for which both buses have to be silent at the end of the flight. A node handles a frame much faster, so no
/// frame is between wire and node when the counters are read.
const QUIET: Time = Time::from_ms(1);

/// Longest wait for silent buses after the planned end.
const PATIENCE: Time = Time::from_ms(1000);

/// Flies a plan with an image for each of its boards. `watch` gets the time and the events, a moment after they
/// occurred, and can interrupt the flight. Frames in progress are completed then, so that the counters are consistent.
///
/// # Errors
/// When an image is missing, or does not export its counters.
pub fn fly(plan: Plan, images: &Images, mut watch: impl Watch) -> anyhow::Result<Flight> {
    let began = Instant::now();
    let mut mission = Mission::prepare(plan, images)?;
    let interrupted = mission.fly(&mut watch).break_value();
    mission.settle(&mut watch);
    mission.conclude(began, interrupted)
}

/// Gets the time and the newest lines of the story.
pub trait Watch: FnMut(Time, &[Line]) -> ControlFlow<Interruption> {}

impl<F: FnMut(Time, &[Line]) -> ControlFlow<Interruption>> Watch for F {}

/// Returns every [`STEP`] up to `end`, and each fault.
fn stops(end: Time, faults: Vec<Time>) -> impl Iterator<Item = Time> {
    let mut now = None::<Time>;
    std::iter::from_fn(move || {
        let next = match now {
            None => Time::ZERO,
            Some(now) if now >= end => return None,
            Some(now) => (now + STEP).min(end),
        };
        let faults = faults.iter().copied().filter(|at| now.is_none_or(|now| *at > now));
        now = Some(faults.fold(next, Time::min));
        now
    })
}

struct Mission {
    plan: Plan,
    spacecraft: Spacecraft,
    observer: Observer,
    narrator: Narrator,
    records: Vec<Occurrence>,
    story: Vec<Line>,
    /// Executes the commands among the faults.
    operator: Operator,
    /// Faults that could not be caused, with the reason.
    refused: Vec<String>,
    last_frame: Time,
    stamps: StampWatch,
    clocks: ClockWatch,
    /// Bit rates of the boards in the order of the plan, as [`BoardCount`] has them.
    bit_rates: Vec<[Option<u32>; 2]>,
}

impl Mission {
    fn prepare(plan: Plan, images: &Images) -> anyhow::Result<Mission> {
        let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
        let mut boards = BTreeMap::new();
        for board in &plan.boards {
            let name = super::narrator::name(board.node);
            let image = images.get(&board.node).with_context(|| format!("no image for {name}"))?;
            let config = board.config(plan.model(board), name, image.clone());
            let id = spacecraft.add_board(BoardConfig { crystal: board.crystal, ..config });
            boards.insert(board.node, id);
        }
        Ok(Mission {
            observer: Observer::new(&plan),
            narrator: Narrator::new(&plan),
            bit_rates: vec![[None; 2]; plan.boards.len()],
            plan,
            spacecraft,
            records: Vec::new(),
            story: Vec::new(),
            operator: Operator::new(boards, Vec::new()),
            refused: Vec::new(),
            last_frame: Time::ZERO,
            stamps: StampWatch::default(),
            clocks: ClockWatch::default(),
        })
    }

    fn fly(&mut self, watch: &mut impl Watch) -> ControlFlow<Interruption> {
        let faults = self.plan.faults.iter().map(|fault| fault.at).collect();
        for stop in stops(self.plan.end, faults) {
            self.advance(stop, watch)?;
            let now = self.plan.faults.iter().filter(|fault| fault.at == stop).cloned();
            let caused: Vec<_> =
                now.collect::<Vec<_>>().iter().filter_map(|fault| self.cause(fault)).collect();
            if !caused.is_empty() {
                self.take(caused.into_iter().map(|what| Occurrence { at: stop, what }).collect(), watch)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Causes a fault now. The active master is known only by its heartbeat.
    fn cause(&mut self, fault: &Fault) -> Option<FlightEvent> {
        let active = self.observer.active_master();
        match &fault.cause {
            Cause::ResetStandby => {
                let standby = self.plan.other_master(active?)?;
                self.spacecraft.reset(self.board(standby));
                Some(FlightEvent::Reset(standby))
            }
            Cause::LoseActive => {
                let active = active?;
                self.spacecraft.power(self.board(active), false);
                Some(FlightEvent::PowerOff(active))
            }
            Cause::Command(command) => match self.operator.execute(command.clone(), &mut self.spacecraft) {
                Ok(answer) if answer.starts_with("done") => fault::event(command, fault.at),
                Ok(reason) | Err(reason) => {
                    self.refused.push(format!("{}: {reason}", fault.origin));
                    None
                }
            },
        }
    }

    /// Runs to `until`. A board stopped by the twin stays behind; the verdict names it.
    fn advance(&mut self, until: Time, watch: &mut impl Watch) -> ControlFlow<Interruption> {
        let from = self.spacecraft.now();
        while self.spacecraft.run_until(until).is_err() {}
        let powered = self.plan.boards.iter().filter(|board| (from..until).contains(&board.power_on));
        let power_on =
            |board: &BoardPlan| Occurrence { at: board.power_on, what: FlightEvent::PowerOn(board.node) };
        let mut records: Vec<Occurrence> = powered.map(power_on).collect();
        let frames = self.spacecraft.take_frames();
        frames.iter().for_each(|wire| self.stamps.on(wire));
        self.stamps.look(&self.spacecraft);
        self.clocks.look(&mut self.spacecraft);
        self.look_at_bit_rates();
        records.extend(frames.into_iter().filter_map(|wire| self.frame(wire.bus, wire.record)));
        let logs = self.spacecraft.take_logs().into_iter();
        records.extend(logs.filter_map(|log| self.log(log)));
        records.sort_by_key(|record| record.at);
        self.take(records, watch)
    }

    /// Records the bit rates of the controllers that take part in a bus now.
    fn look_at_bit_rates(&mut self) {
        for (board, rates) in self.bit_rates.iter_mut().enumerate() {
            for (bus, rate) in Bus::ALL.into_iter().zip(rates) {
                let timing = self.spacecraft.bit_timing(BoardId(board), bus);
                // Rounded: the crystal of the board is some ppm off.
                *rate = timing.map(|timing| (timing.bit_rate() + 500) / 1000).or(*rate);
            }
        }
    }

    /// Passes records to all watchers.
    fn take(&mut self, records: Vec<Occurrence>, watch: &mut impl Watch) -> ControlFlow<Interruption> {
        let before = self.story.len();
        for record in records {
            let changes = self.observer.on(&record);
            self.story.extend(self.narrator.narrate(&record, &changes));
            if matches!(record.what, FlightEvent::Frame(_)) {
                self.last_frame = record.at;
            }
            self.records.push(record);
        }
        watch(self.spacecraft.now(), &self.story[before..])
    }

    /// Continues until the buses are quiet, also if `watch` interrupts.
    fn settle(&mut self, watch: &mut impl Watch) {
        let deadline = self.spacecraft.now() + PATIENCE;
        let quiet = |mission: &Mission| mission.spacecraft.now() >= mission.last_frame + QUIET;
        while !quiet(self) && self.spacecraft.now() < deadline {
            let until = self.spacecraft.now() + QUIET;
            let _ = self.advance(until, watch);
        }
    }

    fn conclude(mut self, began: Instant, interrupted: Option<Interruption>) -> anyhow::Result<Flight> {
        let end = self.spacecraft.now();
        self.observer.conclude(end);
        let boards = self
            .plan
            .boards
            .iter()
            .zip(self.spacecraft.boards())
            .zip(&self.bit_rates)
            .map(|((plan, (id, board)), &bit_rates)| {
                let aborted = self.aborted(plan, id);
                Ok(BoardCount { bit_rates, aborted, ..count(plan.node, board)? })
            })
            .collect::<anyhow::Result<Vec<_>>>()?;
        let nodes: Vec<Node> = self.plan.boards.iter().map(|board| board.node).collect();
        let (mut clocks, mut uncompared) = (Vec::new(), BTreeMap::new());
        for (node, clock) in self.clocks.clocks(&nodes, &self.observer, &self.records) {
            match clock {
                Ok(clock) => clocks.push(clock),
                Err(cause) => drop(uncompared.insert(node, cause)),
            }
        }
        Ok(Flight {
            plan: self.plan,
            end,
            interrupted,
            wall: began.elapsed(),
            records: self.records,
            story: self.story,
            observer: self.observer,
            boards,
            refused: self.refused,
            stamp_errors: self.stamps.errors(),
            clocks,
            uncompared,
            busy: Bus::ALL.map(|bus| self.spacecraft.wire(bus).counters().busy),
        })
    }

    /// Returns the frames that a board aborted on both buses.
    fn aborted(&self, plan: &BoardPlan, board: BoardId) -> Vec<AbortedFrame> {
        let track = self.observer.nodes.get(&plan.node).filter(|_| plan.has_one_controller);
        let sides = [Side::Can1, Side::Can2].into_iter();
        let on_side = |side| {
            let bus = self.spacecraft.place(board, side).map_or(Bus::Nominal, |(bus, _)| bus);
            let aborted = self.spacecraft.board(board).can_stats(side).aborted.into_iter();
            aborted.map(move |Aborted { at, frame, last }| AbortedFrame {
                at,
                // One controller was on either bus.
                bus: track.map_or(bus, |track| track.bus_at(at)),
                id: frame.id,
                last,
            })
        };
        sides.flat_map(on_side).collect()
    }

    fn frame(&self, bus: Bus, record: Observation) -> Option<Occurrence> {
        let Observation::Completed { trace, receivers, .. } = record else { return None };
        let reached = receivers.iter().map(|(index, _)| self.node(*index)).collect();
        let from = self.node(trace.transmitter);
        let seen = Seen::new(bus, trace.frame, self.plan.scope(), from, reached);
        Some(Occurrence { at: trace.end, what: FlightEvent::Frame(seen) })
    }

    fn log(&self, log: LogRecord) -> Option<Occurrence> {
        let level = match log.level {
            Some(Level::Trace | Level::Debug) => return None,
            other => other.unwrap_or(Level::Info),
        };
        let what = FlightEvent::Log { node: self.node(log.board.0), level, text: log.text };
        Some(Occurrence { at: log.at, what })
    }

    fn board(&self, node: Node) -> BoardId {
        let place = self.plan.boards.iter().position(|board| board.node == node);
        BoardId(place.expect("the observer knows boards of the plan alone"))
    }

    /// Boards are attached in the order of the plan.
    fn node(&self, index: usize) -> Node {
        self.plan.boards[index].node
    }
}

fn count(node: Node, board: &EmulatedBoard) -> anyhow::Result<BoardCount> {
    let diagnostics =
        Diagnostics::read(board).with_context(|| format!("{}: cannot count", board.config().name))?;
    let counters = board.counters();
    Ok(BoardCount {
        node,
        instructions: counters.instructions,
        cycles_awake: counters.cycles_awake,
        // Frames received by a board that then lost its power do not count as lost.
        lost_frames: if board.is_powered() { diagnostics.lost_frames(board) } else { 0 },
        aborted: Vec::new(),
        lockups: counters.lockups,
        panics: counters.panics,
        resets: counters.system_resets + counters.watchdog_resets,
        stopped: match board.state() {
            State::Refused(error) => Some(error.to_string()),
            _ => None,
        },
        bit_rates: [None; 2],
        warnings: board.warnings().to_vec(),
        stack: stack::deepest(board)?,
        diagnostics,
        counters: Counters::read(board)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn milliseconds(end: u64, faults: &[u64]) -> Vec<u64> {
        let faults = faults.iter().copied().map(Time::from_ms).collect();
        stops(Time::from_ms(end), faults).map(|stop| stop.as_us() / 1000).collect()
    }

    #[test]
    fn watchers_look_every_step_and_at_each_fault() {
        assert_eq!(milliseconds(25, &[]), [0, 10, 20, 25]);
        assert_eq!(milliseconds(25, &[13]), [0, 10, 13, 23, 25]);
        for step in [0, 10, 20] {
            assert_eq!(milliseconds(20, &[step]), [0, 10, 20]);
        }
        assert_eq!(milliseconds(25, &[3, 6, 12]), [0, 3, 6, 12, 22, 25]);
    }
}
