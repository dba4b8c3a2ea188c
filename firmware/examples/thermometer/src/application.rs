//! The application of the thermometer: measures ten times a second, and executes commands and resets.

use ecss_can::prelude::*;
use embassy_futures::select::{Either, select};

use crate::{LM75, Thermometer};

/// The sensor does not answer.
const NO_SENSOR: DeviceError = DeviceError::new(ErrorCode::HARDWARE, LM75);
/// Time between measurements.
const PERIOD: Duration = Duration::from_millis(100);

/// Hardware that the application needs besides the node. A test implements it with a mock.
pub trait Hardware {
    /// Reads the register Temp of the sensor, in 1/256 °C. `None`: the sensor does not answer.
    fn temperature(&mut self) -> impl Future<Output = Option<i16>>;

    /// Logs an executed command. `highest` is the highest temperature from now on, in 0.1 °C.
    fn log_command(&mut self, highest: i16);

    /// Resets the chip. On a board it does not return.
    fn reset(&mut self);
}

/// Runs for ever: on a platform `P`, with a table in `S`.
pub async fn application<P: Platform, S: AsRef<[u8]> + AsMut<[u8]> + Default + 'static>(
    slave: Handle<P, Slave<Thermometer<S>>>,
    mut events: impl EventSource<Event = SlaveEvent>,
    mut hardware: impl Hardware,
) {
    let mut due = slave.now();
    loop {
        let register = hardware.temperature().await;
        slave.update(|thermometer| thermometer.measured(register));
        match register {
            Some(_) => slave.clear(NO_SENSOR),
            None => slave.raise(NO_SENSOR, [0; 4]),
        }
        due += PERIOD;
        while let Either::First(event) = select(events.next(), slave.wait_until(due)).await {
            match event {
                SlaveEvent::Pdo(pdo) if pdo.is(Thermometer::<S>::COMMAND_PDO) => {
                    hardware.log_command(slave.update(Thermometer::obey));
                }
                // Sends the present values once, so that receivers of changes have them.
                SlaveEvent::State(NmtState::Operational) => slave.send(Thermometer::CHANGE),
                SlaveEvent::ResetNode => hardware.reset(),
                _ => {}
            }
        }
    }
}
