//! The master of the thermometer: its objects, its PDOs, the table that it writes, and its application, for a board and for tests on the
//! host.

#![no_std]
#![forbid(unsafe_code)]

mod application;

use ecss_can::prelude::*;
use ecss_can::sdo::Error;
use thermometer::Thermometer;

pub use application::{Report, application};

/// The thermometer's Node-ID.
pub const THERMOMETER: NodeId = NodeId::of::<3>();

/// Receive PDO of a change: 283h.
pub const CHANGE: Rpdo =
    Pdo::<()>::new(CobIdOf::fixed(0x283)).map(Ground::TEMPERATURE).map(Ground::ALARM).receive(1);
/// Transmit PDO of commands: 203h.
pub const COMMAND: Tpdo = Pdo::<()>::new(CobIdOf::fixed(0x203)).map(Ground::COMMAND).transmit(1);

/// What the master has beside the objects of every master.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Ground {
    /// Temperature of the thermometer
    ///
    /// 0.1 °C.
    #[object(0x6000, rww, pdo)]
    pub temperature: i16,
    /// Alarm of the thermometer
    ///
    /// 0: within the limits; 1: above; 2: below.
    #[object(0x6001, rww, pdo)]
    pub alarm: u8,
    /// Command to the thermometer
    ///
    /// 1: forget the highest temperature.
    #[object(0x6010, ro, pdo)]
    pub command: u8,
}

impl Device for Ground {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<4>;

    const PDOS: PdoSet = PdoSet::new(&[CHANGE], &[COMMAND]);

    fn communication(id: NodeId) -> Communication {
        Communication { device_name: "Thermometer's master", ..Communication::new(id) }
    }
}

/// Writes the table by block transfer; from now on the thermometer corrects by it, also after a reset.
///
/// # Errors
/// See [`Error`].
pub async fn write_table(thermometer: SdoClient<impl Platform, Ground>) -> Result<(), Error> {
    let mut bytes = table();
    let fill = |part: &mut [u8]| part.fill_with(|| bytes.next().unwrap_or(0));
    thermometer.download_from(Thermometer::TABLE, 2048, fill).await?;
    thermometer.write(Thermometer::MODE, 1).await?;
    thermometer.save_all().await
}

/// Whether the table is as it was written.
///
/// # Errors
/// See [`Error`].
pub async fn is_kept(thermometer: SdoClient<impl Platform, Ground>) -> Result<bool, Error> {
    let (mut bytes, mut same) = (table(), true);
    let compare = |part: &[u8]| same &= part.iter().all(|byte| bytes.next() == Some(*byte));
    thermometer.upload_to(Thermometer::TABLE, 2048, compare).await?;
    Ok(same && bytes.next().is_none())
}

/// 1024 corrections: a tenth of a degree more every 64 entries.
fn table() -> impl Iterator<Item = u8> {
    (0_i16..1024).flat_map(|entry| (entry / 64).to_le_bytes())
}
