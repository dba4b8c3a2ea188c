//! What a data sheet has no keyword for, as comments: the capacity of strings, the names of an enumeration, what "save" does not keep.

use ecss_can::od::{DataType, NamedValue};

use crate::dictionary::{Described, Dictionary, Value};
use crate::file::LINE;
use crate::value::Default;

/// Store parameters.
const STORE: u16 = 0x1010;
/// What is written to these is a command to the device: history, "save", "load".
const COMMANDS: [u16; 3] = [0x1003, STORE, 0x1011];

/// Lines about the objects of a dictionary.
pub fn of(dictionary: &Dictionary) -> Vec<String> {
    let mut lines = capacities(dictionary);
    lines.extend(enumerations(dictionary));
    if dictionary.get(&STORE).is_some_and(saves) {
        lines.extend(not_kept(dictionary));
    }
    lines
}

/// How many bytes each string takes that a client writes.
fn capacities(dictionary: &Dictionary) -> Vec<String> {
    use DataType::{OctetString, UnicodeString, VisibleString};
    let is_string =
        |value: &&Value| matches!(value.entry.data_type, VisibleString | OctetString | UnicodeString);
    let strings = dictionary.iter().flat_map(|(&index, object)| {
        writable(object).filter(is_string).map(move |value| (section(index, object, value), value.entry.size))
    });
    strings.map(|(section, size)| format!("{section} takes at most {size} bytes")).collect()
}

/// The values of each enumeration with their names: `6002: 0 Off, 1 Auto`. Consecutive sub-indices of one kind share their lines.
fn enumerations(dictionary: &Dictionary) -> Vec<String> {
    let mut lines = Vec::new();
    for (&index, object) in dictionary {
        for alike in object.values.chunk_by(|one, next| std::ptr::eq(one.entry, next.entry)) {
            if let [first, others @ ..] = alike {
                let first_section = section(index, object, first);
                let sections = match others.last() {
                    Some(last) => format!("{first_section} to {}:", section(index, object, last)),
                    None => format!("{first_section}:"),
                };
                lines.extend(named(&sections, first.named));
            }
        }
    }
    lines
}

/// Lines with these names, each with `start`.
fn named(start: &str, values: &[NamedValue]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for NamedValue { number, name } in values {
        let text = format!(" {number} {name}");
        match lines.last_mut().filter(|line| line.len() + 1 + text.len() <= LINE) {
            Some(line) => *line += &format!(",{text}"),
            None => lines.push(format!("{start}{text}")),
        }
    }
    lines
}

/// Whether the device saves anything: bit 0 of 1010h, "on command".
fn saves(store: &Described) -> bool {
    let first = store.values.iter().find(|value| value.sub == 1);
    first.is_some_and(|value| matches!(&value.default, Default::Same(bits) if bits.first().is_some_and(|bits| bits & 1 != 0)))
}

/// What a client can write and "save" does not keep.
fn not_kept(dictionary: &Dictionary) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for (&index, object) in dictionary.iter().filter(|(index, _)| !COMMANDS.contains(index)) {
        let is_lost = |value: &&Value| !value.entry.is_kept();
        let lost: Vec<&Value> = writable(object).filter(is_lost).collect();
        let sections: Vec<String> = match lost.len() {
            0 => continue,
            all if all == writable(object).count() => vec![format!("{index:04X}")],
            _ => lost.into_iter().map(|value| section(index, object, value)).collect(),
        };
        for section in sections {
            match lines.last_mut().filter(|line| line.len() + 1 + section.len() <= LINE) {
                Some(line) => *line += &format!(" {section}"),
                None => lines.push(format!("Not kept by 1010h: {section}")),
            }
        }
    }
    lines
}

fn writable(object: &Described) -> impl Iterator<Item = &Value> {
    object.values.iter().filter(|value| value.entry.access.is_writable())
}

/// The section of the file that a value has.
fn section(index: u16, object: &Described, value: &Value) -> String {
    if object.values.len() == 1 { format!("{index:04X}") } else { format!("{index:04X}sub{:X}", value.sub) }
}
