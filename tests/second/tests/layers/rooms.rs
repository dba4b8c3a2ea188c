//! Dependencies between packages lead to the same room of the workspace or to a lower one.
//!
//! A *room* is a folder of packages. Dev-dependencies are for tests, which may name everything.

use std::path::Path;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package, TargetKind};

/// Each room with the rooms below it. The room of a package is the longest matching folder.
const ROOMS: [(&str, &[&str]); 11] = [
    // It reads files, and names no package.
    ("shared/data-sheet", &[]),
    ("shared/derive", &["shared/data-sheet"]),
    // CANopen without ECSS. Packages above `shared` that have nothing to do with ECSS name it alone.
    ("shared/canopen", &["shared/derive"]),
    ("shared", &["shared/canopen", "shared/data-sheet"]),
    ("boards", &["shared", "shared/canopen"]),
    ("firmware", &["boards", "shared", "shared/canopen"]),
    // The emulated board reads an ELF file and a description of a board, no package.
    ("twin", &["shared"]),
    // Images on boards.
    ("twin/foreign", &["boards", "shared"]),
    ("tools", &["twin", "firmware", "boards", "shared"]),
    ("xtask", &["tools", "twin", "firmware", "boards", "shared"]),
    ("tests", &["xtask", "tools", "twin/foreign", "twin", "firmware", "boards", "shared", "shared/canopen"]),
];

/// Rooms of images. Only a package with an image may depend on a board.
const ROOMS_OF_IMAGES: [&str; 2] = ["firmware", "twin/foreign"];

pub fn metadata(folder: &Path) -> Metadata {
    let manifest = folder.join("Cargo.toml");
    MetadataCommand::new()
        .manifest_path(manifest)
        .no_deps()
        .other_options(["--offline".to_owned()])
        .exec()
        .unwrap()
}

/// A package, by its folder from the root of the workspace.
struct Place {
    folder: String,
    /// Whether the package has the description of a board.
    is_board: bool,
}

impl Place {
    fn new(folder: &Path, workspace: &Path) -> Place {
        let shown = folder.strip_prefix(workspace).unwrap().to_str().unwrap().replace('\\', "/");
        Place { folder: shown, is_board: folder.join("board.toml").exists() }
    }

    /// Returns its room and the rooms below.
    fn room(&self) -> Option<(&'static str, &'static [&'static str])> {
        let folder = Path::new(&self.folder);
        ROOMS.into_iter().filter(|(room, _)| folder.starts_with(room)).max_by_key(|(room, _)| room.len())
    }
}

/// Returns dependencies that break the rules, and packages outside all rooms.
fn offences(workspace: &Metadata) -> Vec<String> {
    let root = workspace.workspace_root.as_std_path();
    workspace.packages.iter().flat_map(|package| offences_of(package, root)).collect()
}

fn offences_of(package: &Package, workspace: &Path) -> Vec<String> {
    let place = Place::new(package.manifest_path.parent().unwrap().as_std_path(), workspace);
    let Some((room, below)) = place.room() else { return vec![format!("{} is in no room", place.folder)] };
    let is_image = ROOMS_OF_IMAGES.contains(&room)
        && package.targets.iter().any(|target| target.is_kind(TargetKind::Bin));
    let needed =
        package.dependencies.iter().filter(|dependency| dependency.kind != DependencyKind::Development);
    let reason = |other: &Place| {
        let other_room = other.room()?.0;
        if other_room != room && !below.contains(&other_room) {
            return Some(format!("{room} is not above {other_room}"));
        }
        let is_allowed = !other.is_board || is_image || room == "boards" || room == "tests";
        (!is_allowed).then(|| "only an image depends on a board".to_owned())
    };
    let others = needed.filter_map(|dependency| dependency.path.as_ref());
    let offence =
        |other: Place| Some(format!("{} depends on {}: {}", place.folder, other.folder, reason(&other)?));
    let mut found: Vec<String> =
        others.filter_map(|folder| offence(Place::new(folder.as_std_path(), workspace))).collect();
    found.dedup();
    found
}

#[test]
fn dependencies_lead_to_the_same_room_or_a_lower_one() {
    let workspace = metadata(&crate::workspace());
    assert!(workspace.packages.len() > 25, "the packages are not where they are expected");
    let offences = offences(&workspace);
    assert!(offences.is_empty(), "{}", offences.join("\n"));
}

/// Workspace of two packages, of which the first has `section` with the second as dependency; both are libraries and, with
/// `has_image`, the first has a program as well.
fn pair(one: &str, other: &str, section: &str, has_image: bool) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, text).unwrap();
    };
    write("Cargo.toml", &format!("[workspace]\nresolver = \"3\"\nmembers = [\"{one}\", \"{other}\"]"));
    let path = folder.path().join(other);
    let dependency = format!("[{section}]\nother = {{ path = {path:?} }}\n");
    for (place, name, rest) in [(one, "one", dependency.as_str()), (other, "other", "")] {
        write(
            &format!("{place}/Cargo.toml"),
            &format!("[package]\nname = \"{name}\"\nedition = \"2024\"\n{rest}"),
        );
        write(&format!("{place}/src/lib.rs"), "");
    }
    if has_image {
        write(&format!("{one}/src/main.rs"), "");
    }
    if other.starts_with("boards/") && !other.ends_with("stm32f4") {
        write(&format!("{other}/board.toml"), "");
    }
    folder
}

/// Offences of such a workspace.
fn found(one: &str, other: &str, section: &str, has_image: bool) -> Vec<String> {
    let folder = pair(one, other, section, has_image);
    offences(&metadata(&folder.path().canonicalize().unwrap()))
}

/// Given two packages, when one depends on the other from a lower room, then that is found.
#[test]
fn a_dependency_on_a_higher_room_is_found() {
    let pairs = [
        ("shared/canopen", "shared/eds"),
        ("shared/derive", "shared/canopen"),
        ("twin", "shared/canopen"),
        ("shared/eds", "boards/stm32f4"),
        ("shared/eds", "twin"),
        ("boards/stm32f4", "firmware/mission"),
        ("boards/stm32f4", "twin"),
        ("twin", "boards/stm32f4"),
        ("twin", "firmware/mission"),
        ("twin/foreign", "firmware/mission"),
        ("twin", "twin/foreign"),
        ("firmware/slave", "twin"),
        ("firmware/slave", "tools"),
        ("tools", "xtask"),
        ("tools", "twin/foreign"),
        ("tools", "tests/flight"),
        ("xtask", "tests/flight"),
    ];
    for (one, other) in pairs {
        for section in
            ["dependencies", "build-dependencies", "target.'cfg(target_os = \"none\")'.dependencies"]
        {
            let found = found(one, other, section, true);
            assert_eq!(found.len(), 1, "{one} {other} {section}");
            assert!(found[0].starts_with(&format!("{one} depends on {other}: ")), "{found:?}");
        }
    }
}

#[test]
fn a_board_is_found_where_no_image_is() {
    for (one, has_image) in [("tools/worlds", true), ("xtask", true), ("firmware/mission", false)] {
        let found = found(one, "boards/pyboard", "dependencies", has_image);
        assert_eq!(found, [format!("{one} depends on boards/pyboard: only an image depends on a board")]);
    }
}

#[test]
fn a_package_outside_of_all_rooms_is_found() {
    let found = found("attic/eds", "shared/other", "dependencies", false);
    assert_eq!(found, ["attic/eds is in no room"]);
}

#[test]
fn dependencies_downward_and_of_tests_are_no_offences() {
    let pairs = [
        ("shared/eds", "shared/other", "dependencies"),
        ("shared/eds", "shared/canopen", "dependencies"),
        ("shared/canopen", "shared/derive", "dependencies"),
        ("shared/canopen", "shared/other", "dev-dependencies"),
        ("firmware/slave", "boards/pyboard", "dependencies"),
        ("twin/foreign", "boards/pyboard", "dependencies"),
        ("tools", "twin", "dependencies"),
        ("xtask", "tools", "dependencies"),
        ("tests/flight", "xtask", "dependencies"),
        ("tests/page", "tests/flight", "dependencies"),
        ("shared/eds", "firmware/mission", "dev-dependencies"),
        ("tools/worlds", "boards/pyboard", "dev-dependencies"),
    ];
    for (one, other, section) in pairs {
        assert_eq!(found(one, other, section, true), [""; 0], "{one} {other}");
    }
}
