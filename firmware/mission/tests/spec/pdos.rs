//! Objects and PDOs: slaves receive what the master sends, and the other way round.

use ecss_can::link::Stamp;
use ecss_can::node::extend::{BusCommand, LinkEvent};
use ecss_can::node::extend::{Outbox, Turn};
use ecss_can::node::{Device as _, Refusal, Slave, SlaveEvent};
use ecss_can::node::{DeviceNode, Master, MasterEvent, MasterRequest, Node, NodeObjects};
use ecss_can::od::{Objects, U40, U48};
use ecss_can::pdo::{Mapping, PdoObjects, ReceivedPdo};
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, Duration, Frame, Instant, Scet};
use mission::{
    Command, CommanderObjects, LIBRECUBE, Message, MissionObjects, REQUEST, Received, Request, SLAVES,
    STANDARD, TELECOMMAND, Telemetry, master, received, slave, slot,
};

use crate::{frame, ms, node};

type Commander = Master<CommanderObjects>;
type Obeyer = Slave<MissionObjects<Vec<u8>>>;

/// A node under test: frames of the nominal bus in and out.
struct Desk<N: Node> {
    node: N,
    out: Outbox<N::Event, N::Depth>,
}

impl<N: Node> Desk<N> {
    fn new(node: N) -> Self {
        let mut desk = Desk { node, out: Outbox::new() };
        desk.node.start(&mut Turn::new(Instant::ZERO, &mut desk.out));
        desk
    }

    fn hear(&mut self, frame: Frame) {
        self.node.on_received(
            Bus::Nominal,
            &frame,
            &Stamp::interrupt(ms(1)),
            &mut Turn::new(ms(1), &mut self.out),
        );
    }

    /// Returns the frames sent since the last call, including those that are due.
    fn sent(&mut self) -> Vec<Frame> {
        self.node.poll(&mut Turn::new(ms(1), &mut self.out));
        let commands = std::iter::from_fn(|| self.out.pop_command());
        let frames = commands.filter_map(|(_, command)| match command {
            BusCommand::Send(outgoing) => Some(outgoing.frame),
            _ => None,
        });
        frames.collect()
    }

    fn events(&mut self) -> Vec<N::Event> {
        std::iter::from_fn(|| self.out.pop_event()).collect()
    }
}

/// Returns a master whose heartbeat was acknowledged, and that has received Operational from slave 3.
fn flying() -> Desk<Commander> {
    let mut desk = Desk::new(master(&STANDARD).build());
    let event = LinkEvent::Transmitted { frame: frame(0x701, &[5]), stamp: Stamp::interrupt(Instant::ZERO) };
    desk.node.on_link(Bus::Nominal, &event, &mut Turn::new(Instant::ZERO, &mut desk.out));
    desk.hear(frame(0x703, &[5]));
    desk.sent();
    desk.events();
    desk
}

fn operational() -> Desk<Obeyer> {
    let mut desk = Desk::new(slave(node(3), &STANDARD, vec![]).build());
    desk.hear(frame(0x701, &[5]));
    desk.hear(frame(0x000, &[1, 3]));
    desk.sent();
    desk.events();
    desk
}

#[test]
fn slaves_2_to_15_have_a_slot_and_no_others() {
    assert_eq!([1, 2, 15, 16, 127].map(|raw| slot(node(raw))), [None, Some(0), Some(13), None, None]);
}

/// Verifies: ECSS 6.2a
#[test]
fn a_command_of_the_master_is_a_pdo_of_the_slave() {
    let (mut master, mut slave) = (flying(), operational());
    let message = Command::SetValue(0xDEAD_BEEF).encode(7);
    assert_eq!(master.node.send_to(node(3), TELECOMMAND, message.telecommand(), ms(1)), Ok(()));
    let sent = master.sent();
    let data = [2, 0, 0xEF, 0xBE, 0xAD, 0xDE, 0, 7];
    assert_eq!(sent, [frame(0x303, &data)]);
    slave.hear(sent[0]);
    let [SlaveEvent::Pdo(pdo)] = slave.events()[..] else { panic!("one PDO") };
    assert_eq!(pdo.get(TELECOMMAND), Some((2, U40::new(0xDEAD_BEEF), 7)));
    let telecommand = slave.node.objects().application.telecommand;
    assert_eq!((telecommand.code, telecommand.data.get(), telecommand.sequence), (2, 0xDEAD_BEEF, 7));
}

/// Verifies: ECSS 6.2a
#[test]
fn telemetry_answers_a_request() {
    let (mut master, mut slave) = (flying(), operational());
    assert_eq!(master.node.send_to(node(3), REQUEST, Request::Value.encode().values(), ms(1)), Ok(()));
    let sent = master.sent();
    assert_eq!(sent, [frame(0x403, &[2, 1, 0, 0, 0, 0, 0, 0])]);
    slave.hear(sent[0]);
    let [SlaveEvent::Pdo(pdo)] = slave.events()[..] else { panic!("one PDO") };
    assert_eq!(pdo.get(REQUEST), Some((0x102, U48::new(0))));
    // Figure 9-2: a request may leave out its data.
    slave.hear(frame(0x403, &[2, 1]));
    assert_eq!(slave.events().len(), 1);

    slave.node.change(ms(1), |objects| objects.telemetry = Telemetry::Value(42).encode().into());
    slave.node.send_pdo(2, ms(1));
    let sent = slave.sent();
    assert_eq!(sent, [frame(0x383, &[2, 1, 42, 0, 0, 0, 0, 0])]);
    master.hear(sent[0]);
    let [MasterEvent::Pdo(pdo)] = master.events()[..] else { panic!("one PDO") };
    let message = Message::new(0x102, [42, 0, 0, 0, 0, 0]);
    assert_eq!(received(&pdo), Some((node(3), Received::Telemetry(message))));
}

/// Given the master of the mission, then it sends each telecommand and telemetry request immediately and once, also two
/// of them to one slave at the same instant.
///
/// Verifies: ECSS 9.4.1d
/// Notices: ECSS 9.4.1d: telecommands of the master have an inhibit time of 10 ms.
#[test]
fn the_master_delays_no_command_and_no_request_and_repeats_none() {
    let mut master = flying();
    for value in [7_u8, 8] {
        let message = Command::SetValue(value.into()).encode(value);
        assert_eq!(master.node.send_to(node(3), TELECOMMAND, message.telecommand(), ms(1)), Ok(()));
        assert_eq!(master.sent(), [frame(0x303, &[2, 0, value, 0, 0, 0, 0, value])]);
    }
    for (asked, code) in [(Request::Value, [2, 1]), (Request::Executed, [3, 1])] {
        assert_eq!(master.node.send_to(node(3), REQUEST, asked.encode().values(), ms(1)), Ok(()));
        assert_eq!(master.sent(), [frame(0x403, &[code[0], code[1], 0, 0, 0, 0, 0, 0])]);
    }
}

/// Returns the mapping of a time PDO in the order of Figure 7-1: fine time, then coarse time, of the object with this
/// index.
fn figure_7_1(index: u32) -> [u32; 2] {
    [index << 16 | 0x0218, index << 16 | 0x0120]
}

/// Returns the COB-IDs of the transmit PDOs that carry the local time, 2011h.
fn times(objects: &PdoObjects<8, 8>) -> Vec<u32> {
    let pdos = objects.tpdos.iter().zip(&objects.tpdo_mappings);
    let of_time = pdos.filter(|(_, mapping)| mapping.objects().iter().any(|object| object >> 16 == 0x2011));
    of_time.map(|(pdo, _)| pdo.cob_id & 0x7FF).collect()
}

/// Given the nodes of the mission at power-on, then the master maps its Local SCET Get to 181h, a slave maps its Local SCET Set to
/// 181h, and no other transmit PDO has this COB-ID or another time of the master.
///
/// Verifies: ECSS 7.2.2a, 7.2.2c, 7.2.2d, 7.2.3a, 7.2.3g
/// Notices: ECSS 7.2.2a: the master maps the coarse time before the fine time.
/// Notices: ECSS 7.2.2c: a slave takes the time at 180h and its own Node-ID.
/// Notices: ECSS 7.2.2d: slaves send their local time by 181h.
/// Notices: ECSS 7.2.3a: the master maps the coarse time alone.
/// Notices: ECSS 7.2.3g: a slave maps the coarse time before the fine time.
/// Notices: ECSS 7.2.2d: another PDO of the master has its time behind another object.
#[test]
fn spacecraft_time_is_get_at_the_master_and_set_at_each_slave() {
    let master = master(&STANDARD).build();
    let pdos = &master.objects().pdos;
    assert_eq!(pdos.tpdos[0].cob_id & 0x8000_07FF, 0x181);
    assert_eq!(pdos.tpdo_mappings[0].objects(), figure_7_1(0x2011));
    assert!(pdos.tpdos[1..].iter().all(|pdo| pdo.cob_id & 0x7FF != 0x181));
    let mut others = pdos.tpdo_mappings[1..].iter().flat_map(Mapping::objects);
    assert!(others.all(|object| object >> 16 != 0x2011));
    for raw in 2..=15 {
        let slave = slave(node(raw), &STANDARD, vec![]).build();
        let pdos = &slave.objects().pdos;
        assert_eq!(pdos.rpdos[0].cob_id & 0x8000_07FF, 0x181, "slave {raw}");
        assert_eq!(pdos.rpdo_mappings[0].objects(), figure_7_1(0x2010), "slave {raw}");
        assert!(pdos.tpdos.iter().all(|pdo| pdo.cob_id & 0x7FF != 0x181), "slave {raw}");
    }
}

/// Given a slave of the mission, when 181h comes after a SYNC, then its bytes are fine time and coarse time, both little-endian.
///
/// Verifies: ECSS 7.1.2f, 7.2.2c, 7.2.3g
/// Notices: ECSS 7.1.2f: a slave maps the coarse time of Local SCET Set before the fine time.
#[test]
fn spacecraft_time_is_taken_as_figure_7_1_has_it() {
    let mut slave = operational();
    slave.hear(frame(0x080, &[]));
    slave.events();
    slave.hear(frame(0x181, &[0x56, 0x34, 0x12, 0xEF, 0xCD, 0xAB, 0x89]));
    let time = Scet::new(0x89AB_CDEF, 0x12_3456).unwrap();
    assert!(slave.events().contains(&SlaveEvent::Time(time)));
}

/// Given a slave of the mission with each Node-ID of a slave, then at power-on it has one transmit PDO with its Local SCET Get: 180h and
/// its Node-ID.
///
/// Verifies: ECSS 7.1.2f, 7.2.2e, 7.2.2g, 7.2.3h, 7.2.3j
/// Notices: ECSS 7.1.2f: a slave maps the coarse time of Local SCET Get before the fine time.
/// Notices: ECSS 7.2.2e: a slave maps the coarse time alone.
/// Notices: ECSS 7.2.2g: a second PDO of a slave has its coarse time.
/// Notices: ECSS 7.2.2g: slave 66 has the Local Time PDO of slave 2.
/// Notices: ECSS 7.2.3h: a slave sends the coarse time before the fine time.
/// Notices: ECSS 7.2.3j: all slaves share one COB-ID for their local times.
#[test]
fn each_slave_has_one_local_time_pdo() {
    for raw in 2..=126 {
        let slave = slave(node(raw), &STANDARD, vec![]).build();
        let pdos = &slave.objects().pdos;
        assert_eq!(times(pdos), [0x180 + u32::from(raw)], "slave {raw}");
        assert_eq!(pdos.tpdo_mappings[0].objects(), figure_7_1(0x2011), "slave {raw}");
        assert_eq!(pdos.tpdos[0].cob_id >> 31, 0, "slave {raw}: it is valid");
    }
}

/// Given SYNC every 100 ms and a time every second, when ten SYNCs were sent, then only the last one is followed by
/// 181h, which sets the clock of a slave to the time at that SYNC. The slave answers a SYNC with its local time. TIME
/// of CANopen, 100h, is neither sent nor accepted.
///
/// Verifies: ECSS 7.2.3b, 7.2.3e, 7.2.3f, 7.2.3i, 9.4.7.1b
/// Notices: ECSS 7.2.3e: the master sends the time by type 255.
/// Notices: ECSS 7.2.3f: the master sends the time by 100h.
/// Notices: ECSS 7.2.3i: the local time is acyclic: a SYNC alone does not send it.
/// Notices: ECSS 9.4.7.1b: a master whose time is set sends a time stamp.
#[test]
fn time_of_the_master_reaches_a_slave_by_its_pdo_alone() {
    let (mut master, mut slave) = (flying(), operational());
    let time = Scet::new(1_000, 0).unwrap();
    master.node.on_request(MasterRequest::SetTime(time), &mut Turn::new(ms(1), &mut master.out));
    let sync = LinkEvent::Transmitted { frame: frame(0x080, &[]), stamp: Stamp::interrupt(ms(1)) };
    for nth in 1..=10 {
        master.node.on_link(Bus::Nominal, &sync, &mut Turn::new(ms(1), &mut master.out));
        let ids = [0x100, 0x181];
        let sent: Vec<_> = master.sent().into_iter().filter(|sent| ids.contains(&sent.id().raw())).collect();
        let spacecraft_time = frame(0x181, &[0, 0, 0, 0xE8, 3, 0, 0]);
        assert_eq!(sent, if nth == 10 { vec![spacecraft_time] } else { vec![] }, "SYNC {nth}");
    }
    slave.hear(frame(0x080, &[]));
    slave.events();
    let local_times = slave.sent().iter().filter(|sent| sent.id().raw() == 0x183).count();
    assert_eq!(local_times, 1, "it answers each SYNC");
    // 1 s after midnight of day 1.
    slave.hear(frame(0x100, &[0xE8, 3, 0, 0, 1, 0]));
    assert_eq!(slave.events(), []);
    slave.hear(frame(0x181, &[0, 0, 0, 0xE8, 3, 0, 0]));
    assert!(slave.events().contains(&SlaveEvent::Time(time)));
    assert_eq!(slave.node.scet(ms(1)), time);
}

/// Given SYNC every 100 ms, when the time is to be sent every minute or every 50 ms, then its transmission type is 240
/// or 1: the longest and the shortest cycle.
///
/// Verifies: ECSS 7.2.3e
/// Notices: ECSS 7.2.3e: a time period of more than 240 SYNCs gives a type above 240.
/// Notices: ECSS 7.2.3e: a time period of less than a SYNC gives type 0.
#[test]
fn type_of_the_time_is_1_to_240() {
    const RARE: Profile = Profile { time: Duration::from_millis(60_000), ..STANDARD };
    const FREQUENT: Profile = Profile { time: Duration::from_millis(50), ..STANDARD };
    let transmission = |profile| master(profile).build().objects().pdos.tpdos[0].transmission;
    assert_eq!([&RARE, &FREQUENT].map(transmission), [240, 1]);
}

/// Verifies: ECSS 7.2.2g, 7.1.2f
/// Notices: ECSS 7.2.2g: the local time of slave 15 has no sender.
/// Notices: ECSS 7.1.2f: the master takes the coarse time of a slave with its highest byte first.
#[test]
fn a_receive_pdo_of_the_master_names_its_sender() {
    let time = Scet::new(0x1234_5678, 0x9A_BCDE).unwrap();
    let pdo = |number, data| {
        received(&ReceivedPdo::new(&CommanderObjects::PDOS, number, Bus::Nominal, data, ms(1)))
    };
    for raw in 2..=15 {
        let found = pdo(u16::from(raw) - 2, [0xDE, 0xBC, 0x9A, 0x78, 0x56, 0x34, 0x12, 0]);
        assert_eq!(found, Some((node(raw), Received::LocalTime(time))), "slave {raw}");
    }
    let last = SLAVES as u16 * 2 - 1;
    let message = Message::of(3, [9]);
    assert_eq!(pdo(last, [3, 0, 9, 0, 0, 0, 0, 0]), Some((node(15), Received::Telemetry(message))));
    assert_eq!(pdo(last + 1, [0; 8]), None);
}

#[test]
fn a_node_that_is_none_of_the_missions_is_not_commanded() {
    let mut master = flying();
    let message = Message::of(1, []);
    let command = master.node.send_to(node(16), TELECOMMAND, message.telecommand(), ms(1));
    let request = master.node.send_to(node(16), REQUEST, message.values(), ms(1));
    assert_eq!([command, request], [Err(Refusal::NotOperational); 2]);
}

/// Verifies: ECSS 6.5.2a, 8.3.1b
/// Notices: ECSS 8.3.1b: 1016h of the master has no entry for the last slave.
#[test]
fn the_master_consumes_the_heartbeat_of_every_slave() {
    for profile in [&STANDARD, &LIBRECUBE] {
        let entries = master(profile).build().objects().consumers.consumer_heartbeat;
        let time = profile.consumer.as_millis() as u32;
        let expected: [u32; SLAVES] = core::array::from_fn(|nth| (nth as u32 + 2) << 16 | time);
        assert_eq!(entries, expected);
    }
}

/// Only SDO writes reconfigure a service; a receive PDO just changes a value. Therefore only objects of the
/// application, which gets an event for each, and the time, which sets the clock, may be mapped into a receive PDO.
///
/// Verifies: ECSS 7.2.2c
#[test]
fn what_a_service_has_to_follow_does_not_come_by_pdo() {
    let mut by_pdo = Vec::new();
    NodeObjects::<MissionObjects<Vec<u8>>>::each_object(&mut |object| {
        if object.entries.iter().any(|entry| entry.is_mappable() && entry.access.is_for_rpdo()) {
            by_pdo.push(object.index);
        }
    });
    by_pdo.sort_unstable();
    assert_eq!(by_pdo, [0x2010, 0x6101, 0x6200, 0x6210]);
}

/// Reads an object as an SDO client at the node with this Node-ID. Returns command byte and value of the expedited
/// response.
fn read<N: Node>(desk: &mut Desk<N>, id: u16, (index, sub): (u16, u8)) -> (u8, u32) {
    let [low, high] = index.to_le_bytes();
    desk.sent();
    desk.hear(frame(0x600 + id, &[0x40, low, high, sub, 0, 0, 0, 0]));
    let sent = desk.sent();
    let answer = sent
        .iter()
        .find(|sent| sent.id().raw() == 0x580 + id)
        .unwrap_or_else(|| panic!("{id} {index:04X}h sub {sub}: {sent:?}"))
        .padded();
    assert_eq!(answer[1..4], [low, high, sub]);
    (answer[0], u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]))
}

/// Given the master and a slave of each profile, when a client reads 1016h, 1017h and 2000h, then each has the objects of Tables 8-1 and
/// 8-2 with their types (4Fh: 8 bits, 4Bh: 16, 43h: 32), and the numbers of its profile. 1017h of the master has sub-index 0.
///
/// Verifies: ECSS 8.3.1a, 8.3.1b
/// Notices: ECSS 8.3.1a: Ttoggle of the shipped slave is that of the default profile.
/// Notices: ECSS 8.3.1b: 1017h of the shipped master has the consumer time.
#[test]
fn master_and_slave_have_the_objects_of_tables_8_1_and_8_2() {
    const ABSENT: (u8, u32) = (0x80, 0x0609_0011);
    // Consumer time, producer time, Ttoggle, Ntoggle of a slave.
    for (profile, [consumer, producer, ttoggle, ntoggle]) in
        [(&STANDARD, [250, 100, 2, 50]), (&LIBRECUBE, [2_500, 250, 5, 10])]
    {
        let common = [
            ((0x1017, 0), (0x4B, producer)),
            ((0x1017, 1), ABSENT),
            ((0x2000, 0), (0x4F, 4)),
            ((0x2000, 1), (0x4F, 0)),
            ((0x2000, 2), (0x4F, ttoggle)),
            ((0x2000, 4), (0x4F, 0)),
            ((0x2000, 5), ABSENT),
        ];
        let mut master = Desk::new(master(profile).build());
        let mut slave = Desk::new(slave(node(3), profile, vec![]).build());
        let booted =
            |id| LinkEvent::Transmitted { frame: frame(id, &[0]), stamp: Stamp::interrupt(Instant::ZERO) };
        master.node.on_link(Bus::Nominal, &booted(0x701), &mut Turn::new(Instant::ZERO, &mut master.out));
        slave.node.on_link(Bus::Nominal, &booted(0x703), &mut Turn::new(Instant::ZERO, &mut slave.out));
        for (at, expected) in common {
            assert_eq!(read(&mut master, 1, at), expected, "{}: master, {at:04X?}", profile.name);
            assert_eq!(read(&mut slave, 3, at), expected, "{}: slave, {at:04X?}", profile.name);
        }
        // 255: no limit.
        assert_eq!(read(&mut master, 1, (0x2000, 3)), (0x4F, 255));
        assert_eq!(read(&mut slave, 3, (0x2000, 3)), (0x4F, ntoggle));
        assert_eq!(read(&mut slave, 3, (0x1016, 1)), (0x43, 1 << 16 | consumer));
        for (sub, id) in (1..=14).zip(2_u32..) {
            assert_eq!(read(&mut master, 1, (0x1016, sub)), (0x43, id << 16 | consumer), "slave {id}");
        }
    }
}
