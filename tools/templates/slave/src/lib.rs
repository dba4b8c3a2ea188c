//! A heater with a setpoint: the device, and its application. They run on each board and in tests on your computer.

#![no_std]
#![forbid(unsafe_code)]

use ecss_can::prelude::*;

/// The numbers of the network: 1 Mbit/s, heartbeat 100 ms.
pub const PROFILE: Profile = Profile {
    name: "heater",
    ..Profile::DEFAULT
}
.checked();

/// Objects of the heater beside those of every node. The first line of a comment is the name in the data sheet.
#[derive(Debug, Objects)]
#[objects(device)]
pub struct Heater {
    /// Setpoint
    ///
    /// 0.1 °C.
    #[object(0x6000, rw, low = -400, high = 850, default = 200)]
    pub setpoint: i16,
    /// Power
    ///
    /// Percent.
    #[object(0x6001, ro, pdo)]
    pub power: u8,
    /// Schedule
    ///
    /// A block of bytes. "save" (1010h) keeps it, as it keeps the setpoint.
    #[object(0x6002, rw, keep)]
    pub schedule: Domain<[u8; 32]>,
}

/// Power, when it changes: 280h + node.
pub const CHANGE: Pdo<Heater, (u8,)> = Pdo::new(CobIdOf::node(0x280)).map(Heater::POWER);

impl Device for Heater {
    /// Four receive and four transmit PDOs; clients can configure those that are not in the set.
    type Pdos = PdoObjects<4, 4>;
    /// Monitors the master's heartbeat.
    type Consumers = HeartbeatConsumers<1>;

    /// Receives the spacecraft time (181h), sends the local time (180h + node) and the power.
    const PDOS: PdoSet = PdoSet::new(&[SPACECRAFT_TIME], &[LOCAL_TIME, CHANGE.transmit(2)]);

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "Heater",
            identity: Identity {
                vendor: 0,
                product: 1,
                revision: 1 << 16,
                serial: 0,
            },
            ..Communication::new(id)
        }
    }
}

impl Heater {
    /// Switches the power on when the setpoint exceeds the 25 °C outside.
    pub fn control(&mut self) {
        self.power = if self.setpoint > 250 { 100 } else { 0 };
    }
}

/// Runs without end. `reset` resets the chip.
pub async fn application<P: Platform>(
    heater: Handle<P, Slave<Heater>>,
    mut events: impl EventSource<Event = SlaveEvent>,
    reset: impl Fn(),
) {
    heater.update(Heater::control);
    loop {
        match events.next().await {
            SlaveEvent::Written(at) if at == Heater::SETPOINT.address() => {
                heater.update(Heater::control)
            }
            #[cfg(target_os = "none")]
            SlaveEvent::State(state) => defmt::info!("{}", state),
            SlaveEvent::ResetNode => reset(),
            _ => {}
        }
    }
}
