//! The same sources, `Cargo.lock` and toolchain give the same image in another folder.
//!
//! The copy of the sources has a target directory of its own. Packages of the registry are not compiled again there: hard links
//! lead to those that the image of the repository was built with.

use std::fs;
use std::path::Path;
use std::process::Command;

use can_twin::image::Image;
use cargo_metadata::MetadataCommand;
use ecss_can_cli::images::{self, support::board::Board};
use second::program::executable;
use second::tools::workspace;

/// Where images are built, below a target directory.
const BUILD: &str = "firmware/build";

/// Copies what git lists to another folder. Symbolic links stay links.
fn copy_sources(to: &Path) {
    let listed = Command::new("git")
        .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
        .current_dir(workspace())
        .output()
        .expect("git runs");
    let listed = String::from_utf8(listed.stdout).expect("names of files");
    for file in listed.split_terminator('\0').filter(|file| workspace().join(file).exists()) {
        let (from, to) = (workspace().join(file), to.join(file));
        fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        match fs::read_link(&from) {
            Ok(target) => std::os::unix::fs::symlink(target, to).expect("a link"),
            Err(_) => drop(fs::copy(from, to).expect("a copy")),
        }
    }
}

/// Links the files below `from` to `to`, without those whose name, or whose folder's, begins with one of `without`.
fn link(from: &Path, to: &Path, without: &[String]) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").map(|entry| entry.expect("an entry")) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let plain = name.strip_prefix("lib").unwrap_or(&name).replace('_', "-");
        if without.iter().any(|package| plain.starts_with(package)) {
            continue;
        }
        let (from, to) = (entry.path(), to.join(&name));
        if from.is_dir() {
            link(&from, &to, without);
        } else {
            fs::hard_link(from, to).expect("a link");
        }
    }
}

#[test]
fn image_built_in_another_folder_has_the_same_segments() {
    let ours = images::build(Board::DEFAULT, "standard").expect("an image").slave;
    // On the file system of the target directory, because hard links do not leave it.
    let target = images::target();
    let home = tempfile::Builder::new().prefix("sources of another user, ä").tempdir_in(&target);
    let home = home.expect("a folder");
    let copy = home.path();
    copy_sources(copy);
    let packages =
        MetadataCommand::new().current_dir(workspace()).no_deps().exec().expect("packages").packages;
    let mut names: Vec<String> = packages.iter().map(|package| package.name.to_string()).collect();
    // Locks of cargo are not shared.
    names.push(".cargo".to_owned());
    link(&target.join(BUILD), &copy.join("target").join(BUILD), &names);

    let mut build = Command::new(executable().expect("a program"));
    images::clean(&mut build).env("ECSS_CAN_SOURCES", "shipped").current_dir(copy.join("firmware/slave"));
    build.args(["build", "--package", "slave", "--board", Board::DEFAULT]);
    let output = build.output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let theirs = copy.join("target/firmware").join(Board::DEFAULT).join("slave");

    let [ours, theirs] = [&*ours, &*theirs].map(|file| fs::read(file).expect("an image"));
    assert_ne!(ours, theirs, "debug information has the folder");
    let segments = |elf: &[u8]| Image::parse(elf).expect("an image").flash().to_vec();
    assert!(segments(&ours) == segments(&theirs), "the loadable segments differ");
}
