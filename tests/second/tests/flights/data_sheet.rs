//! Frames of a minimal slave, decoded by its data sheet: `docs/eds/minimal.eds` (ECSS 9.2a).

use std::fs;
use std::path::Path;

use can_twin::spacecraft::Bus;
use flight::minimal::{SETUP, standard};
use flight::*;

/// A data sheet, used without other knowledge of the device.
struct Sheet(String);

impl Sheet {
    fn read(name: &str) -> Sheet {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/eds").join(name);
        Sheet(fs::read_to_string(path).unwrap())
    }

    /// Returns the value of a key in a section.
    fn value(&self, section: &str, key: &str) -> Option<&str> {
        let lines = self.0.lines().skip_while(|line| *line != format!("[{section}]")).skip(1);
        let mut entries = lines.take_while(|line| !line.starts_with('['));
        entries.find_map(|line| line.strip_prefix(key)?.strip_prefix('='))
    }

    /// Returns a default value, which is a number or `$NODEID+number`.
    fn number(&self, section: &str, node: u8) -> u32 {
        let text = self.value(section, "DefaultValue").unwrap();
        let (base, text) = text.strip_prefix("$NODEID+").map_or((0, text), |rest| (u32::from(node), rest));
        base + u32::from_str_radix(text.trim_start_matches("0x"), 16).unwrap()
    }

    /// Returns the COB-ID of a TPDO.
    fn cob_id(&self, number: u16, node: u8) -> u16 {
        (self.number(&format!("{:X}sub1", 0x1800 + number), node) & 0x7FF) as u16
    }

    /// Returns the objects of a TPDO: names, and lengths in bits.
    fn mapped(&self, number: u16) -> Vec<(&str, usize)> {
        let mapping = 0x1A00 + number;
        let objects = 1..=self.number(&format!("{mapping:X}sub0"), 0);
        let mapped = objects.map(|object| self.number(&format!("{mapping:X}sub{object}"), 0));
        mapped
            .map(|entry| {
                let (index, sub, bits) = (entry >> 16, entry >> 8 & 0xFF, entry & 0xFF);
                let name = self.value(&format!("{index:X}sub{sub:X}"), "ParameterName");
                (name.unwrap(), bits as usize)
            })
            .collect()
    }
}

/// Given a flight of a minimal slave, when a client decodes the answers to SYNC by the data sheet, then it reads the
/// number of commands that the master has sent before.
///
/// Verifies: ECSS 9.2a
#[test]
fn data_sheet_decodes_the_frames_of_a_minimal_slave() {
    let mut flight = standard(&[MASTER_AND_THREE[0], SETUP]);
    flight.fly_to(3_000);
    let sheet = Sheet::read("minimal.eds");
    let mapped = sheet.mapped(1);
    assert_eq!(mapped, [("Commands executed", 32), ("State of the LED", 8)]);

    let mut decoded = 0;
    for frame in flight.sent(SETUP.node, Bus::Nominal, sheet.cob_id(1, SETUP.node)) {
        let bits: usize = mapped.iter().map(|(_, bits)| bits).sum();
        assert_eq!(frame.data().len() * 8, bits);
        let (commands, led) = frame.data().split_at(mapped[0].1 / 8);
        let sent = flight.sent(1, Bus::Nominal, 0x300 + u16::from(SETUP.node));
        let before = sent.filter(|command| command.end < frame.start).count();
        let commands = u32::from_le_bytes(commands.try_into().unwrap()) as usize;
        // One may be in progress in the slave.
        assert!(commands == before || commands + 1 == before, "{commands} of {before}");
        assert!(led[0] <= 1);
        decoded += 1;
    }
    assert!(decoded >= 20, "{decoded}");
}
