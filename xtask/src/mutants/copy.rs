//! A copy of the project for defects.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};

/// Files of the project in `root` that git knows or would add, relative to it.
///
/// # Errors
/// When git cannot be run, or there is no repository.
pub fn files(root: &Path) -> anyhow::Result<BTreeSet<PathBuf>> {
    let list = ["ls-files", "-z", "--cached", "--others", "--exclude-standard"];
    let output = Command::new("git").args(list).current_dir(root).output().context("cannot run git")?;
    ensure!(output.status.success(), "git ls-files failed: {}", String::from_utf8_lossy(&output.stderr));
    let names = String::from_utf8(output.stdout).context("the names of the files")?;
    // A file that was deleted is known until the deletion is committed.
    let files = names.split_terminator('\0').map(PathBuf::from).filter(|file| root.join(file).is_file());
    Ok(files.collect())
}

/// Makes `copy` equal to the project in `root`. Files that are equal already keep their time, so that cargo compiles only what changed.
///
/// # Errors
/// As [`files`], and when a file cannot be read or written.
pub fn restore(root: &Path, copy: &Path) -> anyhow::Result<()> {
    let files = files(root)?;
    for file in &files {
        let (from, to) = (root.join(file), copy.join(file));
        let original = fs::read(&from).with_context(|| format!("cannot read {}", from.display()))?;
        if fs::read(&to).is_ok_and(|present| present == original) {
            continue;
        }
        let folder = to.parent().context("a folder")?;
        fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        fs::copy(&from, &to).with_context(|| format!("cannot write {}", to.display()))?;
    }
    remove_others(copy, Path::new(""), &files)
}

/// Removes the files of `copy` below `folder` that are not in `files`.
fn remove_others(copy: &Path, folder: &Path, files: &BTreeSet<PathBuf>) -> anyhow::Result<()> {
    let here = copy.join(folder);
    for entry in fs::read_dir(&here).with_context(|| format!("cannot read {}", here.display()))? {
        let entry = entry?;
        let path = folder.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            remove_others(copy, &path, files)?;
        } else if !files.contains(&path) {
            fs::remove_file(entry.path())
                .with_context(|| format!("cannot remove {}", entry.path().display()))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given a copy in which files were changed, added and removed, it becomes equal to the project without what git ignores.
    #[test]
    fn changed_copy_becomes_equal_to_the_project() {
        let folder = tempfile::tempdir().expect("a temporary directory");
        let (root, copy) = (folder.path().join("root"), folder.path().join("copy"));
        let write = |file: &Path, text: &str| {
            fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
            fs::write(file, text).expect("a file");
        };
        for (file, text) in [("a", "one"), ("b/c", "two"), ("b/d", "three"), ("out/e", "four")] {
            write(&root.join(file), text);
        }
        write(&root.join(".gitignore"), "/out\n");
        let init = Command::new("git").args(["init", "--quiet"]).current_dir(&root).status();
        assert!(init.expect("git runs").success());
        restore(&root, &copy).expect("a copy");
        write(&copy.join("a"), "changed");
        write(&copy.join("b/more"), "added");
        fs::remove_file(copy.join("b/c")).expect("it was copied");
        let equal = copy.join("b/d");
        let time = fs::metadata(&equal).and_then(|data| data.modified()).expect("a time");
        restore(&root, &copy).expect("a copy");
        let read = |file: &str| fs::read_to_string(copy.join(file)).ok();
        assert_eq!(["a", "b/c", "b/d"].map(read), ["one", "two", "three"].map(|text| Some(text.to_owned())));
        assert_eq!(["b/more", "out/e"].map(read), [None, None]);
        assert_eq!(fs::metadata(&equal).and_then(|data| data.modified()).ok(), Some(time));
    }
}
