//! A dictionary, looked at from outside: every object with its names and its values after power-on.

use std::collections::BTreeMap;

use ecss_can::od::checked::find;
use ecss_can::od::{DataType, Entry, NamedValue, Names, Object, ObjectCode, Objects};
use ecss_can::types::{Address, NodeId};

use crate::Error;
use crate::file::checked;
use crate::value::Default;

/// Objects by their index.
pub type Dictionary = BTreeMap<u16, Described>;

/// An object.
#[derive(Clone, Debug)]
pub struct Described {
    pub name: String,
    pub code: ObjectCode,
    pub values: Vec<Value>,
}

/// A value of an object.
#[derive(Clone, Debug)]
pub struct Value {
    pub sub: u8,
    pub name: String,
    pub entry: &'static Entry,
    pub default: Default,
    /// Values with a name: those of an enumeration.
    pub named: &'static [NamedValue],
}

impl Value {
    /// Least and greatest number that a client may write: those of the declaration, else those of an enumeration.
    pub fn limits(&self) -> (Option<i64>, Option<i64>) {
        let (low, high) = self.entry.limits.map_or((None, None), |limits| (limits.low(), limits.high()));
        let numbers = || self.named.iter().map(|value| value.number);
        (low.or_else(|| numbers().min()), high.or_else(|| numbers().max()))
    }
}

/// Looks at the dictionaries of nodes.
pub fn describe<D: Objects>(nodes: &mut [(NodeId, D)]) -> Result<Dictionary, Error> {
    let mut declared: Vec<(&'static Object, &'static Names)> = Vec::new();
    D::describe(&mut |object, names| declared.push((object, names)));
    let mut dictionary = Dictionary::new();
    for (object, names) in declared {
        for instance in 0..object.count {
            let index = object.index + instance;
            let described = Described {
                name: numbered(names.object, instance, object.count)?,
                code: names.code,
                values: values(nodes, index, object, names)?,
            };
            if dictionary.insert(index, described).is_some() {
                return Err(Error::Twice { index });
            }
        }
    }
    Ok(dictionary)
}

fn values<D: Objects>(
    nodes: &mut [(NodeId, D)],
    index: u16,
    object: &'static Object,
    names: &'static Names,
) -> Result<Vec<Value>, Error> {
    let mut values = Vec::new();
    let named = names.values.iter().copied().chain(std::iter::repeat(&[][..]));
    for ((entry, name), named) in object.entries.iter().zip(names.entries).zip(named) {
        named.iter().try_for_each(|value| checked(value.name))?;
        for nth in 0..entry.count {
            let sub = entry.sub + nth;
            let default = if has_text(index, sub, entry) {
                let value = |(node, objects): &mut (NodeId, D)| Ok((*node, read(objects, index, sub)?));
                let values: Result<Vec<_>, Error> = nodes.iter_mut().map(value).collect();
                Default::of(entry.data_type, &values?)
            } else {
                Default::None
            };
            let name = numbered(name, nth.into(), entry.count.into())?;
            values.push(Value { sub, name, entry, default, named });
        }
    }
    Ok(values)
}

/// Whether a value stands in a file: a client can read it after power-on, and readers agree on how it is written. They do
/// for neither a block of bytes nor a time: `0x000100000002` for some, `1 2` for others.
pub fn has_text(index: u16, sub: u8, entry: &Entry) -> bool {
    use DataType::{Domain, TimeDifference, TimeOfDay};
    // Errors of the past: the node has none, and refuses to read them (08000024h).
    let is_error = index == 0x1003 && sub > 0;
    let is_agreed = !matches!(entry.data_type, Domain | TimeOfDay | TimeDifference);
    entry.access.is_readable() && is_agreed && !is_error
}

/// The bytes of a value.
pub fn read<D: Objects>(objects: &mut D, index: u16, sub: u8) -> Result<Vec<u8>, Error> {
    let missing = |code| Error::Missing { index, sub, code };
    let mut found = find(objects, Address::new(index, sub)).map_err(missing)?;
    let mut bytes = vec![0; usize::from(found.entry.size)];
    let len = found.read(0, &mut bytes);
    bytes.truncate(len);
    Ok(bytes)
}

/// A name; of several in a row with its number, where `{}` stands or at the end.
pub fn numbered(name: &str, nth: u16, count: u16) -> Result<String, Error> {
    let number = (nth + 1).to_string();
    let name = match (count, name.contains("{}")) {
        (1, _) => name.into(),
        (_, true) => name.replace("{}", &number),
        (_, false) => format!("{name} {number}"),
    };
    checked(&name).map(|()| name)
}
