//! A random sample that hardly changes when the code does.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// A change of the code, as cargo-mutants names it: `shared/canopen/src/nmt/slave.rs:40:9: replace == with != in Slave::on_command`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Mutant<'a> {
    pub file: &'a str,
    pub line: usize,
    pub name: &'a str,
    change: &'a str,
}

impl<'a> Mutant<'a> {
    /// Reads a line of `cargo mutants --list`.
    pub fn read(name: &'a str) -> Option<Mutant<'a>> {
        let (place, change) = name.split_once(": ")?;
        let mut place = place.split(':');
        let (file, line) = (place.next()?, place.next()?.parse().ok()?);
        Some(Mutant { file, line, name, change })
    }
}

/// `count` of `all` at random, in random order. A larger sample begins with a smaller one of the same seed.
///
/// A mutant has its place by what it changes in which file, not by its line: a change of the code elsewhere draws no others.
pub fn draw<'a>(all: &[Mutant<'a>], count: usize, seed: u64) -> Vec<Mutant<'a>> {
    let mut same: HashMap<_, u64> = HashMap::new();
    let mut drawn: Vec<_> = all
        .iter()
        .map(|mutant| {
            let nth = same.entry((mutant.file, mutant.change)).or_default();
            let mut hasher = DefaultHasher::new();
            (seed, mutant.file, mutant.change, *nth).hash(&mut hasher);
            *nth += 1;
            (hasher.finish(), *mutant)
        })
        .collect();
    drawn.sort_unstable();
    drawn.into_iter().map(|(_, mutant)| mutant).take(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIST: [&str; 5] = [
        "shared/src/a.rs:1:1: replace < with <= in one",
        "shared/src/a.rs:7:1: replace < with <= in one",
        "shared/src/a.rs:9:5: replace one -> Option<u8> with None",
        "shared/src/b.rs:1:1: replace < with <= in one",
        "shared/src/b.rs:3:1: delete ! in two",
    ];

    fn read(names: &[&'static str]) -> Vec<Mutant<'static>> {
        names.iter().map(|name| Mutant::read(name).expect("a mutant")).collect()
    }

    #[test]
    fn a_line_of_the_list_has_file_and_line() {
        let mutant = Mutant::read(LIST[1]).expect("a mutant");
        assert_eq!((mutant.file, mutant.line), ("shared/src/a.rs", 7));
        assert_eq!(Mutant::read("Found 400 mutants to test"), None);
    }

    #[test]
    fn smaller_sample_begins_a_larger_one_and_seeds_change_order() {
        let all = read(&LIST);
        let orders: Vec<_> = (0..20).map(|seed| draw(&all, 5, seed)).collect();
        for (seed, order) in (0..).zip(&orders) {
            assert_eq!(draw(&all, 2, seed), order[..2]);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, all, "each once");
        }
        assert!(orders.iter().any(|order| *order != orders[0]));
        assert_eq!(draw(&all, 400, 1).len(), 5, "no more than there are");
    }

    #[test]
    fn the_sample_stays_when_lines_move() {
        let moved = read(&[
            "shared/src/a.rs:11:1: replace < with <= in one",
            "shared/src/a.rs:17:1: replace < with <= in one",
            "shared/src/a.rs:19:5: replace one -> Option<u8> with None",
            LIST[3],
            LIST[4],
        ]);
        let changes = |all: &[Mutant<'static>]| -> Vec<_> {
            draw(all, 3, 1).iter().map(|mutant| (mutant.file, mutant.change)).collect()
        };
        assert_eq!(changes(&moved), changes(&read(&LIST)));
    }
}
