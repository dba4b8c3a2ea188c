//! Defects as patches: each must be found by the command that its head names.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, ensure};
use firmware_images::support::misuse::Misuse;
use firmware_images::support::{output, project};

use super::COMMAND;
use super::copy;
use super::patch::Patch;

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

/// Prints name and command of each patch.
///
/// # Errors
/// When stdout cannot be written.
pub fn print(patches: &[Patch]) -> anyhow::Result<()> {
    patches.iter().try_for_each(|patch| {
        let head = &patch.head;
        output::line(format_args!("{}: {}\n    cargo {}", head.rule, head.defect, head.command.join(" ")))
    })
}

/// Applies each patch alone to a copy of the project in `folder/tree`, and runs its command there.
///
/// # Errors
/// When a command does not find its defect, or a file cannot be written.
pub fn run(patches: &[Patch], folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder.join("tree")).with_context(|| format!("cannot make {}", folder.display()))?;
    let folder = folder.canonicalize().with_context(|| folder.display().to_string())?;
    let (root, tree) = (project::path(""), folder.join("tree"));
    let mut missed = 0;
    for patch in patches {
        copy::restore(&root, &tree)?;
        let start = Instant::now();
        if let Err(error) = patch.apply(&tree, &[])? {
            anyhow::bail!("{}: does not apply to the copy: {error}", patch.file.display());
        }
        let outcome = is_found(patch, &tree, &folder.join("target"))?;
        let seconds = start.elapsed().as_secs();
        match outcome {
            Ok(()) => output::line(format_args!("found: {}, {seconds} s", patch.head.rule))?,
            Err(reason) => {
                missed += 1;
                output::line(format_args!("not found: {}, {seconds} s: {reason}", patch.head.rule))?;
            }
        }
    }
    // The next run compiles from here.
    copy::restore(&root, &tree)?;
    ensure!(missed == 0, "{missed} of {} defects were not found", patches.len());
    Ok(())
}

/// Runs the command of a patch in the patched `tree`. Returns the reason if it has not found the defect.
fn is_found(patch: &Patch, tree: &Path, target: &Path) -> anyhow::Result<Result<(), String>> {
    let mut cargo = Command::new("cargo");
    firmware_images::clean(&mut cargo).args(&patch.head.command).current_dir(tree);
    // The profile decides: only what changed is compiled again.
    cargo.env("CARGO_TARGET_DIR", target).env_remove("CARGO_INCREMENTAL");
    let ended = cargo.output().context("cannot run cargo")?;
    let [out, err] = [&ended.stdout, &ended.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    if ended.status.success() {
        return Ok(Err("the command succeeded".to_owned()));
    }
    if out.contains(&patch.head.finds) || err.contains(&patch.head.finds) {
        return Ok(Ok(()));
    }
    let lines: Vec<&str> = err.lines().chain(out.lines()).collect();
    output::note(lines[lines.len().saturating_sub(SHOWN)..].join("\n"));
    Ok(Err(format!("the command failed without {:?}", patch.head.finds)))
}
