//! Receive PDOs of the devices of a network, compared with the transmit PDOs that they are to receive.
//!
//! A *mapping* says which objects a PDO carries, and in which order. Sender and receiver have one each, and nothing in a frame shows
//! whether they agree. [`mismatches`] compares each receive PDO with the transmit PDO of the same COB-ID:
//!
//! ```
//! use ecss_can_eds::pdos::{Field, Node, Pdo, mismatches};
//!
//! let field = |name: &str, bits| Field { name: name.into(), data_type: 0x05, bits };
//! let pdo = |fields| Pdo { number: 1, id: 0x185, fields };
//! let heater = Node { sent: vec![pdo(vec![field("Power", 8)])], ..Node::new("node 5") };
//! let master = Node { received: vec![pdo(vec![field("Power", 8), field("State", 8)])], ..Node::new("master") };
//! let said = mismatches(&[heater, master]);
//! assert!(said[0].starts_with("master: RPDO 1 (185h) has 2 bytes, TPDO 1 of node 5 has 1"));
//! ```
//!
//! It compares lengths, data types where both are known, and names: names in another order are fields that were swapped.

use ecss_can::od::Objects;
use ecss_can::od::checked::find;
use ecss_can::types::Address;

use crate::Error;
use crate::dictionary::numbered;

/// First communication record of each direction, number of records, and the distance to their mapping.
const RPDOS: u16 = 0x1400;
const TPDOS: u16 = 0x1800;
const RECORDS: u16 = 0x200;
const TO_MAPPING: u16 = 0x200;

/// Bits of a COB-ID entry that exclude a PDO: not valid; 29-bit identifier.
const EXCLUDED: u32 = 1 << 31 | 1 << 29;

/// First index of an object. Lower ones are data types: an RPDO that maps one skips bits of the length of that type (CiA 301, dummy mapping).
pub const FIRST_OBJECT: u32 = 0x1000;

/// PDOs of a device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Node {
    /// Its name.
    pub name: String,
    /// Transmit PDOs.
    pub sent: Vec<Pdo>,
    /// Receive PDOs.
    pub received: Vec<Pdo>,
}

/// A valid PDO with objects.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pdo {
    /// Number, from 1.
    pub number: u16,
    /// COB-ID.
    pub id: u16,
    /// Its objects in their order.
    pub fields: Vec<Field>,
}

/// An object in a PDO.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name of the object and of its sub-index, joined by a comma; empty for bits that a receiver skips.
    pub name: String,
    /// Data type, its index in CiA 301 table 44; 0 when it is not known.
    pub data_type: u32,
    /// Length in bits, 1 to 64.
    pub bits: u32,
}

impl Node {
    /// A node without PDOs.
    pub fn new(name: &str) -> Node {
        Node { name: name.to_owned(), ..Node::default() }
    }

    /// The PDOs of a dictionary `D`, as their objects are now.
    ///
    /// # Errors
    /// When a text of the dictionary cannot stand in an EDS.
    pub fn of<D: Objects, P: Objects>(name: &str, objects: &mut P) -> Result<Node, Error> {
        let names = names::<D>()?;
        Ok(Node {
            name: name.to_owned(),
            sent: pdos(objects, TPDOS, &names),
            received: pdos(objects, RPDOS, &names),
        })
    }
}

impl Pdo {
    pub fn bytes(&self) -> u32 {
        self.fields.iter().map(|field| field.bits).sum::<u32>().div_ceil(8)
    }
}

impl Field {
    /// Returns whether the receiver has no object for it.
    fn is_skipped(&self) -> bool {
        self.name.is_empty()
    }

    /// The last part of the name in small letters: that of the value itself.
    fn value(&self) -> String {
        self.name.rsplit(", ").next().unwrap_or_default().to_lowercase()
    }
}

/// Finds receive PDOs that do not fit the transmit PDO of the same COB-ID, and says what does not.
pub fn mismatches(nodes: &[Node]) -> Vec<String> {
    let mut found = Vec::new();
    for (receiver, rpdo) in nodes.iter().flat_map(|node| node.received.iter().map(move |pdo| (node, pdo))) {
        for (sender, tpdo) in senders(nodes, receiver, rpdo) {
            let head = format!("{}: RPDO {} ({:03X}h) has ", receiver.name, rpdo.number, rpdo.id);
            let of = format!("TPDO {} of {} has ", tpdo.number, sender.name);
            found.extend(mismatch(rpdo, tpdo).map(|[mine, theirs]| format!("{head}{mine}, {of}{theirs}")));
        }
    }
    found
}

/// Finds receive PDOs with a COB-ID that no transmit PDO of these nodes has.
pub fn unsent(nodes: &[Node]) -> Vec<String> {
    let all = nodes.iter().flat_map(|node| node.received.iter().map(move |pdo| (node, pdo)));
    let unsent = all.filter(|(node, rpdo)| senders(nodes, node, rpdo).next().is_none());
    unsent
        .map(|(node, rpdo)| {
            format!("{}: RPDO {} ({:03X}h) is sent by no node", node.name, rpdo.number, rpdo.id)
        })
        .collect()
}

/// The transmit PDOs of other nodes that a receive PDO receives.
fn senders<'a>(
    nodes: &'a [Node],
    receiver: &'a Node,
    rpdo: &'a Pdo,
) -> impl Iterator<Item = (&'a Node, &'a Pdo)> {
    let others = nodes.iter().filter(|node| !std::ptr::eq(*node, receiver));
    others.flat_map(|node| node.sent.iter().map(move |pdo| (node, pdo))).filter(|(_, pdo)| pdo.id == rpdo.id)
}

/// What a receive PDO has, and what its sender has instead.
fn mismatch(rpdo: &Pdo, tpdo: &Pdo) -> Option<[String; 2]> {
    if rpdo.bytes() > tpdo.bytes() {
        return Some([
            format!("{} bytes", rpdo.bytes()),
            format!("{}: the receiver rejects it", tpdo.bytes()),
        ]);
    }
    // A receiver without objects declares only the length. Its application decodes the payload.
    if rpdo.fields.iter().all(Field::is_skipped) {
        return None;
    }
    let pairs = || rpdo.fields.iter().zip(&tpdo.fields).enumerate();
    let text = |nth: usize, field: &Field, what: String| {
        let name = if field.is_skipped() { "skipped bits" } else { &field.name };
        format!("{name} with {what} at place {}", nth + 1)
    };
    let both = |nth: usize, mine: &Field, theirs: &Field, what: fn(&Field) -> String| {
        [text(nth, mine, what(mine)), text(nth, theirs, what(theirs))]
    };
    if let Some((nth, (mine, theirs))) = pairs().find(|(_, (mine, theirs))| mine.bits != theirs.bits) {
        return Some(both(nth, mine, theirs, |field| format!("{} bits", field.bits)));
    }
    let differ = |mine: &Field, theirs: &Field| matches!((kind(mine), kind(theirs)), (Some(mine), Some(theirs)) if mine != theirs);
    if let Some((nth, (mine, theirs))) = pairs().find(|(_, (mine, theirs))| differ(mine, theirs)) {
        return Some(both(nth, mine, theirs, |field| format!("type {:04X}h", field.data_type)));
    }
    let values = |pdo: &Pdo| pdo.fields.iter().take(rpdo.fields.len()).map(Field::value).collect::<Vec<_>>();
    let (mine, theirs) = (values(rpdo), values(tpdo));
    // Both names of the place stand in the other mapping, too, but not here.
    let is_swapped = |(nth, _): &(usize, (&Field, &Field))| {
        mine[*nth] != theirs[*nth] && theirs.contains(&mine[*nth]) && mine.contains(&theirs[*nth])
    };
    let (nth, (mine, theirs)) = pairs().find(is_swapped)?;
    Some([format!("{} at place {}", mine.name, nth + 1), format!("{} there", theirs.name)])
}

/// Kind of a number; `None` for others, which are not compared.
fn kind(field: &Field) -> Option<&'static str> {
    match field.data_type {
        0x02..=0x04 | 0x10 | 0x12..=0x15 => Some("signed"),
        0x05..=0x07 | 0x16 | 0x18..=0x1B => Some("unsigned"),
        0x08 | 0x11 => Some("real"),
        _ => None,
    }
}

/// Name and data type of each value of a dictionary, by index and sub-index.
type NamesOf = std::collections::BTreeMap<(u16, u8), (String, u32)>;

fn names<D: Objects>() -> Result<NamesOf, Error> {
    let mut declared = Vec::new();
    D::describe(&mut |object, names| declared.push((object, names)));
    let mut all = NamesOf::new();
    for (object, names) in declared {
        for instance in 0..object.count {
            let of_object = numbered(names.object, instance, object.count)?;
            for (entry, name) in object.entries.iter().zip(names.entries) {
                for nth in 0..entry.count {
                    let name = numbered(name, nth.into(), entry.count.into())?;
                    let name = if name == of_object { name } else { format!("{of_object}, {name}") };
                    all.insert((object.index + instance, entry.sub + nth), (name, entry.data_type as u32));
                }
            }
        }
    }
    Ok(all)
}

/// The valid PDOs of one direction, whose first communication record is `first`.
fn pdos<D: Objects>(objects: &mut D, first: u16, names: &NamesOf) -> Vec<Pdo> {
    let mut number = |index, sub| {
        let mut found = find(objects, Address::new(index, sub)).ok()?;
        let mut bytes = [0; 4];
        found.read(0, &mut bytes);
        Some(u32::from_le_bytes(bytes))
    };
    let mut pdos = Vec::new();
    for record in 0..RECORDS {
        let index = first + record;
        let Some(id) = number(index, 1).filter(|id| id & EXCLUDED == 0) else { continue };
        let count = number(index + TO_MAPPING, 0).unwrap_or(0) as u8;
        let entries = (1..=count.min(64)).filter_map(|sub| number(index + TO_MAPPING, sub));
        let fields: Vec<Field> = entries.map(|entry| field(entry, names)).collect();
        if !fields.is_empty() {
            pdos.push(Pdo { number: record + 1, id: (id & 0x7FF) as u16, fields });
        }
    }
    pdos
}

/// The object of an entry of a mapping.
fn field(entry: u32, names: &NamesOf) -> Field {
    let (index, sub, bits) = (entry >> 16, (entry >> 8) as u8, entry & 0xFF);
    if index < FIRST_OBJECT {
        return Field { name: String::new(), data_type: 0, bits };
    }
    let (name, data_type) = names.get(&(index as u16, sub)).cloned().unwrap_or_default();
    Field { name, data_type, bits }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(name: &str, data_type: u32, bits: u32) -> Field {
        Field { name: name.into(), data_type, bits }
    }

    /// What is said of a sender and a receiver of 285h with these fields.
    fn said(sent: &[Field], received: &[Field]) -> String {
        let pdo = |number, fields: &[Field]| Pdo { number, id: 0x285, fields: fields.to_vec() };
        let heater = Node { sent: vec![pdo(2, sent)], ..Node::new("node 5") };
        let master = Node { received: vec![pdo(7, received)], ..Node::new("master") };
        let said = mismatches(&[heater, master]);
        assert!(said.len() <= 1, "{said:?}");
        said.concat()
    }

    #[test]
    fn equal_mappings_and_shorter_receivers_match() {
        let sent = [field("Heater, Power", 5, 8), field("Heater, Temperature", 3, 16)];
        let mine = [field("Heater of node 5, Power", 5, 8), field("Heater of node 5, Temperature", 3, 16)];
        assert_eq!(said(&sent, &mine), "");
        assert_eq!(said(&sent, &mine[..1]), "");
        let skipped = [field("", 0, 8), mine[1].clone()];
        assert_eq!(said(&sent, &skipped), "");
        // Other names, and a bit pattern.
        assert_eq!(said(&sent, &[field("A", 5, 8), field("B", 0, 16)]), "");
        // Rows of values that are numbered in another way.
        let row = |from: u32| [from, from + 1].map(|nth| field(&format!("Level {nth}"), 5, 8));
        assert_eq!(said(&row(1), &row(2)), "");
    }

    #[test]
    fn swapped_fields_of_one_length_are_found_by_name() {
        let sent = [field("Heater, Power", 5, 8), field("Heater, State", 5, 8), field("Heater, Mode", 5, 8)];
        let mine = |order: [usize; 3]| {
            order.map(|nth| Field { name: sent[nth].name.replace("Heater", "Mine"), ..sent[nth].clone() })
        };
        let expected =
            "master: RPDO 7 (285h) has Mine, State at place 1, TPDO 2 of node 5 has Heater, Power there";
        assert_eq!(said(&sent, &mine([1, 0, 2])), expected);
        assert_eq!(said(&sent, &mine([1, 2, 0])), expected);
        let expected =
            "master: RPDO 7 (285h) has Mine, Mode at place 2, TPDO 2 of node 5 has Heater, State there";
        assert_eq!(said(&sent, &mine([0, 2, 1])), expected);
    }

    #[test]
    fn other_lengths_and_types_are_named_with_their_place() {
        let sent = [field("Power", 5, 8), field("Temperature", 3, 16)];
        let swapped = [sent[1].clone(), sent[0].clone()];
        let expected = "master: RPDO 7 (285h) has Temperature with 16 bits at place 1, TPDO 2 of node 5 has Power with 8 bits at place 1";
        assert_eq!(said(&sent, &swapped), expected);
        let unsigned = [sent[0].clone(), field("Temperature", 6, 16)];
        let expected = "master: RPDO 7 (285h) has Temperature with type 0006h at place 2, \
                        TPDO 2 of node 5 has Temperature with type 0003h at place 2";
        assert_eq!(said(&sent, &unsigned), expected);
        let longer = [&sent[..], &[field("State", 5, 8)]].concat();
        let expected = "master: RPDO 7 (285h) has 4 bytes, TPDO 2 of node 5 has 3: the receiver rejects it";
        assert_eq!(said(&sent, &longer), expected);
    }

    #[test]
    fn cob_id_without_sender_is_named() {
        let pdo = |id| Pdo { number: 1, id, fields: vec![field("Power", 5, 8)] };
        let heater = Node { sent: vec![pdo(0x285)], received: vec![pdo(0x285)], ..Node::new("node 5") };
        let master = Node { received: vec![pdo(0x286)], ..Node::new("master") };
        // Its own frames are not received by a node.
        let expected =
            ["node 5: RPDO 1 (285h) is sent by no node", "master: RPDO 1 (286h) is sent by no node"];
        assert_eq!(unsent(&[heater, master]), expected);
    }
}
