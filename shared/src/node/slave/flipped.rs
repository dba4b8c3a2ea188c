//! A running slave whose memory has a flipped bit.

extern crate std;

use std::vec::Vec;

use crate::heartbeat::ConsumerSlots;
use crate::heartbeat::machine::NodeControl;
use crate::link::Stamp;
use crate::node::extend::Outbox;
use crate::node::probe::{Probe, TwoServers};
use crate::node::services::SpacecraftServices;
use crate::node::{
    BusCommand, DeviceNode, LinkEvent, Node, NodeObjects, Slave, SlaveEvent, SpacecraftDevice, Turn,
};
use crate::profile::Profile;
use crate::redundancy::Parameters;
use crate::sdo::TwoSdoServers;
use crate::types::{Address, Bus, CobId, Duration, Frame, Instant, NodeId};

const ID: NodeId = NodeId::of::<5>();

/// A slave whose frames are all acknowledged at once.
struct Bench<D: SpacecraftDevice = Probe> {
    slave: Slave<D>,
    now: Instant,
    sent: Vec<Frame>,
    /// Filters that were sent to the nominal bus.
    filters: usize,
}

impl Bench {
    fn new() -> Self {
        Self::of(Probe::default())
    }
}

impl<D: SpacecraftDevice> Bench<D> {
    fn of(device: D) -> Self {
        let slave = Slave::builder(ID, &Profile::DEFAULT, device).build();
        let mut bench = Bench { slave, now: Instant::ZERO, sent: Vec::new(), filters: 0 };
        bench.with(|slave, turn| slave.start(turn));
        bench.heartbeats(2);
        (bench.filters, bench.sent) = (0, Vec::new());
        bench
    }

    fn with(&mut self, step: impl FnOnce(&mut Slave<D>, &mut Turn<'_, SlaveEvent>)) {
        let mut out = Outbox::new();
        step(&mut self.slave, &mut Turn::new(self.now, &mut out));
        let mut ended = Vec::new();
        while let Some((bus, command)) = out.pop_command() {
            match command {
                BusCommand::Send(outgoing) => ended.push((bus, outgoing.frame)),
                BusCommand::Filter { .. } if bus == Bus::Nominal => self.filters += 1,
                _ => {}
            }
        }
        for (bus, frame) in ended {
            self.sent.push(frame);
            self.link(bus, &LinkEvent::Transmitted { frame, stamp: Stamp::interrupt(self.now) });
        }
    }

    fn link(&mut self, bus: Bus, event: &LinkEvent) {
        self.with(|slave, turn| slave.on_link(bus, event, turn));
    }

    /// Lets the slave run until it has sent this number of heartbeats.
    fn heartbeats(&mut self, number: usize) {
        let heartbeats = |bench: &Self| {
            bench.sent.iter().filter(|frame| frame.id().function() == CobId::heartbeat(ID).function()).count()
        };
        let until = heartbeats(self) + number;
        while heartbeats(self) < until {
            self.now = self.slave.deadline().expect("heartbeats have a period").max(self.now);
            self.with(|slave, turn| slave.poll(turn));
        }
    }

    fn objects_mut(&mut self) -> &mut NodeObjects<D> {
        self.slave.canopen.services_mut().objects_mut()
    }

    fn mended(&self) -> u16 {
        self.slave.objects().extension.identity.mended
    }
}

/// Given a running slave, when a bit of a COB-ID in its objects flips, then it is right again within 32 heartbeats, the slave counts
/// it, sends its filters again, and reports it.
///
/// Verifies: ECSS 6.10d
#[test]
fn a_flipped_cob_id_is_mended_while_the_slave_runs() {
    let mut bench = Bench::new();
    bench.objects_mut().pdos.rpdos[0].cob_id ^= 1 << 1;
    bench.heartbeats(32);
    let objects = bench.slave.objects();
    assert_eq!((objects.pdos.rpdos[0].cob_id, bench.mended()), (0x205, 1));
    assert!(bench.filters > 0, "a bus may have the filter of the false COB-ID");
    let reports = bench.sent.iter().filter(|frame| frame.id() == CobId::emcy(ID) && frame.data()[1] == 0x50);
    assert_eq!(reports.count(), 1);
}

/// SYNCs with this identifier that the slave reports.
fn syncs(bench: &mut Bench, id: u16) -> usize {
    let mut out = Outbox::new();
    let frame = Frame::new(CobId::new(id).unwrap(), &[]).unwrap();
    let stamp = Stamp::interrupt(bench.now);
    let event = LinkEvent::Received { frame, stamp };
    bench.slave.on_link(Bus::Nominal, &event, &mut Turn::new(bench.now, &mut out));
    std::iter::from_fn(|| out.pop_event()).filter(|event| matches!(event, SlaveEvent::Sync { .. })).count()
}

/// Given a running slave, which consumes SYNC, when a bit of its 1005h flips, then it takes no other frame for a SYNC, SYNC goes on to
/// arrive, and 1005h is 80h again within 32 heartbeats.
///
/// Verifies: ECSS 6.10d
/// Notices: ECSS 6.10d: the COB-ID of SYNC in use is that in 1005h, whatever flipped there.
/// Notices: ECSS 6.10d: a flipped bit of 1005h stays.
#[test]
fn a_flipped_bit_of_1005h_gives_a_consumer_no_false_sync() {
    for bit in 0..32 {
        let mut bench = Bench::new();
        assert_eq!((syncs(&mut bench, 0x080), syncs(&mut bench, 0x081)), (1, 0));
        bench.objects_mut().communication.sync.cob_id ^= 1 << bit;
        if bit < 11 {
            assert_eq!(syncs(&mut bench, 0x080 ^ 1 << bit), 0, "bit {bit}");
        }
        assert_eq!(syncs(&mut bench, 0x080), 1, "bit {bit}");
        bench.heartbeats(32);
        assert_eq!(bench.slave.objects().communication.sync.cob_id, 0x80);
        assert_eq!((bench.mended(), syncs(&mut bench, 0x080)), (1, 1), "bit {bit}");
    }
}

/// Given a running slave, when a bit of its Node-ID flips, then the next heartbeat has the right one, and the slave counts it.
///
/// Verifies: ECSS 6.10k
#[test]
fn a_flipped_node_id_is_mended_before_the_next_heartbeat() {
    let mut bench = Bench::new();
    bench.slave.canopen.control_mut().set_id(NodeId::of::<7>());
    bench.heartbeats(1);
    let heartbeats: Vec<CobId> = bench.sent.iter().map(Frame::id).filter(|id| id.raw() > 0x700).collect();
    assert_eq!((heartbeats, bench.mended()), ([CobId::heartbeat(ID)].to_vec(), 1));
}

/// Given a running slave whose Node-ID is false where its heartbeats are made, too, then the next heartbeat has the right one.
///
/// Verifies: ECSS 6.10k
/// Notices: ECSS 6.10k: a false Node-ID stays where heartbeats are made.
#[test]
fn a_flipped_node_id_of_heartbeats_is_mended_too() {
    let mut bench = Bench::new();
    let mut control = NodeControl::new(NodeId::of::<7>(), Profile::DEFAULT.heartbeat, Duration::ZERO, false);
    control.boot(bench.now);
    *bench.slave.canopen.control_mut() = control;
    bench.heartbeats(1);
    let heartbeats: Vec<CobId> = bench.sent.iter().map(Frame::id).filter(|id| id.raw() > 0x700).collect();
    assert_eq!(heartbeats, [CobId::heartbeat(ID)]);
}

/// Given a running slave, when a bit of its Node-ID flips, then it obeys no command for the node that the false one names.
///
/// Verifies: ECSS 6.10k
#[test]
fn a_command_for_the_false_node_id_is_not_obeyed() {
    let mut bench = Bench::new();
    bench.slave.canopen.control_mut().set_id(NodeId::of::<7>());
    let command = Frame::of(CobId::NMT, [0x02, 7]);
    let stamp = Stamp::interrupt(bench.now);
    bench.link(Bus::Nominal, &LinkEvent::Received { frame: command, stamp });
    assert_eq!(bench.slave.canopen.state(), crate::types::NmtState::PreOperational);
    assert_eq!(bench.mended(), 1);
}

/// Given a slave that is silent because it sent too many frames, when a bit of its Node-ID flips just before the silence ends, then its
/// boot-up message has the right one.
///
/// Verifies: ECSS 6.10k
/// Notices: ECSS 6.10k: the boot-up message after a silence has a Node-ID with a flipped bit.
#[test]
fn a_flipped_node_id_is_mended_before_the_boot_after_a_silence() {
    let mut bench = Bench::new();
    let silenced_at = bench.now;
    // Three COB-IDs of 128 frames each; the node may send 256.
    bench.with(|slave, turn| {
        for id in [0x185, 0x285, 0x385].map(|raw| CobId::new(raw).unwrap()) {
            (0..128).for_each(|_| {
                slave.charge(&Frame::of(id, []), turn);
            });
        }
    });
    let resumed_at = silenced_at + Profile::DEFAULT.budget.silence;
    while bench.slave.deadline().is_some_and(|due| due < resumed_at) {
        bench.heartbeats(1);
    }
    bench.sent.clear();
    bench.slave.canopen.control_mut().set_id(NodeId::of::<7>());
    bench.now = resumed_at;
    bench.with(|slave, turn| slave.poll(turn));
    assert_eq!(bench.sent[0], Frame::of(CobId::heartbeat(ID), [0]));
    assert_eq!(bench.mended(), 1);
}

/// Payloads that the second SDO server answers a request for 1000h with.
fn answers_of_second_server(bench: &mut Bench<TwoServers>) -> usize {
    bench.sent.clear();
    let frame = Frame::of(CobId::new(0x6C5).unwrap(), [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    let stamp = Stamp::interrupt(bench.now);
    bench.link(Bus::Nominal, &LinkEvent::Received { frame, stamp });
    bench.sent.iter().filter(|frame| frame.id().raw() == 0x6B5).count()
}

/// Given a slave with a valid second SDO channel, when a bit of one of its COB-IDs flips, in 1201h or where the server has it, then both
/// COB-IDs are right again within 32 heartbeats, the slave counts it, and the channel works.
///
/// Verifies: ECSS 6.10d
#[test]
fn a_flipped_cob_id_of_the_second_sdo_server_is_mended() {
    let entries = [0x6C5, 0x6B5_u32];
    for sub in [1, 2] {
        for bit in 0..32 {
            let mut bench = Bench::of(TwoServers::default());
            for (sub, entry) in (1..).zip(entries) {
                let at = Address::new(TwoSdoServers::SECOND.index(), sub);
                bench.with(|slave, turn| assert_eq!(slave.write(at, &entry.to_le_bytes(), turn), Ok(())));
            }
            assert_eq!(answers_of_second_server(&mut bench), 1);
            let second = &mut bench.objects_mut().sdo.second;
            *(if sub == 1 { &mut second.request } else { &mut second.response }) ^= 1 << bit;
            assert_eq!(answers_of_second_server(&mut bench), 1, "the server has copies of its own");
            bench.heartbeats(32);
            let second = bench.slave.objects().sdo.second;
            assert_eq!([second.request, second.response], entries, "sub {sub}, bit {bit}");
            assert_eq!(
                (bench.mended(), answers_of_second_server(&mut bench)),
                (1, 1),
                "sub {sub}, bit {bit}"
            );
        }
    }
}

/// Flips a bit of a slave.
type Flip = fn(&mut Bench, u32);

/// Given a running slave, when any bit of its heartbeat period, consumer time or redundancy parameters flips, in the objects or
/// where they are in use, then all are right again within 32 heartbeats, and the slave counts it.
#[test]
fn a_flipped_redundancy_parameter_is_mended() {
    let cases: [(&str, u32, Flip); 6] = [
        ("1017h", 16, |bench, bit| bench.objects_mut().communication.heartbeat.time ^= 1 << bit),
        ("1016h", 32, |bench, bit| bench.objects_mut().consumers.entries_mut()[0] ^= 1 << bit),
        ("Ttoggle", 8, |bench, bit| bench.objects_mut().extension.redundancy.parameters.ttoggle ^= 1 << bit),
        ("Ntoggle", 8, |bench, bit| bench.objects_mut().extension.redundancy.parameters.ntoggle ^= 1 << bit),
        ("consumer time in use", 40, |bench, bit| {
            let mut parameters = *bench.slave.redundancy.parameters();
            parameters.consumer = Duration::from_micros(parameters.consumer.as_micros() ^ 1 << bit);
            bench.slave.redundancy.no_sooner().configure(parameters);
        }),
        ("Ttoggle in use", 8, |bench, bit| {
            let mut parameters = *bench.slave.redundancy.parameters();
            parameters.ttoggle ^= 1 << bit;
            bench.slave.redundancy.no_sooner().configure(parameters);
        }),
    ];
    // Its search counts in Ctoggle.
    let right = |bench: &Bench| {
        let written = bench.slave.canopen.services().written_redundancy();
        let in_use = *bench.slave.redundancy.parameters();
        let [written, in_use] = [written, in_use].map(|all| Parameters { ctoggle: 0, ..all });
        (written, in_use, bench.slave.canopen.control().period())
    };
    for (name, bits, flip) in cases {
        for bit in 0..bits {
            let mut bench = Bench::new();
            let before = right(&bench);
            assert_eq!((before.0, before.2), (before.1, before.0.producer));
            flip(&mut bench, bit);
            bench.heartbeats(32);
            assert_eq!(right(&bench), before, "{name}, bit {bit}");
            assert!(bench.mended() > 0, "{name}, bit {bit}");
        }
    }
}

/// Given a running slave that is not above its budget, when a bit says that it is silent, then that ends with the next heartbeat.
#[test]
fn a_slave_silenced_by_a_flipped_bit_is_not_silent() {
    let mut bench = Bench::new();
    bench.with(|slave, turn| {
        slave.decide(turn, |redundancy, step| redundancy.silence(step));
    });
    assert!(bench.slave.redundancy.is_silenced());
    bench.heartbeats(1);
    assert!(!bench.slave.redundancy.is_silenced());
}
