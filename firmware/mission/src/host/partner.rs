//! Plain nodes of the mission, the partners of an application in a run.

use ecss_can::mock::MockSpacecraft;
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::pdo::Sequence;
use ecss_can::profile::Profile;
use ecss_can::runner::{MasterHandle, SlaveHandle};
use ecss_can::types::{Duration, Instant, NodeId};

use super::Console;
use crate::{COMMAND_PERIOD, Command, Message, MissionObjects, REQUEST, Request, SlaveRecord, TELECOMMAND};

/// Period of the commands of a plain master, and of its telemetry requests.
const PERIOD: Duration = Duration::from_millis(1_000);
/// Data store of a slave, bytes.
const STORE: usize = 4_096;

/// Memory for the data store of a slave. It is never freed.
pub fn memory() -> &'static mut [u8] {
    Box::leak(Box::new([0; STORE]))
}

/// Powers on a master that each second sends node `to` a command and a telemetry request. The console prints changes of
/// its bus.
pub fn master(spacecraft: &mut MockSpacecraft, profile: &Profile, to: NodeId, console: &Console) {
    let (master, mut events) = spacecraft.power_on(|| crate::master(profile).build());
    spacecraft.spawn(async move {
        let mut sequence = Sequence::new(master.now(), COMMAND_PERIOD);
        for (turn, asked) in (1_u32..).zip(Request::ALL.into_iter().cycle()) {
            master.wait_until(Instant::ZERO + PERIOD.times(turn)).await;
            let step = sequence.step(master.now());
            // A slave that is not operational receives neither.
            let commanded = step.map_or(Ok(()), |step| {
                let message = Command::SetLed(turn % 2 == 1).encode(step);
                master.send_to(to, TELECOMMAND, message.telecommand())
            });
            let _ = commanded.and_then(|()| master.send_to(to, REQUEST, asked.encode().values()));
        }
    });
    let console = console.clone();
    spacecraft.spawn(async move {
        loop {
            if let MasterEvent::BusSwitched { from, to, cause } = events.next().await {
                console.line("master", format_args!("active bus: {to:?}, no longer {from:?} ({cause:?})"));
            }
        }
    });
}

/// Powers on a slave that executes commands and answers telemetry requests.
pub fn slave(spacecraft: &mut MockSpacecraft, profile: &Profile, id: NodeId) {
    let (slave, mut events) = spacecraft.power_on(|| crate::slave(id, profile, memory()).build());
    spacecraft.spawn(async move {
        let mut record = SlaveRecord::new();
        loop {
            let SlaveEvent::Pdo(pdo) = events.next().await else { continue };
            let Some(message) = Message::from_payload(&pdo.data) else { continue };
            if pdo.is(TELECOMMAND) {
                // Repeats and unknown commands change nothing.
                let _ = record.take(&message, slave.now());
            } else if pdo.is(REQUEST) {
                let Some(request) = Request::decode(&message) else { continue };
                let telemetry = record.answer(request, &slave.status()).encode();
                slave
                    .send_with(MissionObjects::TELEMETRY_PDO, |objects| objects.telemetry = telemetry.into());
            }
        }
    });
}
