//! A copy of the project for defects.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, ensure};

/// Runs git in the project in `root`, and returns what it prints.
///
/// # Errors
/// When git cannot be run, or fails.
pub fn git(root: &Path, files: &[(&str, &Path)], arguments: &[&str]) -> anyhow::Result<String> {
    let mut git = Command::new("git");
    let output = git.args(arguments).current_dir(root).envs(files.iter().copied()).output();
    let output = output.context("cannot run git")?;
    ensure!(output.status.success(), "git {}: {}", arguments[0], String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).context("the output of git")
}

/// Makes `copy` equal to the project in `root` without what git ignores. Files that are equal already keep their time, so that cargo
/// compiles only what changed.
///
/// Git notes both states in indices of their own beside the copy: the index of the project stays as it is.
///
/// # Errors
/// As [`git`]; when there is no repository.
pub fn restore(root: &Path, copy: &Path) -> anyhow::Result<()> {
    let [original, index] = ["original", "index"].map(|name| copy.with_extension(name));
    let folder = git(root, &[], &["rev-parse", "--absolute-git-dir"])?;
    let of_root = [("GIT_INDEX_FILE", &*original)];
    git(root, &of_root, &["add", "--all"])?;
    let tree = git(root, &of_root, &["write-tree"])?;
    let of_copy =
        [("GIT_INDEX_FILE", &*index), ("GIT_WORK_TREE", copy), ("GIT_DIR", Path::new(folder.trim_end()))];
    git(copy, &of_copy, &["read-tree", "--reset", "-u", tree.trim_end()])?;
    git(copy, &of_copy, &["clean", "-ffdxq"]).map(drop)
}

/// Returns cargo in the copy `tree`, with a `target` folder of its own.
pub fn cargo(tree: &Path, target: &Path) -> Command {
    let mut cargo = Command::new("cargo");
    ecss_can_cli::images::clean(&mut cargo).current_dir(tree);
    // The profile decides: only what changed is compiled again.
    cargo.env("CARGO_TARGET_DIR", target).env_remove("CARGO_INCREMENTAL");
    cargo
}

#[cfg(test)]
mod tests {
    use std::fs;

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
        fs::create_dir(&copy).expect("a folder");
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
