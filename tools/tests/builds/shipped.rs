//! Images from the sources that the program contains, as an installed program builds them.
#![cfg(unix)]

use std::fmt::Write;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use ecss_can_cli::images::{LOG, build_image, target};
use object::{Object, ObjectSegment};

use crate::scratch::root;

/// Crates of this repository that an image depends on, and their folders. Here they take the place of the registry.
const CRATES: [(&str, &str); 11] = [
    ("async-canopen", "shared/canopen"),
    ("async-canopen-derive", "shared/derive"),
    ("async-canopen-eds", "shared/data-sheet"),
    ("ecss-can", "shared"),
    ("ecss-can-memory", "boards/memory"),
    ("ecss-can-mission", "firmware/mission"),
    ("ecss-can-nucleo-f446re", "boards/nucleo-f446re"),
    ("ecss-can-pyboard-v11", "boards/pyboard-v11"),
    ("ecss-can-runtime", "boards/runtime"),
    ("ecss-can-stm32f4", "boards/stm32f4"),
    ("ecss-can-stm32f4discovery", "boards/stm32f4discovery"),
];

/// Writes a project of a user, whose configuration of cargo replaces crates of the registry.
fn project(folder: &Path) {
    let mut patch = "[patch.crates-io]\n".to_owned();
    for (name, path) in CRATES {
        writeln!(patch, "{name} = {{ path = {:?} }}", root().join(path)).expect("a text");
    }
    for (path, text) in [
        ("Cargo.toml", "[package]\nname = \"mine\"\nedition = \"2024\"\n[workspace]\n"),
        ("src/lib.rs", ""),
        (".cargo/config.toml", &patch),
    ] {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    // Shares what is compiled, and the lock of the builds.
    let firmware = folder.join("target/firmware");
    fs::create_dir_all(&firmware).expect("a folder");
    for name in ["build", "lock"] {
        symlink(target().join("firmware").join(name), firmware.join(name)).expect("a link");
    }
}

/// What another order of functions may change of the size of a segment, in bytes: which of two equal ends they share, and gaps.
const ORDER: u64 = 64;

/// Sizes of the loadable segments of an image.
fn sizes(image: &Path) -> Vec<u64> {
    let elf = fs::read(image).unwrap_or_else(|error| panic!("{}: {error}", image.display()));
    let file = object::File::parse(&*elf).expect("an ELF file");
    file.segments().map(|segment| segment.size()).collect()
}

/// Given a project of a user and a program without checkout, when the slave is built there, then the sources are written below the
/// project, and the image has the segments of the image that the repository builds, by their sizes. The order of functions is
/// another one: names of symbols contain a hash of the place that a package comes from.
#[test]
fn image_of_shipped_sources_has_the_sizes_of_the_usual_one() {
    let of_repository = build_image("pyboard-v11", "slave", "standard", LOG).expect("an image");
    let folder = tempfile::tempdir().expect("a folder");
    project(folder.path());
    let mut program = Command::new(env!("CARGO_BIN_EXE_ecss-can"));
    program.args(["build", "slave", "--profile", "standard"]);
    program.env("ECSS_CAN_SOURCES", "shipped").env_remove("CARGO_TARGET_DIR").current_dir(folder.path());
    let output = program.output().expect("the program starts");
    let said = String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned();
    assert!(output.status.success(), "{said}");
    let target = folder.path().join("target");
    let sources = target.join(concat!("ecss-can-", env!("CARGO_PKG_VERSION")));
    assert!(sources.join("firmware/slave/src/app.rs").is_file(), "{said}");
    let image = target.join("firmware/pyboard-v11-standard/slave");
    let (ours, theirs) = (sizes(&of_repository), sizes(&image));
    assert_eq!(ours.len(), theirs.len());
    assert!(
        ours.iter().zip(&theirs).all(|(one, other)| one.abs_diff(*other) <= ORDER),
        "{ours:?} {theirs:?}"
    );
}
