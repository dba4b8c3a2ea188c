//! The time of masters: with few places, without an event timer, without SYNC, and by a producer that is another node.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::link::Stamp;
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::node::extend::LinkEvent;
use ecss_can::node::{Device, DeviceTime, Master, MasterRequest, SpacecraftDevice};
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, Tpdo};
use ecss_can::profile::Profile;
use ecss_can::time::{LocalScet, LocalUtc, ScetGet, ScetSet, UtcGet, UtcSet};
use ecss_can::types::{NodeId, Scet, Utc, UtcRelation};

use super::{scet, us};
use crate::bench::{Bench, NOMINAL, frame, ms, span};
use crate::console;
use crate::instrument::STANDARD;
use crate::master_device::write;

/// SCET 0 was day 100, 0:00.
const RELATION: UtcRelation =
    UtcRelation { scet: Scet::new(0, 0).unwrap(), utc: Utc::new(100, 0, 0).unwrap() };

/// Keeps 8 bits of fine time, and UTC without submilliseconds; takes the time of slave 5.
#[derive(Debug, Objects)]
#[objects(device, time)]
struct Modest {
    /// Time
    #[objects]
    utc: LocalUtc,
}

impl Device for Modest {
    type Pdos = PdoObjects<2, 2>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(
        &[
            Pdo::<()>::new(CobIdOf::fixed(0x185))
                .map(LocalScet::SCET_SET.field(ScetSet::FINE))
                .map(LocalScet::SCET_SET.field(ScetSet::COARSE))
                .receive(1),
            Pdo::<()>::new(CobIdOf::fixed(0x285))
                .map(LocalUtc::UTC_SET.field(UtcSet::SUBMILLISECONDS))
                .map(LocalUtc::UTC_SET.field(UtcSet::MS))
                .map(LocalUtc::UTC_SET.field(UtcSet::DAY))
                .receive(2),
        ],
        &[
            Pdo::<()>::new(CobIdOf::fixed(0x181))
                .map(LocalScet::SCET_GET.field(ScetGet::FINE))
                .map(LocalScet::SCET_GET.field(ScetGet::COARSE))
                .transmit(1)
                .transmission(2),
            Pdo::<()>::new(CobIdOf::fixed(0x281))
                .map(LocalUtc::UTC_GET.field(UtcGet::SUBMILLISECONDS))
                .map(LocalUtc::UTC_GET.field(UtcGet::MS))
                .map(LocalUtc::UTC_GET.field(UtcGet::DAY))
                .transmit(2)
                .transmission(2),
        ],
    );
}

impl DeviceTime for Modest {
    const FINE_BITS: u32 = 8;
    const UTC: Option<UtcRelation> = Some(RELATION);
    const SUBMILLISECONDS: bool = false;

    fn utc(&mut self) -> Option<&mut LocalUtc> {
        Some(&mut self.utc)
    }
}

/// Sends its time by transmission type `TYPE`, SCET or UTC, without an event timer.
#[derive(Debug, Objects)]
#[objects(device, time)]
struct Teller<const TYPE: u8, const UTC: bool> {
    /// Time
    #[objects]
    utc: LocalUtc,
}

impl<const TYPE: u8, const UTC: bool> Teller<TYPE, UTC> {
    const TIME: Tpdo = {
        let pdo = Pdo::<()>::new(CobIdOf::fixed(0x181));
        let tpdo = if UTC {
            pdo.map(LocalUtc::UTC_GET.field(UtcGet::SUBMILLISECONDS))
                .map(LocalUtc::UTC_GET.field(UtcGet::MS))
                .map(LocalUtc::UTC_GET.field(UtcGet::DAY))
                .transmit(1)
        } else {
            pdo.map(LocalScet::SCET_GET.field(ScetGet::FINE))
                .map(LocalScet::SCET_GET.field(ScetGet::COARSE))
                .transmit(1)
        };
        tpdo.transmission(TYPE)
    };
}

impl<const TYPE: u8, const UTC: bool> Device for Teller<TYPE, UTC> {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::new(&[], &[Self::TIME]);
}

impl<const TYPE: u8, const UTC: bool> DeviceTime for Teller<TYPE, UTC> {
    const UTC: Option<UtcRelation> = Some(RELATION);

    fn utc(&mut self) -> Option<&mut LocalUtc> {
        Some(&mut self.utc)
    }
}

/// A master with this device, its boot-up message acknowledged.
fn powered<D: SpacecraftDevice>(profile: &Profile) -> Bench<Master<D>> {
    let mut master = Bench::new(Master::builder(profile, D::default()).build());
    master.transmitted(NOMINAL, frame(0x701, &[0]));
    master
}

/// The SYNC of this master ends now, stamped in hardware or in its interrupt.
fn sync_sent<D: SpacecraftDevice>(master: &mut Bench<Master<D>>, is_captured: bool) {
    let now = master.now;
    let stamp = if is_captured { Stamp::captured(now.into()) } else { Stamp::interrupt(now) };
    master.link(NOMINAL, LinkEvent::Transmitted { frame: frame(0x080, &[]), stamp });
}

/// Payloads of this COB-ID.
fn payloads<D: SpacecraftDevice>(master: &Bench<Master<D>>, id: u16) -> Vec<Vec<u8>> {
    let of_id = master.sent.iter().filter(|sent| sent.frame.id().raw() == id);
    of_id.map(|sent| sent.frame.data().to_vec()).collect()
}

/// Given a master with 8 bits of fine time and without submilliseconds, when its SYNC ends 1.9009 s after power-on, captured or not, then
/// its PDOs have 1 + E6h / 100h s, and 1900 ms: 0.9009 x 256 = 230.6.
///
/// Verifies: ECSS 7.1.2g, 7.1.3f, 7.1.2f, 7.1.3e
/// Notices: ECSS 7.1.2g: a master sends 24 bits of fine time whatever its device has.
/// Notices: ECSS 7.1.3f: a master sends submilliseconds whatever its device has.
#[test]
fn master_sends_no_places_that_its_device_lacks() {
    for is_captured in [true, false] {
        let mut master = powered::<Modest>(&STANDARD);
        master.run_until(ms(1_800));
        sync_sent(&mut master, is_captured);
        master.run_until(us(1_900_900));
        master.clear();
        sync_sent(&mut master, is_captured);
        assert_eq!(payloads(&master, 0x181), [[0, 0, 0xE6, 1, 0, 0, 0]], "captured: {is_captured}");
        assert_eq!(payloads(&master, 0x281), [[0, 0, 0x6C, 7, 0, 0, 100, 0]], "captured: {is_captured}");
    }
}

/// Given a master with 8 bits of fine time that is no time producer, when slave 5 sends it the time with any of the others, then its
/// clock is set as if they were not there: the mean of what is cut off is added.
///
/// Verifies: ECSS 7.1.2h, 7.2.2c, 7.2.3d
/// Notices: ECSS 7.1.2h: a master takes bits of the fine time that its device lacks.
/// Notices: ECSS 7.2.3d: a master follows no time: it takes itself for the time producer.
#[test]
fn master_of_8_bits_follows_a_producer_in_a_slave() {
    for lowest in [0, 1, 0x8000, 0xFFFF] {
        let mut master = powered::<Modest>(&STANDARD);
        master.run_until(ms(50));
        master.receive(NOMINAL, 0x185, &scet(1_000, 0x81_0000 | lowest).encode());
        let now = master.now;
        let shown = master.node.status(now).scet;
        let expected = [scet(1_000, 0x81_7FFF), scet(1_000, 0x81_8000)];
        assert!(expected.contains(&shown), "{shown:?} of {lowest:04X}h");
    }
}

/// Given a master without submilliseconds, when slave 5 sends it a UTC with any number of them, then its clock is set as if they were not
/// there: 1000 ms and the mean of what is cut off, 499.5 us.
///
/// Verifies: ECSS 7.1.1b, 7.1.3a, 7.1.3g, 7.1.3b
/// Notices: ECSS 7.1.1b: a master takes no UTC.
#[test]
fn master_ignores_submilliseconds_that_it_lacks() {
    for [low, high] in [0_u16, 777, 1_000, u16::MAX].map(u16::to_le_bytes) {
        let mut master = powered::<Modest>(&STANDARD);
        master.run_until(ms(50));
        master.receive(NOMINAL, 0x285, &[low, high, 0xE8, 3, 0, 0, 100, 0]);
        let now = master.now;
        assert_eq!(master.node.status(now).scet, scet(1, 8_380));
    }
}

/// Answer of this master to an SDO request.
fn ask<D: SpacecraftDevice>(master: &mut Bench<Master<D>>, request: [u8; 8]) -> [u8; 8] {
    master.clear();
    master.receive(NOMINAL, 0x601, &request);
    let answer = master.sent.iter().find(|sent| sent.frame.id().raw() == 0x581);
    answer.expect("an answer").frame.padded()
}

/// Given a master with UTC, when a client writes the three parts of Local UTC Set, then it reads them from Local UTC Get, each in its size.
///
/// Verifies: ECSS 7.1.3a, 7.1.3b, 7.1.3c, 7.1.3d
/// Notices: ECSS 7.1.3a: a master has no Local UTC Get for clients.
#[test]
fn utc_of_a_master_is_set_and_got_by_clients() {
    let mut master = powered::<Teller<1, true>>(&STANDARD);
    master.run_until(ms(50));
    let parts = [(1, 0x0B, [110, 0, 0, 0]), (2, 0x03, [0x7B, 0x2E, 0x93, 0x02]), (3, 0x0B, [250, 0, 0, 0])];
    for (sub, size, [a, b, c, d]) in parts {
        let written = ask(&mut master, [0x20 | size, 0x12, 0x20, sub, a, b, c, d]);
        assert_eq!(written, [0x60, 0x12, 0x20, sub, 0, 0, 0, 0]);
    }
    for (sub, size, [a, b, c, d]) in parts {
        let read = ask(&mut master, [0x40, 0x13, 0x20, sub, 0, 0, 0, 0]);
        assert_eq!(read, [0x40 | size, 0x13, 0x20, sub, a, b, c, d]);
    }
}

/// Asserts: a master whose time goes out by events sends it with the period of the profile, a second.
fn assert_periodic<const TYPE: u8, const UTC: bool>() {
    let mut master = powered::<Teller<TYPE, UTC>>(&STANDARD);
    master.run_until(ms(3_500));
    let of_time = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x181);
    let at: Vec<_> = of_time.map(|sent| sent.at).collect();
    assert_eq!(at, [ms(1_000), ms(2_000), ms(3_000)], "type {TYPE}, UTC: {UTC}");
}

/// Given a master whose Spacecraft Time PDO is event-driven, of SCET or of UTC, and has no event timer, then it goes out with the period
/// of the profile.
///
/// Verifies: ECSS 7.2.2a, 7.2.2b
/// Notices: ECSS 7.2.2a: a PDO with Local UTC Get is not taken for the Spacecraft Time PDO.
/// Notices: ECSS 7.2.2b: a time of type 255 has no period.
#[test]
fn time_by_event_has_the_period_of_the_profile() {
    assert_periodic::<254, false>();
    assert_periodic::<255, false>();
    assert_periodic::<254, true>();
    assert_periodic::<255, true>();
}

/// Asserts: with SYNC every 100 ms the time follows every tenth SYNC, and is gone before the next one; also after a reset of the
/// communication.
fn assert_every_tenth<const UTC: bool>(is_reset: bool) {
    let mut master = powered::<Teller<1, UTC>>(&STANDARD);
    if is_reset {
        let target = Target::Node(NodeId::MASTER);
        master.request(MasterRequest::Nmt(NmtMessage { command: Command::ResetCommunication, target }));
        master.transmitted(NOMINAL, frame(0x701, &[0]));
    }
    let mut counts = vec![];
    for nth in 1..=20 {
        master.run_until(ms(100 * nth));
        master.clear();
        sync_sent(&mut master, true);
        let of_time = master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x181);
        counts.push(of_time.inspect(|sent| assert_eq!(sent.expires.since(sent.at), span(50))).count());
    }
    let tenth = [0, 0, 0, 0, 0, 0, 0, 0, 0, 1];
    assert_eq!(counts, [tenth, tenth].concat(), "UTC: {UTC}, reset: {is_reset}");
}

/// Given a master whose Spacecraft Time PDO follows SYNC, of SCET or of UTC, then it goes out after as many SYNCs as the period of the
/// profile has, and expires in half a SYNC period.
///
/// Verifies: ECSS 7.2.3a, 7.2.3b, 7.2.3e
/// Notices: ECSS 7.2.3a: a PDO with Local UTC Get is not taken for the Spacecraft Time PDO.
/// Notices: ECSS 7.2.3b: after reset communication the time has another period than that of the profile.
#[test]
fn time_by_sync_has_the_period_of_the_profile() {
    for is_reset in [false, true] {
        assert_every_tenth::<false>(is_reset);
        assert_every_tenth::<true>(is_reset);
    }
}

/// Given a profile whose period of the time is half a SYNC period, then the Spacecraft Time PDO has transmission type 1: the time
/// goes out with every SYNC.
///
/// Verifies: ECSS 7.2.3e, 7.2.3b
/// Notices: ECSS 7.2.3e: the transmission type is 0 where the time is more frequent than SYNC.
#[test]
fn time_more_frequent_than_sync_goes_with_every_sync() {
    let mut master = powered::<Teller<1, false>>(&Profile { time: span(50), ..STANDARD });
    for nth in 1..=3 {
        master.run_until(ms(100 * nth));
        master.clear();
        sync_sent(&mut master, true);
        assert_eq!(master.sent.iter().filter(|sent| sent.frame.id().raw() == 0x181).count(), 1, "SYNC {nth}");
    }
}

/// Given a master that produces no SYNC (1006h is zero, or bit 30 of 1005h), or produces it more often from now on, then its event-driven
/// time goes out all the same, each second.
///
/// Verifies: ECSS 7.2.3d, 6.3b, 7.2.2b
/// Notices: ECSS 7.2.3d: without SYNC there is no time.
/// Notices: ECSS 7.2.3d: with bit 30 of 1005h clear there is no time.
/// Notices: ECSS 7.2.3d: a new period of SYNC makes the time due.
/// Notices: ECSS 6.3b: SYNC goes on while 1006h is zero.
#[test]
fn master_without_sync_sends_its_time() {
    for (index, value, has_sync) in [(0x1006, 0, false), (0x1005, 0x80, false), (0x1006, 50_000, true)] {
        let mut master = Bench::new(console::master(&STANDARD));
        master.transmitted(NOMINAL, frame(0x701, &[0]));
        master.run_until(ms(250));
        master.clear();
        assert_eq!(write(&mut master, index, 0, value, 4), Ok(()));
        master.run_until(ms(2_500));
        assert_eq!(master.times(NOMINAL, 0x181), [1_000, 2_000], "{index:04X}h: {value}");
        assert_eq!(!master.times(NOMINAL, 0x080).is_empty(), has_sync, "{index:04X}h: {value}");
    }
}
