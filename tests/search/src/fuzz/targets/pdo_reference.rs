//! Reference behaviour of PDOs, bit by bit, from declarations and values of the dictionary (CiA 301 7.4.8.2).

use std::sync::LazyLock;

use ecss_can::node::NodeObjects;
use ecss_can::od::{Access, Objects, checked};
use ecss_can::types::Address;

use super::device::Instrument;

pub type Dictionary = NodeObjects<Instrument>;

/// A value that a PDO may carry.
#[derive(Clone, Copy)]
pub struct Value {
    pub at: Address,
    pub bits: u8,
    receivable: bool,
    transmittable: bool,
}

/// All values that a PDO may carry.
pub static VALUES: LazyLock<Vec<Value>> = LazyLock::new(|| {
    addresses(&|entry| entry.is_mappable())
        .into_iter()
        .map(|(at, access, bits)| Value {
            at,
            bits: bits.expect("of a fixed size"),
            receivable: matches!(access, Access::Wo | Access::Rw | Access::Rww),
            transmittable: matches!(access, Access::Ro | Access::Rw | Access::Rwr | Access::Const),
        })
        .collect()
});

/// All objects above the communication profile except those that change by themselves.
static WATCHED: LazyLock<Vec<Address>> = LazyLock::new(|| {
    let all = addresses(&|_| true).into_iter().map(|(at, ..)| at);
    all.filter(|at| at.index >= 0x2000 && !matches!(at.index, 0x2011 | 0x2020 | 0x2021)).collect()
});

fn addresses(wanted: &dyn Fn(&ecss_can::od::Entry) -> bool) -> Vec<(Address, Access, Option<u8>)> {
    let mut found = vec![];
    Dictionary::each_object(&mut |object| {
        for instance in 0..object.count {
            for entry in object.entries.iter().filter(|entry| wanted(entry)) {
                for nth in 0..entry.count {
                    let at = Address::new(object.index + instance, entry.sub + nth);
                    found.push((at, entry.access, entry.data_type.bits()));
                }
            }
        }
    });
    found.sort_by_key(|(at, ..)| *at);
    found
}

/// Returns whether all watched objects are equal.
pub fn is_equal(one: &Dictionary, other: &Dictionary) -> bool {
    let spacecraft = (&one.extension, &other.extension);
    let is_same = one.application == other.application
        && spacecraft.0.redundancy == spacecraft.1.redundancy
        && spacecraft.0.time.scet_set == spacecraft.1.time.scet_set
        && spacecraft.0.self_test == spacecraft.1.self_test;
    // NaN does not equal itself, but its bytes do.
    is_same || snapshot(&mut one.clone()) == snapshot(&mut other.clone())
}

/// Returns all watched objects as SDO reads them.
fn snapshot(objects: &mut Dictionary) -> Vec<u8> {
    let mut all = vec![];
    for at in WATCHED.iter() {
        let mut bytes = [0; 64];
        let len = checked::find(objects, *at).map_or(0, |mut found| found.read(0, &mut bytes));
        all.extend(&bytes[..len]);
    }
    all
}

/// Returns the bits of a mapping entry.
const fn bits(entry: u32) -> usize {
    (entry & 0xFF) as usize
}

/// Returns the data bytes of a mapping.
pub fn bytes(mapping: &[u32]) -> u8 {
    mapping.iter().map(|entry| bits(*entry)).sum::<usize>().div_ceil(8) as u8
}

/// Returns the fewest data bytes of a received frame. The bytes of 6101h sub 2 (data of a telemetry request) at the end
/// are optional.
pub fn least_bytes(mapping: &[u32]) -> u8 {
    let is_left_out = |entry: &u32| entry >> 8 == 0x61_0102;
    let required = mapping.iter().rposition(|entry| !is_left_out(entry)).map_or(0, |last| last + 1);
    bytes(&mapping[..required])
}

fn address(entry: u32) -> Address {
    Address::new((entry >> 16) as u16, (entry >> 8) as u8)
}

/// Returns whether a PDO may have this mapping.
pub fn is_valid(mapping: &[u32], receives: bool) -> bool {
    let is_possible = |entry: &u32| match (entry >> 16, entry >> 8 & 0xFF) {
        // Dummies: BOOLEAN, INTEGER8 to UNSIGNED32.
        (1, 0) => receives && bits(*entry) == 1,
        (2 | 5, 0) => receives && bits(*entry) == 8,
        (3 | 6, 0) => receives && bits(*entry) == 16,
        (4 | 7, 0) => receives && bits(*entry) == 32,
        _ => VALUES.binary_search_by_key(&address(*entry), |value| value.at).is_ok_and(|found| {
            let value = VALUES[found];
            usize::from(value.bits) == bits(*entry)
                && if receives { value.receivable } else { value.transmittable }
        }),
    };
    let total: usize = mapping.iter().map(|entry| bits(*entry)).sum();
    (1..=8).contains(&mapping.len()) && total <= 64 && mapping.iter().all(is_possible)
}

/// Writes the values of a frame, each from its bits. A value outside its limits is not written.
pub fn unpack(mapping: &[u32], data: [u8; 8], objects: &mut Dictionary) {
    let mut at = 0;
    for entry in mapping {
        let mut value = vec![0; bits(*entry).div_ceil(8)];
        for bit in 0..bits(*entry) {
            let is_set = data[(at + bit) / 8] >> ((at + bit) % 8) & 1;
            value[bit / 8] |= is_set << (bit % 8);
        }
        if let Ok(mut found) = checked::find(objects, address(*entry)) {
            let _ = found.write(&value);
        }
        at += bits(*entry);
    }
}

/// Returns the data of a frame with the present values.
pub fn pack(mapping: &[u32], objects: &mut Dictionary) -> [u8; 8] {
    let (mut data, mut at) = ([0; 8], 0);
    for entry in mapping {
        let mut value = [0; 8];
        checked::find(objects, address(*entry)).expect("mapped").read(0, &mut value);
        for bit in 0..bits(*entry) {
            data[(at + bit) / 8] |= (value[bit / 8] >> (bit % 8) & 1) << ((at + bit) % 8);
        }
        at += bits(*entry);
    }
    data
}
