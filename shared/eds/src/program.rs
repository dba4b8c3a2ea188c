//! The host program of a device's crate.

use std::io::Write;
use std::process::ExitCode;

use async_canopen::node::{CanopenOnly, CanopenSlave, NodeObjects, Settings};
use ecss_can::node::{self, Master, Slave};
use ecss_can::od::Objects;
use ecss_can::profile::Profile;
use ecss_can::types::NodeId;

use crate::{Commissioning, Description, Device};

/// Prints the data sheet of the slave `D`, or with `--node 3` the configuration of its node 3. Call it in `main` of the device's
/// crate where that is built for the host; `sheet` has what the declaration does not say.
///
/// `ecss-can eds --package NAME` runs that program and writes what it prints. The files are named after
/// [`Device::order_code`], or else after the product. The bit rate is that of the profile where `sheet` has none. With a profile
/// below 125 kbit/s, `sheet` has to name all bit rates (ECSS 5.4.2b).
pub fn slave_program<D: node::SpacecraftDevice>(profile: &Profile, sheet: Device) -> ExitCode {
    let sheet = Device { boot_up_slave: true, ..sheet };
    program(&with_bit_rate(sheet, profile), |id| {
        let mut objects = Slave::builder(id, profile, D::default()).build().into_objects();
        // Boards have a parameter store.
        (objects.extension.storage.store, objects.extension.storage.restore) = ([1; 4], [1; 4]);
        objects
    })
}

/// As [`slave_program`], for the master `D`.
pub fn master_program<D: node::SpacecraftDevice>(profile: &Profile, sheet: Device) -> ExitCode {
    let id = NodeId::MASTER.get();
    let sheet = Device { boot_up_master: true, nodes: id..=id, ..sheet };
    program(&with_bit_rate(sheet, profile), |_| {
        let mut objects = Master::builder(profile, D::default()).build().into_objects();
        (objects.extension.storage.store, objects.extension.storage.restore) = ([1; 4], [1; 4]);
        objects
    })
}

/// As [`slave_program`], for the CANopen slave `D` on one bus ([`CanopenSlave`]). It has no parameter store. `settings` has the
/// heartbeats at power-on; name the bit rates in `sheet`.
///
/// ```no_run
/// use async_canopen::prelude::*;
///
/// /// Valve that its master commands by SDO or PDO.
/// #[derive(Debug, Objects)]
/// #[objects(device)]
/// struct Valve {
///     /// Opening in percent
///     #[object(0x6000, rww, pdo, high = 100)]
///     opening: u8,
/// }
///
/// impl Device for Valve {
///     type Pdos = PdoObjects<1, 0>;
///     type Consumers = HeartbeatConsumers<1>;
///     const PDOS: PdoSet = PdoSet::new(&[Pdo::<()>::new(CobIdOf::node(0x200)).map(Valve::OPENING).receive(1)], &[]);
/// }
///
/// fn main() -> std::process::ExitCode {
///     let made = ecss_can_eds::Timestamp::noon(2026, 11, 22);
///     let sheet = ecss_can_eds::Device { product: "Valve".into(), bit_rates: vec![250], ..ecss_can_eds::Device::new(made) };
///     ecss_can_eds::canopen_program::<Valve>(&Settings::DEFAULT, sheet)
/// }
/// ```
pub fn canopen_program<D: node::Device>(settings: &Settings, sheet: Device) -> ExitCode {
    program(&Device { boot_up_slave: true, ..sheet }, canopen_objects::<D>(settings))
}

/// Makes the dictionary of a node that is the CANopen slave `D`, as it is after power-on.
fn canopen_objects<D: node::Device>(settings: &Settings) -> impl Fn(NodeId) -> NodeObjects<D, CanopenOnly> {
    |id| CanopenSlave::new(id, settings, D::default()).into_objects()
}

/// As [`slave_program`], for a device of any kind; `objects` makes the dictionary of a node as it is after power-on.
pub fn program<D: Objects>(device: &Device, objects: impl Fn(NodeId) -> D) -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match text(device, objects, &arguments) {
        Ok(text) => match std::io::stdout().write_all(text.as_bytes()) {
            Ok(()) => ExitCode::SUCCESS,
            // Its reader has left.
            Err(_) => ExitCode::FAILURE,
        },
        Err(complaint) => {
            eprintln!("{complaint}");
            ExitCode::from(2)
        }
    }
}

fn with_bit_rate(mut sheet: Device, profile: &Profile) -> Device {
    if sheet.bit_rates.is_empty() {
        sheet.bit_rates.push((profile.network.bit_rate.get() / 1000) as u16);
    }
    sheet
}

/// What is printed for these arguments, or the complaint about them.
fn text<D: Objects>(
    device: &Device,
    objects: impl Fn(NodeId) -> D,
    arguments: &[String],
) -> Result<String, String> {
    let name = if device.order_code.is_empty() { &device.product } else { &device.order_code };
    let stem = if name.is_empty() { "device".into() } else { name.to_lowercase().replace(' ', "-") };
    let eds = format!("{stem}.eds");
    let description = Description::new(device, &objects).map_err(|error| error.to_string())?;
    match arguments {
        [] => Ok(description.eds(&eds)),
        [option, node] if option == "--node" => {
            let allowed = || {
                let (first, last) = (device.nodes.start(), device.nodes.end());
                format!("--node {node}: allowed are Node-IDs {first} to {last}")
            };
            let number: u8 = node.parse().map_err(|_| allowed())?;
            let id = NodeId::new(number).filter(|_| device.nodes.contains(&number)).ok_or_else(allowed)?;
            let name = format!("{stem}-{number}.dcf");
            let commissioning = Commissioning {
                bit_rate: device.bit_rates.iter().copied().max().unwrap_or(1000),
                ..Commissioning::new(id)
            };
            let dcf = description.dcf(&name, &eds, &commissioning, &mut objects(id));
            dcf.map_err(|error| error.to_string())
        }
        _ => {
            Err("allowed are no arguments for the data sheet (EDS), or --node N for a configuration (DCF)"
                .into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Timestamp;
    use ecss_can::heartbeat::HeartbeatConsumers;
    use ecss_can::node::Communication;
    use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};

    /// CANopen slave on one bus.
    #[derive(Debug, Objects)]
    #[objects(device)]
    struct Gauge {
        /// Pressure
        #[object(0x6000, ro, pdo)]
        pressure: u16,
    }

    impl node::Device for Gauge {
        type Pdos = PdoObjects<1, 1>;
        type Consumers = HeartbeatConsumers<1>;

        const PDOS: PdoSet =
            PdoSet::new(&[], &[Pdo::<()>::new(CobIdOf::node(0x180)).map(Gauge::PRESSURE).transmit(1)]);
    }

    fn tracker(arguments: &[&str]) -> Result<String, String> {
        let made = Timestamp { year: 2026, month: 11, day: 22, hour: 12, minute: 0 };
        let device = Device { order_code: "tracker".into(), nodes: 2..=15, ..Device::new(made) };
        let arguments: Vec<String> = arguments.iter().map(|&argument| argument.into()).collect();
        text(&device, Communication::new, &arguments)
    }

    /// Verifies: ECSS 6.6a, 9.2a
    #[test]
    fn no_argument_gives_the_data_sheet() {
        let eds = tracker(&[]).unwrap();
        assert!(eds.contains("FileName=tracker.eds") && !eds.contains("[DeviceComissioning]"), "{eds}");
    }

    /// Verifies: ECSS 6.6a
    #[test]
    fn a_node_gives_its_configuration() {
        let dcf = tracker(&["--node", "3"]).unwrap();
        assert!(dcf.contains("FileName=tracker-3.dcf") && dcf.contains("NodeID=3"), "{dcf}");
    }

    #[test]
    fn another_argument_is_refused_with_what_is_allowed() {
        for (wrong, allowed) in
            [(&["--node", "1"][..], "2 to 15"), (&["--node", "x"], "2 to 15"), (&["3"], "--node N")]
        {
            assert!(tracker(wrong).unwrap_err().contains(allowed), "{wrong:?}");
        }
    }

    /// Given a CANopen slave on one bus, then its data sheet has its objects, PDOs and heartbeats, and neither a parameter store nor
    /// objects of redundancy and spacecraft time.
    #[test]
    fn plain_slave_has_its_own_objects_and_those_of_cia_301() {
        let made = Timestamp::noon(2026, 11, 22);
        let sheet = Device { bit_rates: vec![250], ..Device::new(made) };
        let eds = text(&sheet, canopen_objects::<Gauge>(&Settings::DEFAULT), &[]).unwrap();
        let value = |section: &str, key: &str| {
            let (_, rest) = eds.split_once(&format!("[{section}]\n"))?;
            let lines = rest.lines().take_while(|line| !line.starts_with('['));
            lines
                .filter_map(|line| line.split_once('='))
                .find(|(name, _)| *name == key)
                .map(|(_, value)| value)
        };
        assert_eq!(value("6000", "ParameterName"), Some("Pressure"));
        assert_eq!(value("1800sub1", "DefaultValue"), Some("$NODEID+0x40000180"));
        assert_eq!(value("1A00sub1", "DefaultValue"), Some("0x60000010"));
        assert_eq!(value("1017", "DefaultValue"), Some("0x0064"));
        assert_eq!(value("1016sub1", "DefaultValue"), Some("0x000100FA"));
        for absent in ["1010", "1011", "2000", "2010"] {
            assert_eq!(value(absent, "ParameterName"), None, "{absent}h");
        }
    }
}
