//! Defects as patches: each must be found by the command or the tests that its head names.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, ensure};
use ecss_can_cli::images::support::misuse::Misuse;
use ecss_can_cli::images::support::{output, project};

use super::COMMAND;
use super::copy;
use super::patch::{Finder, Patch};
use super::tagged::{self, Ending, Run};
use crate::compliance::{self, Summary, Tag};

/// Last lines of a command that are shown when it has not found its defect.
const SHOWN: usize = 20;

/// Reads these patches, or without one all patches of the project, and tries to apply each.
///
/// # Errors
/// [`Misuse`] that names the first patch whose head is wrong or that does not apply.
pub fn read(files: &[PathBuf]) -> anyhow::Result<Vec<Patch>> {
    let root = project::path("").canonicalize().context("the folder of the project")?;
    let list = ["ls-files", "-z", "--cached", "--others", "--exclude-standard", "*.patch"];
    let files = if files.is_empty() {
        let known = copy::git(&root, &[], &list)?;
        let known = known.split_terminator('\0').map(|file| root.join(file));
        // A file that was deleted is known until the deletion is committed.
        known.filter(|file| file.is_file()).collect()
    } else {
        files.to_vec()
    };
    let refuse = |text: String| Misuse::of(COMMAND, format!("--patch {text}"));
    let read = |file: &PathBuf| {
        let patch = Patch::read(file).map_err(refuse)?;
        let outcome = patch.apply(&root, &["--check"])?;
        outcome.map_err(|error| refuse(format!("{}: does not apply: {error}", file.display())))?;
        Ok(patch)
    };
    files.iter().map(read).collect()
}

/// What the tests by tag need to know.
pub struct Tests {
    tags: Vec<Tag>,
    summaries: Vec<Summary>,
}

impl Tests {
    /// Reads the tags of the project, if one of these patches needs them.
    ///
    /// # Errors
    /// When a source cannot be read; [`Misuse`] that names a patch of an unknown requirement.
    pub fn of(patches: &[Patch]) -> anyhow::Result<Tests> {
        let mut named = Vec::new();
        for patch in patches {
            if let Finder::Tests { requirement } = &patch.head.finder {
                named.push((patch, requirement));
            }
        }
        let known = compliance::of_software();
        if let Some((patch, id)) = named.iter().find(|(_, id)| !known.contains(id)) {
            let file = patch.file.display();
            return Err(
                Misuse::of(COMMAND, format!("--patch {file}: no requirement on software is {id}")).into()
            );
        }
        let tags = if named.is_empty() { Vec::new() } else { compliance::tags()? };
        Ok(Tests { tags, summaries: compliance::summaries() })
    }

    fn runs(&self, requirement: &str, patch: &Patch) -> Vec<Run<'_>> {
        tagged::runs(requirement, &self.tags, &self.summaries, &patch.changed)
    }
}

/// Prints name, defect and commands of each patch.
///
/// # Errors
/// When stdout cannot be written.
pub fn print(patches: &[Patch], tests: &Tests) -> anyhow::Result<()> {
    for patch in patches {
        let head = &patch.head;
        output::line(format_args!("{}: {}", head.name(), head.defect))?;
        match &head.finder {
            Finder::Tests { requirement } => {
                let runs = tests.runs(requirement, patch);
                runs.iter().try_for_each(|run| output::line(format_args!("    cargo test {run}")))?;
            }
            Finder::Command { arguments, .. } => {
                output::line(format_args!("    cargo {}", arguments.join(" ")))?;
            }
        }
    }
    Ok(())
}

/// Applies each patch alone to a copy of the project in `folder/tree`, and runs its commands there.
///
/// # Errors
/// When a defect is not found, a test by tag does not exist, or a file cannot be written.
pub fn run(patches: &[Patch], tests: &Tests, folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder.join("tree")).with_context(|| format!("cannot make {}", folder.display()))?;
    let folder = folder.canonicalize().with_context(|| folder.display().to_string())?;
    let (root, tree, target) = (project::path(""), folder.join("tree"), folder.join("target"));
    let (mut found, begin) = (0, Instant::now());
    for patch in patches {
        copy::restore(&root, &tree)?;
        let start = Instant::now();
        if let Err(error) = patch.apply(&tree, &[])? {
            anyhow::bail!("{}: does not apply to the copy: {error}", patch.file.display());
        }
        let name = patch.head.name();
        let outcome = match &patch.head.finder {
            Finder::Tests { requirement } => by_tests(&tests.runs(requirement, patch), &tree, &target),
            Finder::Command { arguments, finds, .. } => by_command(arguments, finds, &tree, &target),
        };
        let outcome = outcome.with_context(|| patch.file.display().to_string())?;
        let seconds = start.elapsed().as_secs();
        match outcome {
            Ok(finder) => {
                found += 1;
                output::line(format_args!("found: {name}, {seconds} s{finder}"))?;
            }
            Err(reason) => output::line(format_args!("not found: {name}, {seconds} s: {reason}"))?,
        }
    }
    // The next run compiles from here.
    copy::restore(&root, &tree)?;
    output::line(format_args!("{found} of {} found, {} s", patches.len(), begin.elapsed().as_secs()))?;
    let missed = patches.len() - found;
    ensure!(missed == 0, "{missed} of {} defects were not found", patches.len());
    Ok(())
}

/// How a defect was found, or the reason why it was not.
type Outcome = anyhow::Result<Result<String, String>>;

/// Runs tests in the patched `tree`, until those of a target find the defect.
fn by_tests(runs: &[Run<'_>], tree: &Path, target: &Path) -> Outcome {
    for run in runs {
        match run.attempt(tree, target)? {
            Ending::Failed(test) => return Ok(Ok(format!(", {test}"))),
            Ending::Useless(reason) => return Ok(Err(format!("{reason}: {}", run.target()))),
            Ending::Passed => {}
        }
    }
    Ok(Err("all tests with its tag passed".to_owned()))
}

/// Runs a command in the patched `tree`, which must fail with the text `finds`.
fn by_command(arguments: &[String], finds: &str, tree: &Path, target: &Path) -> Outcome {
    let ended = copy::cargo(tree, target).args(arguments).output().context("cannot run cargo")?;
    let [out, err] = [&ended.stdout, &ended.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    if ended.status.success() {
        return Ok(Err("the command succeeded".to_owned()));
    }
    if out.contains(finds) || err.contains(finds) {
        return Ok(Ok(String::new()));
    }
    let lines: Vec<&str> = err.lines().chain(out.lines()).collect();
    output::note(lines[lines.len().saturating_sub(SHOWN)..].join("\n"));
    Ok(Err(format!("the command failed without {finds:?}")))
}
