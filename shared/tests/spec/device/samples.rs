//! Values of other types than the instrument's objects have.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, Slave};
use ecss_can::od::{Objects, Record};
use ecss_can::pdo::{PdoObjects, PdoSet};

use crate::instrument::STANDARD;

use super::fixture::{done, read, refused, write, write_all};
use crate::bench::{Bench, node};

#[derive(Debug, Objects)]
#[objects(device)]
struct Sampler {
    /// Samples
    #[object(0x6400, record)]
    samples: Samples,
}

#[derive(Clone, Debug, Record)]
struct Samples {
    /// Boolean
    #[sub(1, rw)]
    boolean: bool,
    /// Limited
    #[sub(28, rw, low = -100, high = 100)]
    limited: i16,
}

impl Device for Sampler {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::NONE;
}

/// Verifies: ECSS 6.8a, 6.1a
/// Notices: ECSS 6.8a: an expedited download writes a number outside its limits.
/// Notices: ECSS 6.1a: a value below its limit is refused with 0609 0031h, too high.
#[test]
fn value_outside_its_limits_or_no_boolean_is_refused() {
    let mut device = Bench::new(Slave::builder(node(5), &STANDARD, Sampler::default()).build());
    for (sub, value, code) in [
        (28, &[101, 0][..], 0x0609_0031), // above its limit
        (28, &[0x9B, 0xFF], 0x0609_0032), // -101: below
        (1, &[2], 0x0609_0030),           // a BOOLEAN is 0 or 1
        (1, &[0xFF], 0x0609_0030),        // as well
    ] {
        assert_eq!(write(&mut device, 0x6400, sub, value), refused(0x6400, sub, code), "{sub} {value:02X?}");
    }
    for (sub, value) in [(28, &[100, 0][..]), (28, &[0x9C, 0xFF]), (1, &[1]), (1, &[0])] {
        assert_eq!(write(&mut device, 0x6400, sub, value), done(0x6400, sub));
        assert_eq!(read(&mut device, 0x6400, sub)[..value.len()], *value);
    }
}

/// Verifies: ECSS 6.8a
/// Notices: ECSS 6.8a: 1020h stays when an object of the application is written.
#[test]
fn changed_sample_is_a_changed_configuration() {
    let mut device = Bench::new(Slave::builder(node(5), &STANDARD, Sampler::default()).build());
    write_all(&mut device, &[(0x1020, 1, &[7, 0, 0, 0]), (0x1020, 2, &[8, 0, 0, 0]), (0x6400, 1, &[1])]);
    assert_eq!(device.node.objects().communication.configuration, [0, 0]);
}
