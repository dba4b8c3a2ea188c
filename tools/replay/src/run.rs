//! Replay of the record of one board: feeds its machine, and notes what that does.

use can_wire::frame::{WireFrame, WireId};
use can_wire::time::Time;
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant, NmtState};
use twin::bxcan::Exchange;

use crate::clock::NodeClock;
use crate::esr::health;
use crate::machine::Machine;
use crate::output::Output;
use crate::recording::{BoardRecord, What};

/// Part of the first line of a program.
pub const STARTS: &str = " starts, profile ";

/// Bus and state of a machine after a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct After {
    /// Instant of the frame.
    pub at: Time,
    /// Active bus. `None`: the log does not show it.
    pub bus: Option<Bus>,
    /// NMT state.
    pub state: NmtState,
}

/// All that a machine did.
#[derive(Debug, Default)]
pub struct Replayed {
    /// Outputs, in the order in which they were produced.
    pub outputs: Vec<(Time, Output)>,
    /// Bus and state after each frame.
    pub after: Vec<After>,
}

/// Returns the frame as the protocol knows it. `None` for a frame that no node of the protocol takes.
pub fn frame(wire: &WireFrame) -> Option<Frame> {
    let WireId::Standard(id) = wire.id else { return None };
    Frame::new(CobId::new(id)?, wire.payload()).ok()
}

/// Replays a record. Goes on to `end`, beyond its last entry. `stamped`: a program stamps a frame this long before it takes it.
pub fn replay(record: &BoardRecord, machine: &mut dyn Machine, end: Time, stamped: Duration) -> Replayed {
    let clock = NodeClock::new(record.ppm);
    let mut replayed = Replayed::default();
    let mut is_running = false;
    let mut now = Instant::ZERO;
    for entry in &record.entries {
        let is_taken = matches!(entry.what, What::Exchange(_, Exchange::Taken(_)));
        let before = if is_taken { stamped } else { Duration::ZERO };
        now = now.max(clock.show(entry.at) - before);
        if is_running {
            run_until(machine, now);
        }
        match &entry.what {
            What::Line(line) if line.contains(STARTS) => {
                is_running = true;
                machine.start(now + machine.start_delay());
            }
            What::Exchange(_, Exchange::Reset) => is_running = false,
            What::Exchange(_, Exchange::Power) => {
                is_running = false;
                machine.lose_power();
            }
            What::Line(_) => {}
            _ if !is_running => {}
            What::Exchange(bus, Exchange::Errors(esr)) => {
                machine.on_health(*bus, health(*esr), now);
                machine.poll(now);
            }
            What::Exchange(bus, exchange) => {
                if take(machine, *bus, exchange, now) {
                    let (bus, state) = (machine.bus(), machine.state());
                    replayed.after.push(After { at: entry.at, bus, state });
                }
            }
        }
    }
    if is_running {
        run_until(machine, clock.show(end));
    }
    let produced = machine.take_produced().into_iter();
    replayed.outputs = produced.map(|one| (clock.time(one.at), one.output)).collect();
    replayed
}

fn run_until(machine: &mut dyn Machine, until: Instant) {
    while let Some(due) = machine.deadline().filter(|due| *due <= until) {
        machine.poll(due);
    }
}

/// Feeds an exchange. Returns whether a frame was received or sent.
fn take(machine: &mut dyn Machine, bus: Bus, exchange: &Exchange, now: Instant) -> bool {
    let (Exchange::Requested(wire) | Exchange::Sent(wire) | Exchange::Aborted(wire) | Exchange::Taken(wire)) =
        exchange
    else {
        return false;
    };
    let Some(frame) = frame(wire) else { return false };
    match exchange {
        Exchange::Taken(_) => machine.on_received(bus, &frame, now),
        Exchange::Sent(_) => machine.on_sent(bus, &frame, now),
        Exchange::Aborted(_) => machine.on_aborted(bus, &frame, now),
        _ => machine.on_requested(bus, &frame, now),
    }
    machine.poll(now);
    matches!(exchange, Exchange::Taken(_) | Exchange::Sent(_))
}

#[cfg(test)]
mod tests {
    use ecss_can::profile::Profile;
    use ecss_can::types::NodeId;

    use super::*;
    use crate::recording::{Entry, Part};
    use crate::slave::Slave;

    /// Given a slave whose heartbeat is due 4 us before it takes a frame that moves it to the other bus, then its heartbeat goes out on
    /// the old bus. If frames are stamped 10 us before they are taken, it goes out on the new bus alone.
    #[test]
    fn a_frame_that_is_stamped_earlier_comes_before_a_deadline() {
        let node = NodeId::of::<2>();
        let master = WireFrame::standard(CobId::heartbeat(NodeId::MASTER).raw(), &[5]);
        let line = |at, text: &str| Entry { at, what: What::Line(text.into()) };
        let taken = What::Exchange(Bus::Redundant, Exchange::Taken(master));
        let entries = vec![
            line(Time::ZERO, "slave 2 starts, profile standard"),
            Entry { at: Time::from_us(100_339), what: taken },
        ];
        let record =
            BoardRecord { name: "node 2".into(), part: Part::Slave(node), ppm: 0.0, uid: [0; 12], entries };
        let buses = |stamped| -> Vec<Bus> {
            let mut slave = Slave::new(node, &Profile::DEFAULT, 0);
            let replayed = replay(&record, &mut slave, Time::from_ms(110), stamped);
            let is_heartbeat = |(_, output): &(Time, Output)| match output {
                Output::Frame(bus, frame) if frame.id() == CobId::heartbeat(node) => Some(*bus),
                _ => None,
            };
            replayed.outputs.iter().filter_map(is_heartbeat).collect()
        };
        // The first one is the boot-up message.
        assert_eq!(buses(Duration::ZERO), [Bus::Nominal, Bus::Nominal, Bus::Redundant]);
        assert_eq!(buses(Duration::from_micros(10)), [Bus::Nominal, Bus::Redundant]);
    }
}
