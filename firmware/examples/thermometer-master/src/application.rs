//! The application of the thermometer's master: writes the table of the thermometer, checks that it is kept over a
//! reset, and reports measurements.

use ecss_can::prelude::*;
use ecss_can::sdo::Error;
use embassy_futures::join::join;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use thermometer::{Alarm, Change, Thermometer};

use crate::{Ground, THERMOMETER, is_kept, write_table};

/// Reports of the application: an image logs them, a test collects them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Report {
    /// The thermometer sent a change: temperature in 0.1 °C, and alarm.
    Measured { temperature: i16, alarm: Alarm },
    /// The master changed the active bus.
    ActiveBus(Bus),
    /// The thermometer has saved its table. The master resets it.
    TableSaved,
    /// After the reset the table is the same.
    TableKept,
    /// After the reset the table differs.
    TableLost,
    /// A transfer of the table failed.
    TransferFailed(Error),
    /// The command to forget the highest temperature was not sent.
    NotCommanded(Refusal),
}

/// Runs for ever, on a platform `P`.
pub async fn application<P: Platform>(
    master: Handle<P, Master<Ground>>,
    events: impl EventSource<Event = MasterEvent>,
    report: impl Fn(Report),
) {
    // Signalled when the thermometer leaves Operational.
    let away = Signal::new();
    join(listen(events, &away, &report), calibrate(master, &away, &report)).await;
}

async fn listen(
    mut events: impl EventSource<Event = MasterEvent>,
    away: &Signal<NoopRawMutex, ()>,
    report: impl Fn(Report),
) {
    loop {
        match events.next().await {
            MasterEvent::SlaveState { node: THERMOMETER, state, .. } if state != NmtState::Operational => {
                away.signal(());
            }
            MasterEvent::Pdo(pdo) => {
                if let Some(Change { temperature, alarm }) = pdo.get(<Thermometer>::CHANGE.of(THERMOMETER)) {
                    report(Report::Measured { temperature, alarm });
                }
            }
            MasterEvent::BusSwitched { to, .. } => report(Report::ActiveBus(to)),
            _ => {}
        }
    }
}

async fn calibrate<P: Platform>(
    master: Handle<P, Master<Ground>>,
    away: &Signal<NoopRawMutex, ()>,
    report: impl Fn(Report),
) {
    let thermometer = master.sdo(THERMOMETER);
    master.wait_operational(THERMOMETER).await;
    if let Err(error) = write_table(thermometer).await {
        return report(Report::TransferFailed(error));
    }
    report(Report::TableSaved);
    away.reset();
    master.reset(THERMOMETER);
    // The last known state remains Operational until the boot-up message.
    away.wait().await;
    master.wait_operational(THERMOMETER).await;
    report(match is_kept(thermometer).await {
        Ok(true) => Report::TableKept,
        Ok(false) => Report::TableLost,
        Err(error) => Report::TransferFailed(error),
    });
    if let Err(refusal) = master.send_to(THERMOMETER, <Thermometer>::COMMAND_PDO, (1,)) {
        report(Report::NotCommanded(refusal));
    }
}
