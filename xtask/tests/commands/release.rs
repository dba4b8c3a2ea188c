//! `cargo xtask release` without its long checks, with a cargo-cyclonedx that only writes the file.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;

use crate::XTASK;

/// Writes its folder and its date to the file that is asked for. A request for its version succeeds.
const CYCLONEDX: &str = "#!/bin/sh
[ \"$2\" = --version ] && exit 0
while [ $# -gt 0 ]; do
    [ \"$1\" = --override-filename ] && echo \"$PWD $SOURCE_DATE_EPOCH\" > \"$2.json\"
    shift
done
";

#[test]
fn release_without_check_and_folder_is_a_wrong_command_line() {
    let output = XTASK.command(&["release"]).output().expect("xtask starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("--check") && stderr.contains("--out <DIR>"), "{stderr}");
}

/// Given a folder, then it gets the notes of the version in the manifests and a file for each image, with folders of the repository and
/// the date of the commit; the repository gets none.
#[test]
fn release_writes_notes_and_a_file_for_each_image() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let (bin, out) = (here.path().join("bin"), here.path().join("out"));
    fs::create_dir(&bin).expect("a folder");
    fs::write(bin.join("cargo-cyclonedx"), CYCLONEDX).expect("a file");
    fs::set_permissions(bin.join("cargo-cyclonedx"), fs::Permissions::from_mode(0o755)).expect("executable");
    let others = std::env::var_os("PATH").expect("PATH");
    let path =
        std::env::join_paths([bin].into_iter().chain(std::env::split_paths(&others))).expect("folders");
    let mut release = XTASK.command(&["release", "--out", out.to_str().expect("UTF-8")]);
    let output = release.env("PATH", path).output().expect("xtask starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let notes = fs::read_to_string(out.join("release-notes.md")).expect("notes");
    assert!(notes.starts_with(concat!("# ecss-can ", env!("CARGO_PKG_VERSION"), "\n\n")), "{notes}");
    assert!(!notes.contains("\n## ["), "{notes}");
    for image in ["master", "slave", "minimal"] {
        let file = format!("{image}.cdx.json");
        let text = fs::read_to_string(out.join(&file)).expect(image);
        let (folder, date) = text.split_once(' ').expect("folder and date");
        assert_eq!(folder, format!("/firmware/{image}"));
        assert!(date.trim().parse::<u64>().expect("seconds") > 1_700_000_000, "{text}");
        assert!(!crate::docs::root().join("firmware").join(image).join(file).exists());
    }
}
