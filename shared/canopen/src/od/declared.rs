//! Tree of the declarations of a dictionary. Constants read it, so that an error of a declaration stops the
//! build.

use super::reason::Reason;
use super::{Entry, Object};
use crate::types::Address;

/// Objects of a declaration and of its groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Declared {
    /// Objects of the declaration itself, in rising order.
    pub objects: &'static [Object],
    /// Groups of objects below it.
    pub groups: &'static [&'static Declared],
}

impl Declared {
    /// Objects, groups included; several in a row count as one.
    const fn count(&self) -> u16 {
        let (mut count, mut nth) = (self.objects.len() as u16, 0);
        while nth < self.groups.len() {
            (count, nth) = (count + self.groups[nth].count(), nth + 1);
        }
        count
    }

    /// Returns whether one of the values is a DOMAIN, which moves in parts.
    pub(crate) const fn has_domains(&self) -> bool {
        let mut nth = 0;
        while nth < self.objects.len() {
            let (entries, mut number) = (self.objects[nth].entries, 0);
            while number < entries.len() {
                if entries[number].size == 0 {
                    return true;
                }
                number += 1;
            }
            nth += 1;
        }
        let mut nth = 0;
        while nth < self.groups.len() {
            if self.groups[nth].has_domains() {
                return true;
            }
            nth += 1;
        }
        false
    }

    /// Finds the entry of a value. Returns the number of the object, the number of the instance for consecutive
    /// objects, and the entry, as [`Objects::find`](super::Objects::find) does.
    pub const fn find(&self, at: Address) -> Option<(u16, u16, &'static Entry)> {
        let mut nth = 0;
        while nth < self.objects.len() {
            let object = &self.objects[nth];
            if at.index >= object.index && (at.index as u32) < end(object) {
                return match entry(object.entries, at.sub) {
                    Some(entry) => Some((nth as u16, at.index - object.index, entry)),
                    None => None,
                };
            }
            nth += 1;
        }
        let (mut before, mut nth) = (self.objects.len() as u16, 0);
        while nth < self.groups.len() {
            if let Some((number, instance, entry)) = self.groups[nth].find(at) {
                return Some((before + number, instance, entry));
            }
            (before, nth) = (before + self.groups[nth].count(), nth + 1);
        }
        None
    }

    /// The object with this index, its number beyond `before`, and which it is of several in a row. One function
    /// for all dictionaries: what each has of its own is data.
    pub(super) fn object(&'static self, index: u16, before: &mut u16) -> Option<(&'static Object, u16, u16)> {
        for object in self.objects {
            let instance = index.wrapping_sub(object.index);
            if instance < object.count {
                return Some((object, *before, instance));
            }
            *before = before.wrapping_add(1);
        }
        self.groups.iter().find_map(|group| group.object(index, before))
    }

    /// The object that covers an index, else the first one behind it.
    pub(super) fn object_from(&'static self, index: u16, found: &mut Option<&'static Object>) {
        let own = self.objects.iter().find(|object| end(object) > u32::from(index));
        if let Some(object) = own
            && found.is_none_or(|first| object.index < first.index)
        {
            *found = own;
        }
        for group in self.groups {
            group.object_from(index, found);
        }
    }

    /// Every object, groups included.
    pub(super) fn each_object(&'static self, visit: &mut dyn FnMut(&'static Object)) {
        self.objects.iter().for_each(&mut *visit);
        self.groups.iter().for_each(|group| group.each_object(visit));
    }

    /// Stops the build if two objects have the same index, or if an index is above FFFFh.
    ///
    /// # Panics
    /// When called at run time, for the same reasons.
    #[track_caller]
    pub const fn assert_distinct(&self) {
        assert_rising(self.objects);
        let mut nth = 0;
        while nth < self.groups.len() {
            let group = self.groups[nth];
            group.assert_distinct();
            assert_apart_from_all(self.objects, group);
            let mut other = 0;
            while other < nth {
                group.assert_apart_from(self.groups[other]);
                other += 1;
            }
            nth += 1;
        }
    }

    #[track_caller]
    const fn assert_apart_from(&self, other: &Declared) {
        assert_apart_from_all(self.objects, other);
        let mut nth = 0;
        while nth < self.groups.len() {
            self.groups[nth].assert_apart_from(other);
            nth += 1;
        }
    }
}

const fn entry(entries: &'static [Entry], sub: u8) -> Option<&'static Entry> {
    let mut nth = 0;
    while nth < entries.len() {
        if sub >= entries[nth].sub && sub - entries[nth].sub < entries[nth].count {
            return Some(&entries[nth]);
        }
        nth += 1;
    }
    None
}

#[track_caller]
const fn assert_apart_from_all(objects: &[Object], other: &Declared) {
    assert_apart(objects, other.objects);
    let mut nth = 0;
    while nth < other.groups.len() {
        assert_apart_from_all(objects, other.groups[nth]);
        nth += 1;
    }
}

/// The index behind an object, or behind several in a row.
const fn end(object: &Object) -> u32 {
    object.index as u32 + object.count as u32
}

#[track_caller]
const fn assert_rising(objects: &[Object]) {
    let (mut nth, mut free) = (0, 0);
    while nth < objects.len() {
        let object = &objects[nth];
        if end(object) > 0x1_0000 {
            let first = Reason::new("objects in a row from ").hex(object.index, 4);
            first.text(" on: the last index is FFFFh").refuse();
        }
        if object.count > 0 {
            if free > object.index as u32 {
                refuse_twice(object.index);
            }
            free = end(object);
        }
        nth += 1;
    }
}

/// Both in rising order.
#[track_caller]
const fn assert_apart(one: &[Object], other: &[Object]) {
    let (mut nth, mut at) = (0, 0);
    while nth < one.len() && at < other.len() {
        let (object, against) = (&one[nth], &other[at]);
        // An array may have no elements.
        if object.count == 0 || end(object) <= against.index as u32 {
            nth += 1;
        } else if against.count == 0 || end(against) <= object.index as u32 {
            at += 1;
        } else {
            refuse_twice(if object.index > against.index { object.index } else { against.index });
        }
    }
}

#[track_caller]
const fn refuse_twice(index: u16) -> ! {
    Reason::new("index ").hex(index, 4).text(" is declared twice: an index belongs to one field").refuse()
}

/// Stops the build if two entries of a record have the same sub-index, or if one is above 254.
///
/// # Panics
/// When called at run time, for the same reasons.
#[track_caller]
pub const fn assert_entries(entries: &[Entry]) {
    let mut nth = 0;
    while nth < entries.len() {
        let entry = &entries[nth];
        if entry.sub as u16 + entry.count as u16 > 255 {
            let first = Reason::new("values in a row from sub-index ").number(entry.sub as u32);
            first.text(" on: the last sub-index is 254").refuse();
        }
        if nth > 0 && entries[nth - 1].sub + entries[nth - 1].count > entry.sub {
            let sub = Reason::new("sub-index ").number(entry.sub as u32);
            sub.text(" is declared twice: a sub-index belongs to one field").refuse();
        }
        nth += 1;
    }
}
