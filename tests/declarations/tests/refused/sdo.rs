//! Transfers that the declaration of an object excludes: each is one error, at its place.

use ecss_can::prelude::*;
use ecss_can::sdo::Error;

#[derive(Objects)]
struct Heater {
    /// Setpoint
    #[object(0x6000, rw)]
    setpoint: i16,
    /// Power
    #[object(0x6001, ro)]
    power: u8,
    /// Password
    #[object(0x6002, wo)]
    password: u32,
    /// Schedule
    #[object(0x6003, rw)]
    schedule: Domain<[u8; 32]>,
    /// Limits
    #[object(0x6004, array, constant)]
    limits: [i16; 2],
}

#[derive(Objects)]
#[objects(device)]
struct Ground {}

impl Device for Ground {
    type Pdos = PdoObjects<0, 0>;
    type Consumers = HeartbeatConsumers<1>;
    const PDOS: PdoSet = PdoSet::NONE;
}

async fn transfers(heater: SdoClient<impl Platform, Ground>) -> Result<(), Error> {
    heater.write(Heater::SETPOINT, 40.0).await?;
    heater.write(Heater::SETPOINT, 40_u32).await?;
    heater.write(Heater::POWER, 100).await?;
    heater.write(Heater::LIMITS.sub(1), 0).await?;
    heater.write_bytes(Heater::POWER, &[100]).await?;
    heater.read(Heater::PASSWORD).await?;
    let power: i16 = heater.read(Heater::POWER).await?;
    heater.write(Heater::SETPOINTS, 400).await?;
    Ok(())
}

fn main() {}
