//! Expressions of a declaration that are wrong: one error for each, although the code of the macro has it twice.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::Device;
use ecss_can::od::{Objects, Record};
use ecss_can::pdo::{PdoObjects, PdoSet};

fn highest() -> i64 {
    5
}

struct NoDefault;

#[derive(Objects)]
#[objects(device, check = missing)]
struct Heater {
    /// Limit that does not exist
    #[object(0x6000, rww, pdo, low = 0, high = HIGHEST)]
    limit: u8,
    /// Limit of a wrong type
    #[object(0x6001, array, rww, pdo, high = "high")]
    text: [u8; 2],
    /// Limit that is no constant
    #[object(0x6002, rww, pdo, high = highest())]
    computed: u8,
    /// Default of a wrong type
    #[object(0x6003, rw, high = 5, default = "low")]
    default: u8,
    /// Default that is no constant
    #[object(0x6004, rw, high = 5, default = highest() as u8)]
    late: u8,
    /// No default
    #[skip]
    hidden: NoDefault,
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[], &[]);
}

/// Without the word `record`.
#[derive(Objects)]
struct Amplifier {
    /// Channel
    #[object(0x6000, rw)]
    channel: Channel,
}

#[derive(Record)]
struct Channel {
    /// Gain
    #[sub(1, rw)]
    gain: u8,
}

fn main() {}
