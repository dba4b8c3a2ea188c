//! The master of the heater: the device, and its application.

#![no_std]
#![forbid(unsafe_code)]

use ecss_can::prelude::*;
use ecss_can::sdo::Error;
use embassy_futures::join::join;

use {{slave_crate}}::{CHANGE, Heater};

/// Node-ID of the heater.
pub const HEATER: NodeId = NodeId::of::<{{node}}>();
/// Setpoint that the master writes, 0.1 °C.
pub const SETPOINT: i16 = 400;
/// Schedule that the master writes.
pub const SCHEDULE: [u8; 32] = *b"heat at night, rest in sunlight.";
/// Spacecraft time when the master starts: second 1,000,000.
pub const START: Scet = Scet::new(1_000_000, 0).unwrap();

/// Time on the other bus, more than two heartbeats.
const VISIT: Duration = Duration::from_millis(1_000);

/// Objects of the master beside those of every master: none.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Ground {}

impl Device for Ground {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    /// Receives the power of the heater, and sends the spacecraft time.
    const PDOS: PdoSet = PdoSet::new(&[CHANGE.of(HEATER).receive(1)], &[MASTER_TIME]);

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "Ground",
            ..Communication::new(id)
        }
    }
}

/// What the application reports: the image logs it, a test keeps it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Report {
    /// The heater saved setpoint and schedule.
    Prepared {
        /// Power after the setpoint was written, in percent.
        power: u8,
        /// The schedule was the same when it was read back.
        is_same: bool,
    },
    /// The heater answered on the other bus too.
    BothBuses,
    /// A transfer failed.
    Failed(Error),
    /// The heater sent its power, in percent.
    Power(u8),
    /// The heater reported an error, or that one is gone.
    Emergency(ErrorCode),
    /// This bus became the active one.
    ActiveBus(Bus),
}

/// Runs without end.
pub async fn application<P: Platform>(
    ground: Handle<P, Master<Ground>>,
    events: impl EventSource<Event = MasterEvent>,
    report: impl Fn(Report),
) {
    ground.set_time(START);
    join(listen(ground, events, &report), command(ground, &report)).await;
}

async fn listen<P: Platform>(
    ground: Handle<P, Master<Ground>>,
    mut events: impl EventSource<Event = MasterEvent>,
    report: impl Fn(Report),
) {
    loop {
        match events.next().await {
            MasterEvent::Pdo(pdo) => {
                if let Some((power,)) = pdo.get(CHANGE.of(HEATER)) {
                    report(Report::Power(power));
                }
            }
            MasterEvent::Emergency {
                node: HEATER,
                emergency,
                ..
            } => {
                report(Report::Emergency(emergency.code));
                if emergency.code == ErrorCode::TEMPERATURE {
                    ground.reset(HEATER);
                }
            }
            MasterEvent::BusSwitched { to, .. } => report(Report::ActiveBus(to)),
            _ => {}
        }
    }
}

async fn command<P: Platform>(ground: Handle<P, Master<Ground>>, report: impl Fn(Report)) {
    let heater = ground.sdo(HEATER);
    let prepared = loop {
        ground.wait_operational(HEATER).await;
        match prepare(heater).await {
            // The bus failed and the master changed it: repeat the steps on the other one.
            Err(Error::BusChanged) => {}
            result => break result,
        }
    };
    report(prepared.unwrap_or_else(Report::Failed));

    let bus = ground.status().active;
    ground.switch_to(bus.other());
    ground.wait_until(ground.now() + VISIT).await;
    let answer = heater.read(Heater::POWER).await;
    report(answer.map_or_else(Report::Failed, |_| Report::BothBuses));
    ground.switch_to(bus);
}

/// Writes setpoint and schedule, lets the heater save them, and reads the schedule back.
async fn prepare<P: Platform>(heater: SdoClient<P, Ground>) -> Result<Report, Error> {
    heater.write(Heater::SETPOINT, SETPOINT).await?;
    let power = heater.read(Heater::POWER).await?;
    heater.write_bytes(Heater::SCHEDULE, &SCHEDULE).await?;
    heater.save_all().await?;
    let mut schedule = [0; 32];
    heater.read_bytes(Heater::SCHEDULE, &mut schedule).await?;
    Ok(Report::Prepared {
        power,
        is_same: schedule == SCHEDULE,
    })
}
