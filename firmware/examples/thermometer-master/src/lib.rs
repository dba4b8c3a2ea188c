//! The master of the thermometer: its objects, its PDOs, the table that it writes, and its application, for a board and for tests on the
//! host.

#![no_std]
#![forbid(unsafe_code)]

mod application;

pub use application::{Report, application};
use ecss_can::prelude::*;
use ecss_can::sdo::Error;
use thermometer::{Mode, Thermometer};

/// The thermometer's Node-ID.
pub const THERMOMETER: NodeId = NodeId::of::<3>();

/// Objects of this master besides those of every master: none.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Ground {}

impl Device for Ground {
    type Pdos = PdoObjects<1, 0>;
    type Consumers = HeartbeatConsumers<4>;

    const PDOS: PdoSet = PdoSet::new(&[<Thermometer>::CHANGE.of(THERMOMETER).receive(1)], &[]);

    fn communication(id: NodeId) -> Communication {
        Communication { device_name: "Thermometer's master", ..Communication::new(id) }
    }
}

/// Writes the table by block transfer. From then on the thermometer uses it for correction, also after a reset.
///
/// # Errors
/// See [`Error`].
pub async fn write_table(thermometer: SdoClient<impl Platform, Ground>) -> Result<(), Error> {
    let mut bytes = table();
    let fill = |part: &mut [u8]| part.fill_with(|| bytes.next().unwrap_or(0));
    thermometer.download_from(Thermometer::TABLE, 2048, fill).await?;
    thermometer.write(Thermometer::MODE, Mode::Corrected).await?;
    thermometer.save_all().await
}

/// Returns whether the thermometer still has the table as written.
///
/// # Errors
/// See [`Error`].
pub async fn is_kept(thermometer: SdoClient<impl Platform, Ground>) -> Result<bool, Error> {
    let (mut bytes, mut same) = (table(), true);
    let compare = |part: &[u8]| same &= part.iter().all(|byte| bytes.next() == Some(*byte));
    thermometer.upload_to(Thermometer::TABLE, 2048, compare).await?;
    Ok(same && bytes.next().is_none())
}

/// Returns 1024 corrections, which rise by a tenth of a degree every 64 entries.
fn table() -> impl Iterator<Item = u8> {
    (0_i16..1024).flat_map(|entry| (entry / 64).to_le_bytes())
}
