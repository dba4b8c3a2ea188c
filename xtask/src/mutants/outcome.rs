//! What became of the mutants, as cargo-mutants wrote it down.

use std::fs;
use std::path::Path;

use anyhow::Context;

use super::sample::Mutant;

/// What became of the mutants of a sample, by their names.
#[derive(Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Found by the tests that ran.
    pub caught: Vec<String>,
    /// Found by no test.
    pub missed: Vec<String>,
    /// A test did not end, which is a failure, too.
    pub timeout: Vec<String>,
    /// Do not compile: a check at compile time found them, or the change made no sense.
    pub unviable: Vec<String>,
    /// Number of those found, in either way, by the tests by clause.
    pub by_first: usize,
}

impl Outcome {
    /// Reads the lists that the tests by clause left in `folder/mutants.out`. Others than those of the `sample` do not count.
    ///
    /// # Errors
    /// When a list cannot be read.
    pub fn read(folder: &Path, sample: &[Mutant<'_>]) -> anyhow::Result<Outcome> {
        let list = |name: &str| {
            let path = folder.join("mutants.out").join(name);
            let text =
                fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
            let names = sample.iter().map(|mutant| mutant.name);
            let listed = names.filter(|name| text.lines().any(|line| line == *name));
            anyhow::Ok(listed.map(str::to_owned).collect())
        };
        let (caught, timeout): (Vec<_>, Vec<_>) = (list("caught.txt")?, list("timeout.txt")?);
        let by_first = caught.len() + timeout.len();
        let (missed, unviable) = (list("missed.txt")?, list("unviable.txt")?);
        Ok(Outcome { caught, missed, timeout, unviable, by_first })
    }

    /// Adds what more tests found of the missed ones.
    pub fn after(mut self, more: Outcome) -> Outcome {
        self.caught.extend(more.caught);
        self.timeout.extend(more.timeout);
        self.unviable.extend(more.unviable);
        Outcome { missed: more.missed, ..self }
    }

    /// Number of those that a test found, and of those that it could have found.
    pub fn share(&self) -> (usize, usize) {
        let found = self.caught.len() + self.timeout.len();
        (found, found + self.missed.len())
    }

    /// Number of those that were tried.
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
        assert_eq!((both.share(), both.tried(), both.by_first), ((3, 3), 3, 1));
        assert_eq!(both.timeout, [three.name]);
    }
}
