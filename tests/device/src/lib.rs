//! A slave with a value of every data type, for tests.
//!
//! It has the objects and PDOs of the mission's slaves, UTC, and 6400h with one value of each type. Tools of others read and
//! write them on the emulated board, the tests of the protocol on a bench. Nobody flies it.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, Identity, Slave};
use ecss_can::od::{
    Domain, I24, I40, I48, I56, Objects, OctetString, Record, TimeDifference, TimeOfDay, U24, U40, U48, U56,
    UnicodeString, VisibleString,
};
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::profile::Profile;
use ecss_can::time::LocalUtc;
use ecss_can::types::{NodeId, Scet, Utc, UtcRelation};
use mission::MissionObjects;

/// Product code in 1018h: that of the slaves that it stands for, which their master checks.
const PRODUCT: u32 = 0x5015;

/// UTC when the SCET was zero.
const EPOCH: Utc = Utc::new(20_000, 0, 0).unwrap();

/// Objects of the mission's slaves, UTC, and samples. `S` is the memory of the data store.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
pub struct TestObjects<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static = &'static mut [u8]> {
    /// Of the mission
    #[objects]
    pub mission: MissionObjects<S>,
    /// Spacecraft UTC
    #[objects]
    pub utc: LocalUtc,
    /// Values of every type
    ///
    /// What is written can be read back.
    #[object(0x6400, record)]
    pub samples: Samples,
}

impl<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static> Device for TestObjects<S> {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = MissionObjects::<S>::PDOS;
    const UTC: Option<UtcRelation> = Some(UtcRelation { scet: Scet::new(0, 0).unwrap(), utc: EPOCH });

    fn utc(&mut self) -> Option<&mut LocalUtc> {
        Some(&mut self.utc)
    }

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "Test device",
            identity: Identity { vendor: 0, product: PRODUCT, revision: 1 << 16, serial: id.get().into() },
            ..Communication::new(id)
        }
    }
}

/// One value of each type (ECSS Table 9-11).
#[derive(Clone, Copy, Debug, PartialEq, Record)]
pub struct Samples {
    /// BOOLEAN
    #[sub(1, rw, pdo)]
    pub boolean: bool,
    /// INTEGER8
    #[sub(2, rw, pdo)]
    pub integer8: i8,
    /// INTEGER16
    #[sub(3, rw, pdo)]
    pub integer16: i16,
    /// INTEGER32
    #[sub(4, rw, pdo)]
    pub integer32: i32,
    /// UNSIGNED8
    #[sub(5, rw, pdo)]
    pub unsigned8: u8,
    /// UNSIGNED16
    #[sub(6, rw, pdo)]
    pub unsigned16: u16,
    /// UNSIGNED32
    #[sub(7, rw, pdo)]
    pub unsigned32: u32,
    /// REAL32
    #[sub(8, rw, pdo)]
    pub real32: f32,
    /// VISIBLE_STRING
    #[sub(9, rw)]
    pub visible_string: VisibleString<32>,
    /// OCTET_STRING
    #[sub(10, rw)]
    pub octet_string: OctetString<16>,
    /// UNICODE_STRING
    #[sub(11, rw)]
    pub unicode_string: UnicodeString<16>,
    /// TIME_OF_DAY
    #[sub(12, rw, pdo)]
    pub time_of_day: TimeOfDay,
    /// TIME_DIFFERENCE
    #[sub(13, rw, pdo)]
    pub time_difference: TimeDifference,
    /// INTEGER24
    #[sub(16, rw, pdo)]
    pub integer24: I24,
    /// REAL64
    #[sub(17, rw, pdo)]
    pub real64: f64,
    /// INTEGER40
    #[sub(18, rw, pdo)]
    pub integer40: I40,
    /// INTEGER48
    #[sub(19, rw, pdo)]
    pub integer48: I48,
    /// INTEGER56
    #[sub(20, rw, pdo)]
    pub integer56: I56,
    /// INTEGER64
    #[sub(21, rw, pdo)]
    pub integer64: i64,
    /// UNSIGNED24
    #[sub(22, rw, pdo)]
    pub unsigned24: U24,
    /// UNSIGNED40
    #[sub(24, rw, pdo)]
    pub unsigned40: U40,
    /// UNSIGNED48
    #[sub(25, rw, pdo)]
    pub unsigned48: U48,
    /// UNSIGNED56
    #[sub(26, rw, pdo)]
    pub unsigned56: U56,
    /// UNSIGNED64
    #[sub(27, rw, pdo)]
    pub unsigned64: u64,
    /// Within limits
    ///
    /// -100 to 100.
    #[sub(28, rw, pdo, low = -100, high = 100)]
    pub limited: i16,
}

/// A test device; `memory` is its data store.
pub fn device<S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static>(
    id: NodeId,
    profile: &Profile,
    memory: S,
) -> Slave<TestObjects<S>> {
    let mission = MissionObjects { store: Domain::new(memory), ..Default::default() };
    let application = TestObjects { mission, utc: LocalUtc::default(), samples: Samples::default() };
    Slave::new(id, profile, application)
}
