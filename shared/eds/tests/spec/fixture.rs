//! A dictionary with every type, every access right, and values that follow the Node-ID in every way.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Spacecraft};
use ecss_can::od::{
    Domain, I24, I40, I48, I56, Objects, OctetString, Record, TimeDifference, TimeOfDay, U24, U40, U48, U56,
    UnicodeString, VisibleString,
};
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::sdo::TwoSdoServers;
use ecss_can::types::NodeId;
use ecss_can_eds::{Description, Device, Timestamp};

pub const MADE: Timestamp = Timestamp { year: 2026, month: 2, day: 3, hour: 15, minute: 4 };

#[derive(Objects)]
pub struct Fixture {
    #[objects]
    pub types: Types,
    #[objects]
    pub spacecraft: Spacecraft,
    #[objects]
    pub communication: Communication,
    #[objects]
    pub consumers: HeartbeatConsumers,
    #[objects]
    pub pdos: PdoObjects,
    #[objects]
    pub sdo: TwoSdoServers,
    #[objects]
    pub nodes: Nodes,
}

#[derive(Objects)]
pub struct Types {
    /// Boolean
    #[object(0x6001, rw, pdo, default = true)]
    boolean: bool,
    /// Integer8
    #[object(0x6002, rw, low = -100, high = 100, default = -1)]
    integer8: i8,
    /// Integer16
    #[object(0x6003, rw, default = -2)]
    integer16: i16,
    /// Integer32
    #[object(0x6004, rw, low = -70000, default = -69997)]
    integer32: i32,
    /// Unsigned8
    #[object(0x6005, rwr, pdo, high = 200, default = 7)]
    unsigned8: u8,
    /// Unsigned16
    #[object(0x6006, rww, pdo, default = 0xABC)]
    unsigned16: u16,
    /// Unsigned32
    #[object(0x6007, wo, default = 4)]
    unsigned32: u32,
    /// Real32
    #[object(0x6008, rw, pdo, default = -0.1)]
    real32: f32,
    /// Visible string
    #[object(0x6009, rw, default = VisibleString::new(b"a = b").unwrap())]
    pub visible_string: VisibleString<9>,
    /// Octet string
    #[object(0x600A, ro, default = OctetString::new(&[0, 0xAB, 10]).unwrap())]
    octet_string: OctetString<4>,
    /// Unicode string
    #[object(0x600B, ro, default = UnicodeString::new(b"h\0i\0").unwrap())]
    unicode_string: UnicodeString<8>,
    /// Time of day
    #[object(0x600C, ro, default = TimeOfDay { days: 1, ms: 2 })]
    time_of_day: TimeOfDay,
    /// Time difference
    #[object(0x600D, ro)]
    time_difference: TimeDifference,
    /// Domain
    #[object(0x600F, rw, default = Domain::new([0; 16]))]
    domain: Domain<[u8; 16]>,
    /// Integer24
    #[object(0x6010, rw, default = I24::new(-3))]
    integer24: I24,
    /// Real64
    #[object(0x6011, ro, default = 1e-20)]
    real64: f64,
    /// Integer40
    #[object(0x6012, rw, default = I40::new(-4))]
    integer40: I40,
    /// Integer48
    #[object(0x6013, rw, default = I48::new(-5))]
    integer48: I48,
    /// Integer56
    #[object(0x6014, rw, default = I56::new(6))]
    integer56: I56,
    /// Integer64
    #[object(0x6015, rw, default = i64::MIN)]
    integer64: i64,
    /// Unsigned24
    #[object(0x6016, rw, default = U24::new(0x18))]
    unsigned24: U24,
    /// Unsigned40
    #[object(0x6018, rw, default = U40::new(0x19))]
    unsigned40: U40,
    /// Unsigned48
    #[object(0x6019, rw, default = U48::new(0x1A))]
    unsigned48: U48,
    /// Unsigned56
    #[object(0x601A, rw, default = U56::new(0x1B))]
    unsigned56: U56,
    /// Unsigned64
    #[object(0x601B, constant, default = u64::MAX)]
    unsigned64: u64,
    /// Zero as REAL32
    #[object(0x6020, rw)]
    real32_zero: f32,
    /// Zero as REAL64
    #[object(0x6021, rw, default = -0.0)]
    real64_zero: f64,
    /// Zero as INTEGER40
    #[object(0x6022, rw)]
    integer40_zero: I40,
    /// Zero as UNSIGNED48
    #[object(0x6023, rw)]
    unsigned48_zero: U48,
    /// Empty as UNICODE_STRING
    #[object(0x6024, ro)]
    unicode_string_empty: UnicodeString<8>,
    /// Thermometer {} of the panel
    #[object(0x6100.., array, ro, pdo)]
    thermometers: [[i16; 3]; 2],
    /// Valves
    #[object(0x6200, record)]
    valves: Valves,
}

#[derive(Record)]
pub struct Valves {
    /// State
    #[sub(1, rw)]
    state: u8,
    /// Cycles of valve {} so far
    #[sub(9.., ro)]
    cycles: [u16; 3],
}

/// Values that differ from node to node.
#[derive(Objects)]
pub struct Nodes {
    /// The Node-ID itself
    #[object(0x2101, ro)]
    plain: u8,
    /// With high bits
    #[object(0x2102, rw)]
    high: u32,
    /// Node-ID in bits 16 to 22
    #[object(0x2103, rw)]
    pub shifted: u32,
    /// Below zero
    #[object(0x2104, rw)]
    signed: i16,
    /// A name
    #[object(0x2105, ro)]
    name: VisibleString<8>,
}

pub fn fixture(node: NodeId) -> Fixture {
    let id = node.get();
    let mut fixture = Fixture {
        communication: Communication::new(node),
        pdos: PdoSet::NONE.at_power_on(node),
        ..Fixture::default()
    };
    fixture.communication.identity.vendor = 0x0123_4567;
    fixture.communication.identity.product = 0x89;
    fixture.communication.identity.serial = 1000 + u32::from(id);
    fixture.communication.device_name = "Fixture";
    fixture.sdo.default.sdo_server.request = 0x600 + u32::from(id);
    fixture.nodes.plain = id;
    fixture.nodes.high = 0xC000_0380 + u32::from(id);
    fixture.nodes.shifted = u32::from(id) << 16 | 250;
    fixture.nodes.signed = i16::from(id) - 10;
    fixture.nodes.name = VisibleString::new(format!("node {id}").as_bytes()).unwrap();
    fixture
}

pub fn device() -> Device {
    Device {
        vendor: "Vendor".into(),
        product: "Product".into(),
        order_code: "F-1".into(),
        bit_rates: vec![125, 1000],
        boot_up_slave: true,
        comments: vec!["The first line".into(), "and the second".into()],
        ..Device::new(MADE)
    }
}

pub fn description() -> Description {
    Description::new(&device(), fixture).unwrap()
}
