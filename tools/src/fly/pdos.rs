//! Values of PDOs with the names of their objects in the data sheets of the boards.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use can_twin::wire::frame::WireId;
use ecss_can_eds::pdos::{self, Pdo};
use serde::Serialize;

use super::flight::Flight;
use super::narrator::name;
use super::plan::{BoardPlan, Plan};
use super::record::{Seen, seconds};
use super::sheet::{IDENTITY, Number, Sheet, values};
use crate::images::support::board::Profile;
use crate::images::support::fleet::NodeFile;
use crate::images::support::misuse::Misuse;
use crate::images::support::node::{MASTER, Node, is_master};

/// Data sheets of the shipped images.
const OF_MASTER: &str = include_str!("../../eds/master.eds");
const OF_SLAVE: &str = include_str!("../../eds/slave.eds");
const OF_MINIMAL: &str = include_str!("../../eds/minimal.eds");
const OF_MINIMAL_LIBRECUBE: &str = include_str!("../../eds/minimal-librecube.eds");

/// Data sheets of the boards.
#[derive(Clone, Debug, Default)]
pub struct Sheets {
    of: BTreeMap<Node, Sheet>,
    /// Nodes with the data sheet of a shipped image, with its file in `docs/eds`.
    shipped: BTreeMap<Node, &'static str>,
    /// Nodes with a data sheet of the user's, with its file.
    own: BTreeMap<Node, PathBuf>,
}

/// Name of a data sheet.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct SheetName {
    /// File name, without its folder.
    pub file: String,
    /// Name of the device (`ProductName` in `[DeviceInfo]`); `null` if the file has none.
    pub device: Option<String>,
}

/// First bytes of the answers to an SDO upload, with the number of bytes of the value. The last answer does not give that number.
const ANSWERS: [(u8, usize); 5] = [(0x43, 4), (0x47, 3), (0x4B, 2), (0x4F, 1), (0x42, 4)];

/// COB-IDs of PDOs in the pre-defined connection set.
const PDO_IDS: RangeInclusive<u16> = 0x181..=0x57F;

/// The last values of a PDO.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PdoValues {
    /// Board that sends it.
    pub node: Node,
    /// Number of the transmit PDO, from 1.
    pub pdo: u16,
    /// COB-ID, for example `382h`.
    pub cob_id: String,
    /// Number of its frames that completed, on both buses.
    pub frames: u64,
    /// End of the last one, virtual seconds.
    pub last_at_seconds: f64,
    /// Names of its objects, with the values in the last frame.
    pub values: Vec<(String, String)>,
}

impl Sheets {
    /// Reads the data sheets of the shipped images of a plan, and those of the user.
    ///
    /// # Errors
    /// When a file of the user cannot be read or is no data sheet, or its node is not in the plan.
    pub fn of(plan: &Plan, own: &[NodeFile]) -> Result<Sheets, Misuse> {
        let wrong = |NodeFile { node, file }: &NodeFile, cause: String| {
            Misuse::value("fly", "--eds <N=FILE>", format_args!("{node}={}", file.display()), cause)
        };
        let mut sheets = Sheets::default();
        for own in own {
            if !plan.boards.iter().any(|board| board.node == own.node) {
                let cause = format!("no board is node {}; give the Node-ID of one that runs", own.node);
                return Err(wrong(own, cause));
            }
            let bytes = std::fs::read(&own.file).map_err(|error| wrong(own, error.to_string()))?;
            let sheet =
                Sheet::read(&bytes, node_id(own.node)).map_err(|cause| wrong(own, cause.to_string()))?;
            sheets.own.insert(own.node, own.file.clone());
            if sheets.of.insert(own.node, sheet).is_some() {
                return Err(wrong(own, format!("node {} has two; give one", own.node)));
            }
        }
        for board in &plan.boards {
            if let Some((file, text)) = shipped(plan, board)
                && !sheets.of.contains_key(&board.node)
            {
                let sheet = Sheet::read(text.as_bytes(), node_id(board.node));
                let sheet = sheet.map_err(|cause| Misuse::of("fly", format!("docs/eds: {cause}")))?;
                sheets.of.insert(board.node, sheet);
                sheets.shipped.insert(board.node, file);
            }
        }
        Ok(sheets)
    }

    /// Returns notes about entries of the user's data sheets that the report leaves out.
    pub fn notes(&self) -> Vec<String> {
        self.own()
            .flat_map(|(node, file, sheet)| {
                let nothing =
                    format!("no transmit PDO with known objects: the report has no values of node {node}");
                let notes = sheet.notes.iter().cloned().chain(sheet.pdos.is_empty().then_some(nothing));
                notes.map(|note| format!("{}: {note}", file.display())).collect::<Vec<_>>()
            })
            .collect()
    }

    /// Returns differences of the nodes of a flight from the user's data sheets: a file may be that of another device.
    pub fn differences(&self, flight: &Flight) -> Vec<String> {
        self.own()
            .flat_map(|(node, file, sheet)| {
                let differences = differences(node, sheet, flight);
                differences.into_iter().map(|difference| {
                    format!("{}: {difference}; is it the file of another device?", file.display())
                })
            })
            .collect()
    }

    fn own(&self) -> impl Iterator<Item = (Node, &Path, &Sheet)> {
        self.own.iter().filter_map(|(node, file)| Some((*node, file.as_path(), self.of.get(node)?)))
    }

    /// Returns receive PDOs that do not match their transmit PDOs, by the data sheets of both. A COB-ID without sender
    /// is reported if its receiver is an image of the user's and each board has a data sheet: the shipped master has
    /// PDOs for slaves that are not in the flight.
    pub fn mismatches(&self, plan: &Plan) -> Vec<String> {
        let of = |board: &BoardPlan| Some(self.of.get(&board.node)?.node(&name(board.node)));
        let nodes: Vec<pdos::Node> = plan.boards.iter().filter_map(of).collect();
        let is_own = |text: &String| {
            let mut own = plan.boards.iter().filter(|board| board.own_image.is_some());
            own.any(|board| text.starts_with(&format!("{}:", name(board.node))))
        };
        let unsent = if nodes.len() == plan.boards.len() { pdos::unsent(&nodes) } else { Vec::new() };
        pdos::mismatches(&nodes).into_iter().chain(unsent.into_iter().filter(is_own)).collect()
    }

    /// Returns the name of each board's data sheet.
    pub fn names(&self) -> BTreeMap<Node, SheetName> {
        let name = |(node, sheet): (&Node, &Sheet)| {
            let name =
                self.own.get(node).and_then(|path| path.file_name()).map(|name| name.to_string_lossy());
            let file =
                name.map_or_else(|| self.shipped.get(node).copied().unwrap_or_default().into(), Into::into);
            (*node, SheetName { file, device: sheet.product.clone() })
        };
        self.of.iter().map(name).collect()
    }

    /// Returns whether the data sheet of a node has a receive PDO with a COB-ID; `None` without a data sheet.
    pub fn receives(&self, node: Node, id: u16) -> Option<bool> {
        Some(self.of.get(&node)?.received.iter().any(|pdo| pdo.id == id))
    }

    /// Returns the nodes with a data sheet of the user's.
    pub fn own_nodes(&self) -> impl Iterator<Item = Node> {
        self.own.keys().copied()
    }

    /// Returns the PDO of a frame and its values by name; `None` if the data sheet of its sender has no such PDO.
    pub fn decode<'a>(&'a self, seen: &Seen) -> Option<(&'a Pdo, Vec<(&'a str, Number)>)> {
        let WireId::Standard(id) = seen.frame.id else { return None };
        let pdo = self.of.get(&seen.from)?.pdos.iter().find(|pdo| pdo.id == id)?;
        Some((pdo, values(pdo, seen.frame.payload())?))
    }

    /// Returns the last values of all PDOs that were sent, by board and number.
    pub fn values(&self, flight: &Flight) -> Vec<PdoValues> {
        let mut found: BTreeMap<(Node, u16), PdoValues> = BTreeMap::new();
        for (at, seen) in flight.frames() {
            let Some((pdo, values)) = self.decode(seen) else { continue };
            let entry = found.entry((seen.from, pdo.number)).or_insert_with(|| PdoValues {
                node: seen.from,
                pdo: pdo.number,
                cob_id: format!("{:03X}h", pdo.id),
                frames: 0,
                last_at_seconds: 0.0,
                values: Vec::new(),
            });
            entry.frames += 1;
            entry.last_at_seconds = seconds(at);
            entry.values =
                values.into_iter().map(|(name, value)| (name.to_owned(), value.to_string())).collect();
        }
        found.into_values().collect()
    }
}

/// Returns the differences of a node from its data sheet as text.
fn differences(node: Node, sheet: &Sheet, flight: &Flight) -> Vec<String> {
    let sent = flight.frames().filter(|(_, seen)| seen.from == node && !seen.frame.remote);
    let frames: Vec<(u16, &[u8])> = sent
        .filter_map(|(_, seen)| match seen.frame.id {
            WireId::Standard(id) => Some((id, seen.frame.payload())),
            WireId::Extended(_) => None,
        })
        .collect();
    let of = |id: u16| frames.iter().filter(move |(own, _)| *own == id).map(|(_, data)| *data);
    let answer = 0x580 + u16::from(node_id(node));
    let answers: BTreeMap<(u16, u8), u32> = of(answer).filter_map(uploaded).collect();
    let mut differences = Vec::new();
    for (object, known) in IDENTITY.into_iter().zip(sheet.identity) {
        let (Some(known), Some(&has)) = (known, answers.get(&object)) else { continue };
        let is_other = match object {
            (0x1000, _) => known != has,
            // The lower half is the minor revision, with the same CANopen behaviour.
            (_, 3) => known > 0 && known >> 16 != has >> 16,
            // 0: not filled in.
            _ => known > 0 && known != has,
        };
        if is_other {
            let (index, sub) = object;
            differences.push(format!(
                "object {index:04X}h sub {sub:02X}h is {known:08X}h there, node {node} has {has:08X}h"
            ));
        }
    }
    for pdo in &sheet.pdos {
        let lengths = of(pdo.id).map(<[u8]>::len);
        if let Some(length) = lengths.filter(|length| *length != pdo.bytes() as usize).min() {
            let (number, id, bytes) = (pdo.number, pdo.id, pdo.bytes());
            differences.push(format!(
                "TPDO {number} ({id:03X}h) has {bytes} bytes there, node {node} sends {length}"
            ));
        }
    }
    let known: BTreeSet<u16> =
        sheet.pdos.iter().map(|pdo| pdo.id).chain(sheet.others.iter().copied()).collect();
    let ids: BTreeSet<u16> = frames.iter().map(|(id, _)| *id).filter(|id| PDO_IDS.contains(id)).collect();
    let unknown: Vec<String> = ids.difference(&known).map(|id| format!("{id:03X}h")).collect();
    if !unknown.is_empty() {
        let unknown = unknown.join(", ");
        differences.push(format!("node {node} sends {unknown}, which no transmit PDO has there"));
    }
    differences
}

/// Index, sub-index and value of the answer to an SDO upload.
fn uploaded(data: &[u8]) -> Option<((u16, u8), u32)> {
    let [first, low, high, sub, value @ ..] = data else { return None };
    let (_, bytes) = ANSWERS.into_iter().find(|(specifier, _)| specifier == first)?;
    let value = value.get(..bytes)?.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
    Some(((u16::from_le_bytes([*low, *high]), *sub), value))
}

/// Node-ID of a board: both masters have 1.
fn node_id(node: Node) -> Node {
    if is_master(node) { MASTER } else { node }
}

/// File name and text of the data sheet of a shipped image; `None` for an image of the user's.
fn shipped(plan: &Plan, board: &BoardPlan) -> Option<(&'static str, &'static str)> {
    match (&board.own_image, board.is_minimal) {
        (Some(_), _) => None,
        (None, _) if is_master(board.node) => Some(("master.eds", OF_MASTER)),
        (None, true) if plan.profile == Profile::Librecube => {
            Some(("minimal-librecube.eds", OF_MINIMAL_LIBRECUBE))
        }
        (None, true) => Some(("minimal.eds", OF_MINIMAL)),
        (None, false) => Some(("slave.eds", OF_SLAVE)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::options::own_sheet;
    use crate::fly::record::Bus;
    use crate::fly::sample;

    /// Given a master that distributes its time every 10 s, the last time 30 s at 30.05 s, then the PDO has both parts by name.
    #[test]
    fn spacecraft_time_of_the_shipped_master_has_names() {
        let flight = sample::flight();
        let mut all = Sheets::of(&flight.plan, &[]).unwrap().values(&flight);
        all.retain(|pdo| pdo.node == 1);
        let time = all.first().expect("spacecraft time of the master");
        assert_eq!((time.pdo, &*time.cob_id), (1, "181h"));
        let value =
            |name: &str| time.values.iter().find(|(own, _)| own.contains(name)).map(|(_, value)| &**value);
        assert_eq!((value("Coarse"), value("Fine")), (Some("30"), Some("0")), "{time:?}");
        // At 20.05 s no node acknowledged the master.
        assert_eq!((time.frames, time.last_at_seconds), (3, 30.05));
    }

    /// Given the shipped images, then their mappings match. Given a slave of the user's with another order, another COB-ID and a PDO that is
    /// too long, then each is named; the last two only when all boards have data sheets.
    #[test]
    fn mappings_that_differ_are_named_by_both_sheets() {
        let mut plan = sample::plan();
        let shipped = Sheets::of(&plan, &[]).unwrap();
        assert_eq!(shipped.mismatches(&plan), [""; 0]);
        let sheet = |text: &str| Sheet::read(text.as_bytes(), 2).unwrap();
        let own = "[1400sub1]\nDefaultValue=0x40000181\n\
            [1600sub0]\nDefaultValue=2\n[1600sub1]\nDefaultValue=0x21000120\n[1600sub2]\nDefaultValue=0x21000218\n\
            [2100sub1]\nParameterName=Coarse\nDataType=0x0007\n[2100sub2]\nParameterName=Fine\nDataType=0x0016\n\
            [1401sub1]\nDefaultValue=0x333\n[1601sub0]\nDefaultValue=1\n[1601sub1]\nDefaultValue=0x21000120\n";
        plan.boards[1].own_image = Some("own".into());
        let mut sheets = Sheets::of(&plan, &[]).unwrap();
        sheets.of.insert(2, sheet(own));
        let said = sheets.mismatches(&plan);
        let differs = "node 2: RPDO 1 (181h) has Coarse with 32 bits at place 1, TPDO 1 of master has ";
        assert!(said[0].starts_with(differs), "{said:?}");
        assert_eq!(said[1..], ["node 2: RPDO 2 (333h) is sent by no node"]);
        sheets.of.insert(2, sheet(&own.replace("0x21000218\n", "0x21000220\n")));
        let said = sheets.mismatches(&plan);
        let rejected = "has 8 bytes, TPDO 1 of master has 7: the receiver rejects it";
        assert!(said[0].ends_with(rejected), "{said:?}");
        sheets.of.remove(&4);
        assert_eq!(sheets.mismatches(&plan).len(), 1, "node 4 may send 333h");
    }

    #[test]
    fn a_sheet_of_the_user_is_a_node_and_a_file() {
        assert_eq!(own_sheet("3=a=b.eds"), Ok(NodeFile { node: 3, file: "a=b.eds".into() }));
        for (wrong, said) in [("3", "for example"), ("0=x", "1 to 15"), ("16=x", "1 to 15"), ("3=", "file")] {
            assert!(own_sheet(wrong).is_err_and(|error| error.contains(said)), "{wrong}");
        }
    }

    #[test]
    fn a_sheet_of_no_board_and_a_text_that_is_none_are_refused() {
        let own = NodeFile { node: 9, file: "a.eds".into() };
        let error = Sheets::of(&sample::plan(), &[own]).unwrap_err().to_string();
        let parts = ["'9=a.eds' for '--eds <N=FILE>'", "no board is node 9"];
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        let error = of_node_2("# Heater\n\nA heater = 5 W.\n").map(drop).unwrap_err().to_string();
        let parts = ["for '--eds <N=FILE>'", "no EDS or DCF (CiA 306)"];
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }

    /// The data sheets of a user: node 2 with this text.
    fn of_node_2(text: &str) -> Result<Sheets, Misuse> {
        let here = tempfile::tempdir().unwrap();
        let file = here.path().join("a.eds");
        std::fs::write(&file, text).unwrap();
        Sheets::of(&sample::plan(), &[NodeFile { node: 2, file }])
    }

    /// Node 2 sends 382h with 3 bytes, and answers uploads of its identity.
    fn flight_with_answers() -> Flight {
        let mut flight = sample::flight();
        for answer in [
            [0x43, 0x00, 0x10, 0, 0x91, 0x01, 0x02, 0x00],
            [0x43, 0x18, 0x10, 1, 0x34, 0x12, 0x00, 0x00],
            [0x4B, 0x18, 0x10, 2, 0x15, 0x50, 0x00, 0x00],
            [0x43, 0x18, 0x10, 3, 0x07, 0x00, 0x02, 0x00],
            // An abort, and a download that was accepted.
            [0x80, 0x18, 0x10, 1, 0x00, 0x00, 0x02, 0x06],
            [0x60, 0x00, 0x10, 0, 0x00, 0x00, 0x00, 0x00],
        ] {
            flight.records.push(sample::frame(30_000, Bus::Nominal, 2, 0x582, &answer, &[]));
        }
        flight
    }

    const OF_NODE_2: &str = "[1000]\nDefaultValue=0x20191\n[1018sub1]\nDefaultValue=0x1234\n[1018sub2]\nDefaultValue=0x5015\n\
        [1018sub3]\nDefaultValue=0x20001\n[1802sub1]\nDefaultValue=$NODEID+0x380\n[1A02sub0]\nDefaultValue=2\n\
        [1A02sub1]\nDefaultValue=0x20000010\n[1A02sub2]\nDefaultValue=0x20010008\n";

    /// Given a data sheet that differs from what its node sends and answers, then each difference is named with both values.
    #[test]
    fn data_sheet_of_another_device_is_named() {
        let flight = flight_with_answers();
        let differences = |text: &str| of_node_2(text).unwrap().differences(&flight);
        assert_eq!(differences(OF_NODE_2), Vec::<String>::new());
        for (own, other, said) in [
            ("0x20191", "0x191", "object 1000h sub 00h is 00000191h there, node 2 has 00020191h"),
            ("0x1234", "0x4321", "object 1018h sub 01h is 00004321h there, node 2 has 00001234h"),
            ("0x5015", "0x5016", "object 1018h sub 02h is 00005016h there, node 2 has 00005015h"),
            ("0x20001", "0x30001", "object 1018h sub 03h is 00030001h there, node 2 has 00020007h"),
            ("0x20010008", "0x20010010", "TPDO 3 (382h) has 4 bytes there, node 2 sends 3"),
            ("$NODEID+0x380", "$NODEID+0x280", "node 2 sends 382h, which no transmit PDO has there"),
        ] {
            assert!(OF_NODE_2.contains(own), "{own}");
            let differences = differences(&OF_NODE_2.replacen(own, other, 1));
            let [difference] = &differences[..] else { panic!("{own}: {differences:?}") };
            assert!(difference.contains("a.eds: ") && difference.contains(said), "{difference}");
        }
        // Entries that the file does not have, and the multiplex PDO, whose COB-ID is known.
        let silent = OF_NODE_2
            .replace("0x1234", "0")
            .replace("0x20191", "")
            .replace("DefaultValue=2\n", "DefaultValue=0xFE\n");
        assert_eq!(differences(&silent), Vec::<String>::new());
    }

    /// Given a data sheet of the user with an entry that is not understood, then a note has its file, line, section and key.
    #[test]
    fn entries_that_are_left_out_are_noted_with_their_file() {
        assert_eq!(of_node_2(OF_NODE_2).unwrap().notes(), Vec::<String>::new());
        let notes = of_node_2(&OF_NODE_2.replace("$NODEID+0x380", "MODULE")).unwrap().notes();
        let [left_out, nothing] = &notes[..] else { panic!("{notes:?}") };
        assert!(left_out.contains("a.eds: line 10: [1802sub1] DefaultValue=MODULE: "), "{left_out}");
        assert!(left_out.ends_with("; TPDO 3 is left out"), "{left_out}");
        let expected = "a.eds: no transmit PDO with known objects: the report has no values of node 2";
        assert!(nothing.ends_with(expected), "{nothing}");
    }
}
