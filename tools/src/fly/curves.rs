//! Values of PDOs over time, of slaves with a data sheet of the user's.

use std::collections::BTreeMap;

use can_twin::wire::time::Time;
use ecss_can_eds::pdos::Pdo;

use super::flight::Flight;
use super::pdos::Sheets;
use super::record::{Node, is_master};

/// COB-ID of the local time of node 0.
const LOCAL_TIME: u16 = 0x180;

/// A value of a PDO over time. It holds from one frame to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueCurve {
    /// Slave that sends it.
    pub node: Node,
    /// COB-ID of its PDO, for example `383h`.
    pub cob_id: String,
    /// Name in the data sheet.
    pub name: String,
    /// Ends of the frames with the values, in chronological order.
    pub points: Vec<(Time, f64)>,
}

impl ValueCurve {
    /// Returns the lowest and the highest value.
    pub fn range(&self) -> (f64, f64) {
        let values = || self.points.iter().map(|(_, value)| *value);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    }

    /// Returns whether it has two different values.
    pub fn changes(&self) -> bool {
        let (lowest, highest) = self.range();
        lowest < highest
    }
}

/// Returns whether a PDO is the local time of a node (ECSS 7.2.2): fine time of 24 bits, coarse time of 32 bits.
fn is_local_time(node: Node, pdo: &Pdo) -> bool {
    let bits = pdo.fields.iter().map(|field| field.bits);
    pdo.id == LOCAL_TIME + u16::from(node) && bits.eq([24, 32])
}

/// Returns the values of transmit PDOs by node, PDO and place in the PDO. Values that are no numbers are left out, and so is the local
/// time: the report has the errors of the clocks.
pub fn of(flight: &Flight, sheets: &Sheets) -> Vec<ValueCurve> {
    let own: Vec<Node> = sheets.own_nodes().filter(|node| !is_master(*node)).collect();
    let mut found: BTreeMap<(Node, u16, usize), ValueCurve> = BTreeMap::new();
    for (at, seen) in flight.frames().filter(|(_, seen)| own.contains(&seen.from)) {
        let Some((pdo, values)) = sheets.decode(seen).filter(|(pdo, _)| !is_local_time(seen.from, pdo))
        else {
            continue;
        };
        for (place, (name, value)) in values.into_iter().enumerate() {
            let Some(height) = value.height() else { continue };
            let curve = found.entry((seen.from, pdo.number, place)).or_insert_with(|| ValueCurve {
                node: seen.from,
                cob_id: format!("{:03X}h", pdo.id),
                name: name.to_owned(),
                points: Vec::new(),
            });
            curve.points.push((at, height));
        }
    }
    found.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::options::own_sheet;
    use crate::fly::record::Bus;
    use crate::fly::sample;

    const SHEET: &str = "[DeviceInfo]\nProductName=Heater\n[1802sub1]\nDefaultValue=$NODEID+0x380\n[1A02sub0]\nDefaultValue=2\n\
        [1A02sub1]\nDefaultValue=0x20000010\n[1A02sub2]\nDefaultValue=0x20010008\n\
        [1800sub1]\nDefaultValue=$NODEID+0x180\n[1A00sub0]\nDefaultValue=2\n\
        [1A00sub1]\nDefaultValue=0x20020018\n[1A00sub2]\nDefaultValue=0x20030020\n\
        [2000]\nParameterName=Code\nDataType=0x0006\n[2001]\nParameterName=Value\nDataType=0x0002\n";

    /// Given slave 2 with a data sheet of the user's and a last reply with another value, then both values of its PDO are curves, and
    /// the file and the device have their names.
    #[test]
    fn values_of_own_slaves_are_curves() {
        let mut flight = sample::flight();
        let reply = sample::frame(39_999, Bus::Redundant, 2, 0x382, &[4, 1, 0xFB], &[1]);
        sample::insert(&mut flight, reply);
        let time = sample::frame(39_999, Bus::Redundant, 2, 0x182, &[0, 0, 0, 39, 0, 0, 0], &[1]);
        sample::insert(&mut flight, time);
        let here = tempfile::tempdir().unwrap();
        let file = here.path().join("heater.eds");
        std::fs::write(&file, SHEET).unwrap();
        let sheets =
            Sheets::of(&flight.plan, &[own_sheet(&format!("2={}", file.display())).unwrap()]).unwrap();
        let curves = of(&flight, &sheets);
        let [code, value] = &curves[..] else { panic!("{curves:?}") };
        assert_eq!((code.node, &*code.cob_id, &*code.name, code.changes()), (2, "382h", "Code", false));
        assert_eq!((&*value.name, value.range(), value.changes()), ("Value", (-5.0, 1.0), true));
        assert_eq!((code.points.len(), code.range()), (390, (260.0, 260.0)));
        assert_eq!(value.points.last(), Some(&(Time::from_ms(39_999), -5.0)));
        let names = sheets.names();
        assert_eq!((&*names[&2].file, names[&2].device.as_deref()), ("heater.eds", Some("Heater")));
        assert_eq!((&*names[&4].file, names[&4].device.as_deref()), ("slave.eds", Some("Slave")));
    }
}
