//! Emergency messages of a flight: equal ones of a node are one entry.

use serde::Serialize;

use super::emergency;
use super::flight::Flight;
use super::meaning::Meaning;
use super::record::{Node, seconds};

/// Equal emergency messages of a node: same error code, error register and details.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EqualEmergencies {
    /// Board that sent them.
    pub node: Node,
    /// Error code with its meaning (CiA 301 table 26), for example `8130h: heartbeat lost`.
    pub code: String,
    /// Error register with the names of its bits, for example `11h: generic, communication`.
    pub register: String,
    /// Field of the manufacturer, 5 bytes in hexadecimal.
    pub details: String,
    /// Buses on which they completed.
    pub buses: Vec<&'static str>,
    /// Number of messages.
    pub count: u64,
    /// End of the first one, virtual seconds.
    pub first_at_seconds: f64,
    /// End of the last one, virtual seconds.
    pub last_at_seconds: f64,
}

/// Returns the emergency messages of a flight in the order of their first appearance.
pub fn folded(flight: &Flight) -> Vec<EqualEmergencies> {
    let mut found: Vec<EqualEmergencies> = Vec::new();
    for (at, seen) in flight.emergencies() {
        let Some(Meaning::Emergency { node, code, register, details }) = seen.meaning else { continue };
        let at = seconds(at);
        let details: Vec<String> = details.iter().map(|byte| format!("{byte:02X}")).collect();
        let message = EqualEmergencies {
            node: seen.board(node),
            code: format!("{code:04X}h: {}", emergency::meaning(code)),
            register: format!("{register:02X}h: {}", emergency::register(register)),
            details: details.join(" "),
            buses: vec![seen.bus.name()],
            count: 1,
            first_at_seconds: at,
            last_at_seconds: at,
        };
        let Some(equal) = found.iter_mut().find(|earlier| earlier.equals(&message)) else {
            found.push(message);
            continue;
        };
        equal.count += 1;
        equal.last_at_seconds = at;
        if !equal.buses.contains(&seen.bus.name()) {
            equal.buses.push(seen.bus.name());
        }
    }
    found
}

impl EqualEmergencies {
    fn equals(&self, other: &EqualEmergencies) -> bool {
        let content = |message: &EqualEmergencies| {
            (message.node, message.code.clone(), message.register.clone(), message.details.clone())
        };
        content(self) == content(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::record::Bus;
    use crate::fly::sample;

    /// Given an emergency on both buses and later again, its end, and the same one of another node, then equal ones are one entry with
    /// number and times.
    #[test]
    fn equal_emergencies_of_a_node_are_one_entry() {
        let mut flight = sample::flight();
        let lost = [0x30, 0x81, 0x11, 1, 0, 0, 0, 0];
        for (ms, bus, node, data) in [
            (20_700, Bus::Nominal, 2, lost),
            (20_701, Bus::Redundant, 2, lost),
            (21_000, Bus::Redundant, 2, [0; 8]),
            (22_000, Bus::Nominal, 4, lost),
            (30_000, Bus::Redundant, 2, lost),
        ] {
            sample::insert(&mut flight, sample::frame(ms, bus, node, 0x080 + u16::from(node), &data, &[1]));
        }
        let found = folded(&flight);
        let counts: Vec<_> = found.iter().map(|equal| (equal.node, equal.count)).collect();
        assert_eq!(counts, [(2, 3), (2, 1), (4, 1)]);
        let EqualEmergencies { code, register, details, buses, first_at_seconds, last_at_seconds, .. } =
            &found[0];
        let texts = [code, register, details].map(String::as_str);
        assert_eq!(texts, ["8130h: heartbeat lost", "11h: generic, communication", "01 00 00 00 00"]);
        assert_eq!(
            (&buses[..], *first_at_seconds, *last_at_seconds),
            (&["nominal", "redundant"][..], 20.7, 30.0)
        );
    }
}
