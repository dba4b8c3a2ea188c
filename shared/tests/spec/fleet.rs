//! A master and its slaves together, on buses without bit timing: what is sent arrives within the millisecond.
//!
//! A node that nobody acknowledges becomes error passive; cut off, it neither hears nor is heard.
//!
//! Verifies: ECSS 8.3.3b, 8.3.3g

use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::node::extend::{BusCommand, Filters, LinkEvent};
use ecss_can::node::{FailCause, MasterEvent, MasterRequest, Node, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, Frame, Instant, NmtState, NodeId, PerBus};

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, ms, node, stamp};
use crate::console;
use crate::instrument::{self, SLOW, STANDARD};
use crate::slave::TestSlave;

/// Slaves 2 and 3 with parallel access, slave 4 with selective access.
const SELECTIVE: Profile = Profile { selective: &[NodeId::of::<4>()], ..STANDARD };

/// One node and its two controllers.
struct Station<N: Node> {
    bench: Bench<N>,
    filters: Filters,
    joined: PerBus<bool>,
    connected: PerBus<bool>,
    passive: PerBus<bool>,
    pending: Vec<(Bus, Frame, Instant)>,
}

impl<N: Node> Station<N> {
    fn new(now: u64, node: N, filters: Filters) -> Self {
        Station {
            bench: Bench::powered_at(ms(now), node),
            filters,
            joined: PerBus::default(),
            connected: PerBus { nominal: true, redundant: true },
            passive: PerBus::default(),
            pending: vec![],
        }
    }

    fn is_on(&self, bus: Bus) -> bool {
        self.joined[bus] && self.connected[bus]
    }

    /// What the node commanded since the last time: controls before frames, as every switch has them.
    fn collect(&mut self) {
        for (bus, command) in std::mem::take(&mut self.bench.controls) {
            match command {
                BusCommand::Join => self.joined[bus] = true,
                BusCommand::Leave => (self.joined[bus], self.passive[bus]) = (false, false),
                _ => {}
            }
            if matches!(command, BusCommand::Abandon | BusCommand::Leave) {
                let (gone, kept) = self.pending.iter().partition(|(of, ..)| *of == bus);
                self.pending = kept;
                for (_, frame, _) in Vec::<_>::into_iter(gone) {
                    self.bench.failed(bus, frame, FailCause::BusLeft);
                }
            }
        }
        for sent in std::mem::take(&mut self.bench.sent) {
            self.pending.push((sent.bus, sent.frame, sent.expires));
        }
    }

    fn set_passive(&mut self, bus: Bus, passive: bool) {
        if self.passive[bus] != passive {
            self.passive[bus] = passive;
            self.bench.health(
                bus,
                match passive {
                    true => {
                        Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack }
                    }
                    false => Health { tec: 127, ..Health::default() },
                },
            );
        }
    }

    fn hear(&mut self, bus: Bus, frame: Frame) {
        if self.filters.iter().any(|filter| filter.admits(frame.id())) {
            let stamp = stamp(self.bench.now);
            self.bench.link(bus, LinkEvent::Received { frame, stamp });
        }
    }

    /// Settles the fate of what is pending; `acknowledged` says whether anybody else is on a bus.
    fn transmit(&mut self, acknowledged: PerBus<bool>) -> Vec<(Bus, Frame)> {
        let mut gone = vec![];
        for (bus, frame, expires) in std::mem::take(&mut self.pending) {
            if expires <= self.bench.now {
                self.bench.failed(bus, frame, FailCause::Expired);
            } else if self.is_on(bus) && acknowledged[bus] {
                self.set_passive(bus, false);
                self.bench.transmitted(bus, frame);
                gone.push((bus, frame));
            } else {
                self.pending.push((bus, frame, expires));
                if self.joined[bus] {
                    self.set_passive(bus, true);
                }
            }
        }
        gone
    }
}

struct Fleet {
    now: u64,
    master: Option<Station<Master>>,
    slaves: Vec<(NodeId, Station<TestSlave>)>,
    /// Every frame that went over a bus: milliseconds, bus, frame.
    log: Vec<(u64, Bus, Frame)>,
}

impl Fleet {
    /// Everybody powered on at once.
    fn new(profile: &Profile, slaves: impl IntoIterator<Item = u8>) -> Self {
        let mut fleet = Fleet { now: 0, master: None, slaves: vec![], log: vec![] };
        fleet.power_master(profile);
        for raw in slaves {
            let slave = instrument::slave(node(raw), profile, vec![]);
            let filters = slave.filters();
            fleet.slaves.push((node(raw), Station::new(0, slave, filters)));
        }
        fleet
    }

    /// A master, or the master again after a reset.
    fn power_master(&mut self, profile: &Profile) {
        let master = console::master(profile);
        let filters = master.filters();
        let mut station = Station::new(self.now, master, filters);
        if let Some(old) = &self.master {
            station.connected = old.connected;
        }
        self.master = Some(station);
    }

    fn run_until(&mut self, until: u64) {
        while self.now < until {
            self.now += 1;
            let now = ms(self.now);
            if let Some(master) = &mut self.master {
                master.bench.run_until(now);
            }
            self.slaves.iter_mut().for_each(|(_, slave)| slave.bench.run_until(now));
            // Causes and effects of one millisecond: a switch, its heartbeat, the answers.
            for _ in 0..6 {
                self.exchange();
            }
        }
    }

    fn exchange(&mut self) {
        let slaves_on =
            PerBus::from_fn(|bus| self.slaves.iter().filter(|(_, slave)| slave.is_on(bus)).count());
        let master_on = PerBus::from_fn(|bus| self.master.as_ref().is_some_and(|master| master.is_on(bus)));
        let mut frames = vec![];
        if let Some(master) = &mut self.master {
            master.collect();
            let acknowledged = PerBus::from_fn(|bus| slaves_on[bus] > 0);
            frames.extend(master.transmit(acknowledged).into_iter().map(|(bus, frame)| (None, bus, frame)));
        }
        for (id, slave) in &mut self.slaves {
            slave.collect();
            let acknowledged = PerBus::from_fn(|bus| slaves_on[bus] > 1 || master_on[bus]);
            frames
                .extend(slave.transmit(acknowledged).into_iter().map(|(bus, frame)| (Some(*id), bus, frame)));
        }
        for (sender, bus, frame) in frames {
            self.log.push((self.now, bus, frame));
            if let Some(master) = self.master.as_mut().filter(|master| sender.is_some() && master.is_on(bus))
            {
                master.hear(bus, frame);
            }
            for (_, slave) in
                self.slaves.iter_mut().filter(|(id, slave)| Some(*id) != sender && slave.is_on(bus))
            {
                slave.hear(bus, frame);
            }
        }
    }

    fn master(&mut self) -> &mut Station<Master> {
        self.master.as_mut().expect("there is a master")
    }

    fn slave(&mut self, raw: u8) -> &mut Station<TestSlave> {
        let found = self.slaves.iter_mut().find(|(id, _)| id.get() == raw);
        found.map(|(_, slave)| slave).expect("there is such a slave")
    }

    /// Sends a command to every slave; returns those that got it within two milliseconds.
    fn commanded(&mut self) -> Vec<u8> {
        let ids: Vec<NodeId> = self.slaves.iter().map(|(id, _)| *id).collect();
        self.slaves.iter_mut().for_each(|(_, slave)| slave.bench.clear_events());
        for id in &ids {
            let message = [1, 0, id.get(), 0, 0, 0, 0, 0];
            // Those that are not Operational are not commanded.
            let _ = self.master().bench.touch(|master, now| console::command(master, *id, message, now));
        }
        self.run_until(self.now + 2);
        let got = |slave: &Station<TestSlave>, id: &NodeId| {
            let message = [1, 0, id.get(), 0, 0, 0, 0, 0];
            slave.bench.events.iter().any(
                |event| matches!(event, SlaveEvent::Pdo(pdo) if (pdo.number(), pdo.data) == (1, message)),
            )
        };
        self.slaves.iter().filter(|(id, slave)| got(slave, id)).map(|(id, _)| id.get()).collect()
    }

    fn switches(&mut self) -> Vec<(Bus, SwitchCause)> {
        let events = self.master().bench.events.iter();
        events
            .filter_map(|event| match event {
                MasterEvent::BusSwitched { to, cause, .. } => Some((*to, *cause)),
                _ => None,
            })
            .collect()
    }
}

/// Verifies: ECSS 8.3.2a
/// Notices: ECSS 8.3.2a: a slave begins on the redundant bus.
#[test]
fn all_are_operational_and_commanded_in_one_heartbeat_period() {
    let mut fleet = Fleet::new(&STANDARD, 2..=4);
    fleet.run_until(100);
    assert_eq!(fleet.commanded(), [2, 3, 4]);
    assert_eq!(fleet.switches(), []);
    assert!(fleet.log.iter().all(|(_, bus, _)| *bus == NOMINAL));
}

/// Verifies: ECSS 8.2.1a.1, 8.3.3e, 8.3.3e.2, 8.3.3f
/// Notices: ECSS 8.3.3e.2: a slave with selective access does not leave the bus of a silent master.
/// Notices: ECSS 8.3.3f: a slave that toggled is not started on the new bus.
#[test]
fn after_near_cut_parallel_slaves_follow_then_the_selective_one() {
    let mut fleet = Fleet::new(&SLOW, 2..=4);
    fleet.run_until(20_000);
    fleet.master().connected.nominal = false;
    fleet.run_until(20_260);
    assert_eq!(fleet.switches(), [(REDUNDANT, SwitchCause::Isolated)]);
    assert_eq!(fleet.commanded(), [2, 3]);
    // The last heartbeat on the nominal bus was at 20 s: 5 x 2.5 s later slave 4 toggles.
    fleet.run_until(32_499);
    assert!(!fleet.slave(4).joined.redundant);
    fleet.run_until(32_501);
    assert!(fleet.slave(4).joined.redundant);
    fleet.run_until(33_000);
    assert_eq!(fleet.commanded(), [2, 3, 4]);
    assert_eq!(fleet.switches().len(), 1);
}

/// Verifies: ECSS 8.3.3b.2
/// Notices: ECSS 8.3.3b.2: after a commanded switch the heartbeat on the new bus waits for its period.
#[test]
fn a_commanded_switch_loses_no_command_of_parallel_slaves() {
    let mut fleet = Fleet::new(&STANDARD, 2..=4);
    fleet.run_until(1_050);
    fleet.master().bench.request(MasterRequest::SwitchBus(REDUNDANT));
    assert_eq!(fleet.commanded(), [2, 3, 4]);
    let states = |slave: &Station<TestSlave>| {
        slave.bench.events.contains(&SlaveEvent::State(NmtState::PreOperational))
    };
    assert!(!fleet.slaves.iter().any(|(_, slave)| states(slave)));
    // The first frame on the new bus is the heartbeat of the master.
    let first = fleet.log.iter().find(|(_, bus, _)| *bus == REDUNDANT).unwrap();
    assert_eq!(first.2.id().raw(), 0x701);
}

/// Given a master that is cut off on the nominal bus at 1050 ms, and changes the bus with its heartbeat of 1100 ms, which expires at
/// 1200 ms. When the cut heals before or after that, then no frame comes on the nominal bus.
///
/// Verifies: ECSS 8.3.3b.1
/// Notices: ECSS 8.3.3b.1: the master sends its heartbeat on both buses after a change.
/// Notices: ECSS 8.3.3b.1: a heartbeat that waits on the bus that the master left stays there.
#[test]
fn nothing_stale_goes_out_after_a_cut_heals() {
    for healed in [1_150, 3_000] {
        let mut fleet = Fleet::new(&STANDARD, 2..=4);
        fleet.run_until(1_050);
        fleet.master().connected.nominal = false;
        fleet.run_until(healed);
        assert_eq!(fleet.switches().len(), 1);
        fleet.master().connected.nominal = true;
        fleet.log.clear();
        fleet.run_until(5_000);
        assert!(fleet.log.iter().all(|(_, bus, _)| *bus == REDUNDANT), "healed at {healed} ms");
        assert_eq!(fleet.commanded(), [2, 3, 4]);
        assert_eq!(fleet.switches().len(), 1);
    }
}

#[test]
fn a_master_long_before_its_slaves_does_not_switch() {
    let mut fleet = Fleet::new(&SLOW, []);
    fleet.run_until(5_000);
    for raw in 2..=4 {
        let slave = instrument::slave(node(raw), &SLOW, vec![]);
        let filters = slave.filters();
        fleet.slaves.push((node(raw), Station::new(5_000, slave, filters)));
    }
    fleet.run_until(6_000);
    assert_eq!(fleet.switches(), []);
    assert_eq!(fleet.commanded(), [2, 3, 4]);
}

/// Verifies: ECSS 8.3.3f, 8.3.3k
/// Notices: ECSS 8.3.3f: the master starts a slave only at its boot-up message.
#[test]
fn slaves_long_before_master_are_found_wherever_they_listen() {
    for wait in [300, 700, 1_300, 10_000] {
        let mut fleet = Fleet::new(&SELECTIVE, 2..=4);
        fleet.master = None;
        fleet.run_until(wait);
        fleet.power_master(&STANDARD);
        fleet.run_until(wait + 2_000);
        assert_eq!(fleet.commanded(), [2, 3, 4], "after {wait} ms");
    }
}

/// The master loses both buses for a while and gets these back; who is commanded in the end?
fn after_an_outage(milliseconds: u64, restored: &[Bus]) -> Vec<u8> {
    let mut fleet = Fleet::new(&SELECTIVE, 2..=4);
    fleet.run_until(1_050);
    fleet.master().connected = PerBus::default();
    fleet.run_until(1_050 + milliseconds);
    for bus in restored {
        fleet.master().connected[*bus] = true;
    }
    fleet.run_until(1_050 + milliseconds + 15_000);
    fleet.commanded()
}

/// Verifies: ECSS 8.3.3f
#[test]
fn both_buses_cut_then_one_or_both_restored_reaches_all_slaves() {
    for outage in [200, 700, 1_000, 1_600, 3_000] {
        for restored in [&[NOMINAL][..], &[REDUNDANT], &[NOMINAL, REDUNDANT]] {
            assert_eq!(after_an_outage(outage, restored), [2, 3, 4], "{outage} ms, {restored:?}");
        }
    }
}

/// Verifies: ECSS 8.3.3j
#[test]
fn after_giving_up_selective_slave_is_reached_where_it_listens() {
    // After 25.5 s. Ntoggle is even: it listens on the default bus.
    assert_eq!(after_an_outage(27_000, &[NOMINAL]), [2, 3, 4]);
    assert_eq!(after_an_outage(27_000, &[REDUNDANT]), [2, 3]);
}

#[test]
fn a_master_that_is_reset_in_flight_takes_its_slaves_up_again() {
    for nominal in [true, false] {
        let mut fleet = Fleet::new(&SELECTIVE, 2..=4);
        fleet.run_until(1_050);
        fleet.master().connected.nominal = false;
        fleet.run_until(5_000);
        assert_eq!(fleet.commanded(), [2, 3, 4]);
        // Given everybody on the redundant bus, and the nominal one whole again or not, when the master is reset
        fleet.master().connected.nominal = nominal;
        fleet.power_master(&SELECTIVE);
        // Slaves that it does not know are asked where it is: a dwell of 10 s on the dead bus.
        fleet.run_until(if nominal { 9_000 } else { 17_000 });
        assert_eq!(fleet.commanded(), [2, 3, 4], "nominal whole: {nominal}");
    }
}

#[test]
fn a_slave_cut_off_on_one_bus_takes_all_to_the_other_one() {
    let mut fleet = Fleet::new(&STANDARD, 2..=4);
    fleet.run_until(1_050);
    fleet.slave(3).connected.nominal = false;
    fleet.run_until(5_000);
    assert_eq!(fleet.switches(), [(REDUNDANT, SwitchCause::Tried)]);
    assert_eq!(fleet.commanded(), [2, 3, 4]);
    fleet.slave(3).connected.nominal = true;
    fleet.run_until(9_000);
    assert_eq!(fleet.commanded(), [2, 3, 4]);
}
