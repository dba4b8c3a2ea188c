//! Boards of the user: a description alone, and a crate in another folder.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use super::root;

const MANIFEST: &str = r#"
[package]
name = "moved"
version = "1.0.0"
edition = "2024"

[target.'cfg(target_os = "none")'.dependencies]
ecss-can-stm32f4 = { path = "ROOT/boards/stm32f4", default-features = false }
embassy-stm32 = { version = "=0.6.0", default-features = false, features = ["stm32f405rg"] }

[build-dependencies]
ecss-can-memory = { path = "ROOT/boards/memory" }

[workspace]
"#;

/// Writes the description of the pyboard with changes, as `board.toml` in a folder of its own. Returns folder and file.
///
/// # Panics
/// When the description does not have a text that is to be replaced.
pub fn description(changes: &[(&str, &str)]) -> (TempDir, String) {
    let file = root().join("boards/pyboard-v11/board.toml");
    let mut text = fs::read_to_string(file).expect("the description of the pyboard");
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = folder.path().join("board.toml");
    fs::write(&path, text).expect("a file");
    let path = path.to_str().expect("UTF-8").to_owned();
    (folder, path)
}

/// Writes the crate of a board `moved` below `temporary`, which is `env!("CARGO_TARGET_TMPDIR")`, and returns its folder. The board is
/// the pyboard with its straps at other pins, so that no image of the pyboard flies on it. The folder is the same each time: what is built
/// for it is kept.
///
/// # Panics
/// When a file cannot be written.
pub fn elsewhere(temporary: &str) -> String {
    let folder = Path::new(temporary).join("moved");
    fs::create_dir_all(folder.join("src")).expect("a folder");
    let write = |path: &str, text: String| {
        let path = folder.join(path);
        if fs::read_to_string(&path).is_ok_and(|there| there == text) {
            return;
        }
        fs::write(path, text).expect("a file");
    };
    write("Cargo.toml", MANIFEST.replace("ROOT", &root().display().to_string()));
    for path in ["build.rs", "board.toml", "src/lib.rs"] {
        let text = fs::read_to_string(root().join("boards/pyboard-v11").join(path)).expect("the pyboard");
        let moved = text.replace("pyboard-v11", "moved").replace("PA2", "PC2").replace("PA3", "PC3");
        write(path, moved);
    }
    folder.to_str().expect("UTF-8").to_owned()
}
