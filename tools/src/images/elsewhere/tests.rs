//! The manifests generated from small shipped ones.

use super::*;
use crate::images::workspace;

const ROOT: &str = r#"
[workspace]
resolver = "3"
members = ["shared", "firmware/master"]
default-members = ["shared"]

[workspace.package]
version = "0.1.0"

[workspace.lints.rust]
unused_must_use = "deny"

[workspace.dependencies]
ecss-can = { path = "shared" }
defmt = "1"

[profile.firmware]
inherits = "release"

[profile.firmware.package.master]
opt-level = "s"

[profile.dev.package.twin]
opt-level = 3
"#;

const IMAGE: &str = r#"
[package]
name = "minimal"
version.workspace = true

[features]
one-controller = []

[target.'cfg(target_os = "none")'.dependencies]
ecss-can-stm32f4 = { path = "../../boards/stm32f4", default-features = false }
ecss-can = { workspace = true, features = ["defmt"] }
pyboard-v11 = { workspace = true, optional = true }
nucleo-f446re = { workspace = true, optional = true }

[lints]
workspace = true
"#;

fn table_of(text: &str) -> Table {
    text.parse().unwrap()
}

fn board() -> Elsewhere {
    Elsewhere { folder: "/mine/h405".into(), package: "olimex-h405".into() }
}

#[test]
fn root_has_what_images_inherit_with_absolute_paths() {
    let boards = ["nucleo-f446re", "pyboard-v11"].map(str::to_owned);
    let made = root_manifest(table_of(ROOT), Path::new("/project"), &boards);
    let expected = r#"
        [workspace]
        resolver = "3"
        members = ["master", "slave", "minimal", "checks"]
        [workspace.package]
        version = "0.1.0"
        [workspace.lints.rust]
        unused_must_use = "deny"
        [workspace.lints.rust.unexpected_cfgs]
        level = "warn"
        check-cfg = ['cfg(feature, values("nucleo-f446re", "pyboard-v11"))']
        [workspace.dependencies]
        ecss-can = { path = "/project/shared" }
        defmt = "1"
        [profile.firmware]
        inherits = "release"
        [profile.firmware.package.master]
        opt-level = "s"
    "#;
    assert_eq!(made, table_of(expected));
}

#[test]
fn member_is_the_shipped_image_for_one_board() {
    let made = member_manifest(table_of(IMAGE), Path::new("/project/firmware/minimal"), &board());
    let expected = r#"
        [package]
        name = "minimal"
        version.workspace = true
        build = "build.rs"
        [features]
        one-controller = []
        [[bin]]
        name = "minimal"
        path = "/project/firmware/minimal/src/main.rs"
        [target.'cfg(target_os = "none")'.dependencies]
        ecss-can-stm32f4 = { path = "/project/firmware/minimal/../../boards/stm32f4", default-features = false }
        ecss-can = { workspace = true, features = ["defmt"] }
        board = { package = "olimex-h405", path = "/mine/h405" }
        [lints]
        workspace = true
    "#;
    assert_eq!(made, table_of(expected));
}

/// Given an image with several programs, then each has the path of its own source.
#[test]
fn programs_keep_their_names_and_settings() {
    let image = "[package]\nname = \"checks\"\n[[bin]]\nname = \"selftest\"\ntest = false\n\
                 [[bin]]\nname = \"pulse\"\npath = \"src/p.rs\"\n";
    let made = member_manifest(table_of(image), Path::new("/project/firmware/checks"), &board());
    let expected = r#"
        [package]
        name = "checks"
        build = "build.rs"
        [[bin]]
        name = "selftest"
        test = false
        path = "/project/firmware/checks/src/bin/selftest.rs"
        [[bin]]
        name = "pulse"
        path = "/project/firmware/checks/src/p.rs"
    "#;
    assert_eq!(made, table_of(expected));
}

/// The shipped images have only their boards as optional dependencies.
#[test]
fn shipped_images_have_boards_alone_as_optional_dependencies() {
    for member in MEMBERS {
        let image = parse(&workspace().join("firmware").join(member).join("Cargo.toml")).unwrap();
        let boards = optional_dependencies(&image);
        assert!(boards.iter().any(|name| name == "pyboard-v11"), "{member}: {boards:?}");
        for board in boards {
            let description = workspace().join("boards").join(&board).join("board.toml");
            assert!(description.is_file(), "{member}: {board}");
        }
    }
}

#[test]
fn crates_of_boards_are_patched_where_they_have_a_path() {
    let text = "[workspace.dependencies]\necss-can-memory = { path = \"/project/memory\" }\necss-can-stm32f4 = \"0.2\"\n";
    let mut manifest = table_of(text);
    patch(&mut manifest);
    let patched = &manifest["patch"]["crates-io"];
    assert_eq!(patched["ecss-can-memory"]["path"].as_str(), Some("/project/memory"));
    assert!(patched.get("ecss-can-stm32f4").is_none());
}
