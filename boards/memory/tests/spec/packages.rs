//! The work of a build script, in packages on disk.

use std::fs;
use std::path::Path;

use ecss_can_memory::place_for;
use tempfile::TempDir;

/// A package of a board with this chip, with a `board.toml` or without.
fn package(chip: &str, board: Option<&str>) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let manifest = format!("[dependencies]\nembassy-stm32 = {{ features = ['{chip}'] }}\n");
    fs::write(folder.path().join("Cargo.toml"), manifest).unwrap();
    if let Some(board) = board {
        fs::write(folder.path().join("board.toml"), format!("chip = '{board}'\n")).unwrap();
    }
    folder
}

fn rerun(folder: &Path) -> [String; 2] {
    ["Cargo.toml", "board.toml"].map(|file| format!("cargo:rerun-if-changed={}/{file}", folder.display()))
}

/// Given a board with a description, when it is built for the chip, then `memory.x` is in the folder that the linker searches.
#[test]
fn image_gets_its_memory_map() {
    let (package, out) = (package("stm32f446re", Some("STM32F446RETx")), tempfile::tempdir().unwrap());
    let lines = place_for(package.path(), Some(out.path())).unwrap();
    let [manifest, board] = rerun(package.path());
    assert_eq!(lines, [manifest, board, format!("cargo:rustc-link-search={}", out.path().display())]);
    let map = fs::read_to_string(out.path().join("memory.x")).unwrap();
    assert!(map.contains("  STORE : ORIGIN = 0x08040000, LENGTH = 256K\n"), "{map}");
}

#[test]
fn build_for_the_host_checks_and_writes_no_file() {
    let package = package("stm32f405rg", Some("stm32f405rg"));
    assert_eq!(place_for(package.path(), None).unwrap(), rerun(package.path()));
    assert_eq!(fs::read_dir(package.path()).unwrap().count(), 2);
}

/// Given a board without description, when it is built, then no `rerun-if-changed` hides a `board.toml` that is added later.
#[test]
fn package_without_description_reruns_at_each_change() {
    assert!(place_for(package("stm32f405rg", None).path(), None).unwrap().is_empty());
}

#[test]
fn other_chip_in_the_description_is_refused_with_both_names() {
    for board in ["STM32F446RETx", "STM32F405VG", "STM32F405"] {
        let out = tempfile::tempdir().unwrap();
        let error = place_for(package("stm32f405rg", Some(board)).path(), Some(out.path())).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "Cargo.toml has the chip stm32f405rg (a feature of embassy-stm32), but board.toml has the chip {board}: \
                 write the same chip in both"
            )
        );
        assert!(!out.path().join("memory.x").exists());
    }
}

#[test]
fn missing_manifest_is_reported_with_its_path() {
    let folder = tempfile::tempdir().unwrap();
    let error = place_for(folder.path(), None).unwrap_err().to_string();
    assert!(error.starts_with(&format!("{}/Cargo.toml: ", folder.path().display())), "{error}");
}
