//! What became of the mutants, as cargo-mutants wrote it down.

use std::fs;
use std::path::Path;

use anyhow::Context;

use super::sample::Mutant;

/// Those of a sample.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Outcome<'a> {
    pub caught: Vec<Mutant<'a>>,
    pub missed: Vec<Mutant<'a>>,
    /// A test did not end, which is a failure, too.
    pub timeout: Vec<Mutant<'a>>,
    /// Do not compile: a check at compile time found them, or the change made no sense.
    pub unviable: Vec<Mutant<'a>>,
}

impl<'a> Outcome<'a> {
    /// Reads the lists in `folder/mutants.out`. Others than those of the `sample` do not count.
    pub fn read(folder: &Path, sample: &[Mutant<'a>]) -> anyhow::Result<Outcome<'a>> {
        let list = |name: &str| {
            let path = folder.join("mutants.out").join(name);
            let text =
                fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
            let is_there = |mutant: &&Mutant<'_>| text.lines().any(|line| line == mutant.name);
            anyhow::Ok(sample.iter().filter(is_there).copied().collect())
        };
        Ok(Outcome {
            caught: list("caught.txt")?,
            missed: list("missed.txt")?,
            timeout: list("timeout.txt")?,
            unviable: list("unviable.txt")?,
        })
    }

    /// Takes what more tests found of those that were missed.
    pub fn after(self, more: Outcome<'a>) -> Outcome<'a> {
        let Outcome { mut caught, mut timeout, mut unviable, .. } = self;
        caught.extend(more.caught);
        timeout.extend(more.timeout);
        unviable.extend(more.unviable);
        Outcome { caught, missed: more.missed, timeout, unviable }
    }

    /// Those that a test found, and those that it could have found.
    pub fn share(&self) -> (usize, usize) {
        let found = self.caught.len() + self.timeout.len();
        (found, found + self.missed.len())
    }

    pub fn tried(&self) -> usize {
        self.share().1 + self.unviable.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_more_tests_find_is_found() {
        let [one, two, three, four] =
            ["one", "two", "three", "four"].map(|change| format!("a.rs:1:1: {change}"));
        let [one, two, three, four] =
            [&one, &two, &three, &four].map(|name| Mutant::read(name).expect("a mutant"));
        let folder = tempfile::tempdir().expect("a temporary directory");
        let write = |folder: &Path, lists: [&[Mutant<'_>]; 4]| {
            let folder = folder.join("mutants.out");
            fs::create_dir_all(&folder).expect("a folder");
            for (name, list) in ["caught.txt", "missed.txt", "timeout.txt", "unviable.txt"].iter().zip(lists)
            {
                let text: String = list.iter().map(|mutant| format!("{}\n", mutant.name)).collect();
                fs::write(folder.join(name), text).expect("a file");
            }
        };
        let (first, more) = (folder.path().join("first"), folder.path().join("more"));
        write(&first, [&[one], &[two, three], &[], &[four]]);
        write(&more, [&[two], &[], &[three], &[]]);
        let sample = [one, two, three];
        let first = Outcome::read(&first, &sample).expect("lists");
        assert_eq!((first.share(), first.tried()), ((1, 3), 3), "four is not of the sample");
        let both = first.after(Outcome::read(&more, &[two, three]).expect("lists"));
        assert_eq!((both.share(), both.tried()), ((3, 3), 3));
        assert_eq!(both.timeout, [three]);
    }
}
