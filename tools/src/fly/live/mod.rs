//! `cargo twin`: the spacecraft in real time, its buses are open to SLCAN clients.

mod channel;
mod client;
mod console;
mod control;
mod network;
mod options;
mod pace;
mod port;
mod recording;
mod slcan;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::time::Instant;

use ::console::style;
use anyhow::bail;
use can_twin::board::BoardConfig;
use can_twin::rtt::Level;
use can_twin::spacecraft::{BoardId, Bus, Spacecraft, SpacecraftConfig};
use can_twin::wire::time::Time;
use can_twin::wire::timing::BitTiming;
use console::Console;
use control::ControlPort;
use network::{Network, kbit};
pub use options::Options;
use pace::{LagReporter, Pace};
use port::OfferedBus;
use recording::Recording;

use crate::fly::command::Operator;
use crate::fly::plan;
use crate::images::support::fleet::Images;
use crate::images::support::misuse::Misuse;
use crate::images::support::node::{MASTER, Node, SECOND_MASTER};
use crate::images::support::output::{note, warn};
use crate::images::support::stop::Stop;

/// Longest interval between serving the sockets, in virtual time, which runs no faster than real time.
const STEP: Time = Time::from_us(500);

/// Runs until Ctrl-C or the requested end.
///
/// # Errors
/// When an image cannot be built, a port is taken, or a board had to be stopped, panicked or locked up.
pub fn run(options: &Options) -> anyhow::Result<()> {
    options.check()?;
    let nodes = options.nodes();
    let mut images = options.fleet.own_images("twin", &nodes)?;
    // A port that is taken is reported before a build of a minute. The port is closed again: a client that connected
    // now would get no frames for a long time and would not know why.
    Bus::ALL.into_iter().try_for_each(|bus| port::listen(bus, options.address(bus)).map(drop))?;
    if !options.listen.is_loopback() {
        warn(format_args!("whoever reaches {} can command the boards, without a password", options.listen));
    }
    options.fleet.add_shipped(&nodes, &mut images)?;
    let boards = boards(options, &images)?;
    note(format_args!("running {} boards for a moment, to learn their bit rates", boards.len()));
    let network = Network::learn(boards.values().cloned());
    let disagreement = network.disagreement();
    disagreement.iter().for_each(warn);
    let (mut spacecraft, boards) = assemble(boards);
    let recording = options.record.as_deref().map(Recording::begin).transpose()?;
    let stop = Stop::at_ctrl_c()?;
    let mut ports = Vec::new();
    for bus in Bus::ALL {
        let listener = port::listen(bus, options.address(bus))?;
        let timing = network.timing(bus).unwrap_or(BitTiming::MEGABIT);
        ports.push(OfferedBus::new(&mut spacecraft, bus, timing, listener));
    }
    let control = options.control.map(|port| ControlPort::listen(SocketAddr::new(options.listen, port)));
    let control = control.transpose()?;
    let mut console = Console::open(&stop);
    for port in &ports {
        let (bus, address, rate) = (port.bus, port.listener.local_addr()?, kbit(port.timing.bit_rate()));
        let note = if network.timing(bus).is_some() { "" } else { ": no board has set another one" };
        console.say(format_args!("{bus} bus: slcan socket://{address} at {rate} kbit/s{note}"));
    }
    if let Some(control) = &control {
        console.say(format_args!("control: socket://{}", control.listener.local_addr()?));
    }
    let operator = Operator::new(boards, vec![port::POSITION_M]);
    let faults = Vec::new();
    let lag = LagReporter::default();
    let mut run = Run { disagreement, spacecraft, ports, operator, console, control, recording, faults, lag };
    let pace = run.fly(Time::from_us((options.seconds * 1e6) as u64), &stop)?;
    run.conclude(&pace)
}

/// The boards by their nodes. They get power within the first 0.3 s.
///
/// # Errors
/// When a board cannot have the given part.
fn boards(options: &Options, images: &Images) -> Result<BTreeMap<Node, BoardConfig>, Misuse> {
    let plans = plan::boards(crate::fly::SEED, &options.nodes()).into_iter();
    let fleet = &options.fleet;
    let own = fleet.own_board("twin")?;
    let boards = plans
        .map(|board| {
            let name = match board.node {
                MASTER => "master".into(),
                SECOND_MASTER => "second master".into(),
                slave => format!("slave {slave}"),
            };
            let model = if fleet.own_image(board.node).is_some() { &own } else { &fleet.target.board };
            (board.node, board.config(model, name, images[&board.node].clone()))
        })
        .collect();
    Ok(boards)
}

/// Puts boards without power on two wires.
fn assemble(boards: BTreeMap<Node, BoardConfig>) -> (Spacecraft, BTreeMap<Node, BoardId>) {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let boards = boards.into_iter().map(|(node, config)| (node, spacecraft.add_board(config))).collect();
    (spacecraft, boards)
}

struct Run {
    /// Report of boards with different bit rates on a bus.
    disagreement: Option<String>,
    spacecraft: Spacecraft,
    ports: Vec<OfferedBus>,
    operator: Operator,
    console: Console,
    control: Option<ControlPort>,
    recording: Option<Recording>,
    faults: Vec<String>,
    lag: LagReporter,
}

impl Run {
    fn fly(&mut self, end: Time, stop: &Stop) -> anyhow::Result<Pace> {
        let mut pace = Pace::new(Instant::now());
        while self.spacecraft.now() < end && !stop.is_asked() && !self.operator.is_over {
            let next = (self.spacecraft.now() + STEP).min(end);
            std::thread::sleep(pace.instant_of(next).saturating_duration_since(Instant::now()));
            pace.reached(next, Instant::now());
            if let Some(lag) = self.lag.due(pace.behind, Instant::now()) {
                self.console.warn(lag);
            }
            self.obey();
            self.ports.iter_mut().for_each(|port| port.hear_clients(&mut self.spacecraft));
            self.advance(next)?;
            self.ports.iter_mut().for_each(|port| port.tell_clients(&mut self.spacecraft));
            for note in self.ports.iter_mut().flat_map(|port| port.notes.drain(..)) {
                self.console.say(format_args!("{:10.3} s  {note}", next.as_secs_f64()));
            }
        }
        Ok(pace)
    }

    /// Executes typed commands and those of programs.
    fn obey(&mut self) {
        while let Some(line) = self.console.next() {
            if line.trim().is_empty() {
                continue;
            }
            let (Ok(said) | Err(said)) = self.operator.obey(&line, &mut self.spacecraft);
            self.console.say(said);
        }
        if let Some(control) = &mut self.control {
            control.serve(|line| self.operator.obey(line, &mut self.spacecraft));
        }
    }

    /// A board stopped by the twin stays behind.
    fn advance(&mut self, until: Time) -> anyhow::Result<()> {
        while let Err(fault) = self.spacecraft.run_until(until) {
            let fault = fault.to_string();
            self.console.complain(&fault);
            self.faults.push(fault);
        }
        for record in self.spacecraft.take_frames() {
            self.operator.observe(&record);
            self.recording.as_mut().map_or(Ok(()), |recording| recording.frame(&record))?;
        }
        self.operator.advance(self.spacecraft.now());
        // Pin changes are not used.
        let boards: Vec<BoardId> = self.spacecraft.boards().map(|(id, _)| id).collect();
        boards.into_iter().for_each(|id| drop(self.spacecraft.board_mut(id).take_pin_changes()));
        for log in self.spacecraft.take_logs() {
            let name = &self.spacecraft.board(log.board).config().name;
            self.recording.as_mut().map_or(Ok(()), |recording| recording.line(log.at, name, &log.text))?;
            let text = match log.level {
                Some(Level::Error) => style(log.text).red(),
                Some(Level::Warn) => style(log.text).yellow(),
                _ => style(log.text),
            };
            self.console.say(format_args!("{:10.3} s  {name:<7}  {text}", log.at.as_secs_f64()));
        }
        Ok(())
    }

    /// Prints the final report. Fails if the run was not good.
    fn conclude(mut self, pace: &Pace) -> anyhow::Result<()> {
        self.console.end_typing();
        self.recording.take().map_or(Ok(()), Recording::end)?;
        let seconds = self.spacecraft.now().as_secs_f64();
        self.console.say(format_args!(
            "ended after {seconds:.1} s of virtual time, {:.1} s behind the clock on the wall",
            pace.behind.as_secs_f64()
        ));
        let meters = self.operator.conclude(self.spacecraft.now());
        for (port, meter) in self.ports.iter().zip(meters) {
            let bus = port.bus;
            let frames = self.spacecraft.wire(bus).counters().completed;
            let port::Totals { clients, sent, lost, abandoned } = port.totals();
            self.console.say(format_args!(
                "{bus} bus: {frames} frames on it, {sent} of them from clients; clients: {clients}, frames lost because they \
                 did not read: {lost}, frames of theirs given up: {abandoned}"
            ));
            if let (Some(busiest), Some(last)) = (meter.busiest(), meter.last) {
                self.console.say(format_args!(
                    "{bus} bus: load of the busiest second {busiest}, of the last one {last}"
                ));
            }
        }
        // Repeated, because it may explain the results.
        self.disagreement.iter().for_each(|disagreement| self.console.warn(disagreement));
        let mut faults = self.faults;
        for (_, board) in self.spacecraft.boards() {
            let counters = board.counters();
            for (count, what) in [(counters.panics, "panicked"), (counters.lockups, "locked up")] {
                if count > 0 {
                    faults.push(format!("{} {what} ({count} times)", board.config().name));
                }
            }
        }
        if !faults.is_empty() {
            bail!("not all boards were well: {}", faults.join("; "));
        }
        Ok(())
    }
}
