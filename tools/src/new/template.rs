//! The *templates*: files of a new project with places for its names. They are stored in this program.
//!
//! A place is a name in double braces, such as `{{name}}`.

use std::fs;
use std::path::Path;

use anyhow::Context;

/// A file of a new project.
#[derive(Clone, Copy, Debug)]
pub(super) struct File {
    /// Path in the folder of the project.
    pub(super) path: &'static str,
    /// Content with places.
    text: &'static str,
}

/// Makes a [`File`] from the path in the project and the path below `templates`.
macro_rules! files {
    ($($path:literal: $from:literal),* $(,)?) => {
        &[$(File { path: $path, text: include_str!(concat!("../../templates/", $from)) }),*]
    };
}

/// Files of a folder with a `mission.toml`: its flight, tested versions of dependencies and toolchain.
pub(super) const PROJECT: &[File] = files! {
    ".gitignore": "common/ignored",
    "Cargo.lock": "../shipped/Cargo.lock",
    "rust-toolchain.toml": "../shipped/rust-toolchain.toml",
    "tests/flight.rs": "common/flight.rs",
};

/// Package of a slave.
pub(super) const SLAVE: &[File] = files! {
    "Cargo.toml": "slave/Cargo.toml.in",
    "build.rs": "common/image.rs",
    "src/lib.rs": "slave/src/lib.rs",
    "src/main.rs": "slave/src/main.rs",
    "src/app.rs": "slave/src/app.rs",
    "tests/world.rs": "slave/tests/world.rs",
};

/// Its flight.
pub(super) const SLAVE_MISSION: &[File] = files! {
    "README.md": "slave/README.md",
    "mission.toml": "slave/mission.toml",
};

/// Package of a master, and its flight.
pub(super) const MASTER: &[File] = files! {
    "Cargo.toml": "master/Cargo.toml.in",
    "README.md": "master/README.md",
    "build.rs": "common/image.rs",
    "mission.toml": "master/mission.toml",
    "src/lib.rs": "master/src/lib.rs",
    "src/main.rs": "master/src/main.rs",
    "src/app.rs": "master/src/app.rs",
    "tests/world.rs": "master/tests/world.rs",
};

/// Crate of a board, and a flight of the shipped images on it.
pub(super) const BOARD: &[File] = files! {
    "Cargo.toml": "board/Cargo.toml.in",
    "README.md": "board/README.md",
    "board.toml": "board/board.toml",
    "build.rs": "board/build.rs",
    "mission.toml": "board/mission.toml",
    "src/lib.rs": "board/src/lib.rs",
    "tests/board.rs": "board/tests/board.rs",
};

/// Values of places by their names.
#[derive(Clone, Debug, Default)]
pub(super) struct Places(Vec<(&'static str, String)>);

impl Places {
    /// Adds the value of a place, or replaces it.
    pub(super) fn with(mut self, name: &'static str, value: impl Into<String>) -> Places {
        self.0.retain(|(other, _)| *other != name);
        self.0.push((name, value.into()));
        self
    }

    /// Returns the content of a file.
    pub(super) fn fill(&self, file: File) -> String {
        let fill =
            |text: String, (name, value): &(&str, String)| text.replace(&format!("{{{{{name}}}}}"), value);
        self.0.iter().fold(file.text.to_owned(), fill)
    }

    /// Writes files into `folder`.
    ///
    /// # Errors
    /// When that fails.
    pub(super) fn write(&self, files: &[File], folder: &Path) -> anyhow::Result<()> {
        files.iter().try_for_each(|file| write(&folder.join(file.path), &self.fill(*file)))
    }
}

/// Writes a file, and makes its folder.
///
/// # Errors
/// When that fails.
pub(super) fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    let make = || path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(path, text));
    make().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_filled_and_the_last_value_counts() {
        let file = File { path: "a", text: "{{name}} of {{name}}, {other} {{}}" };
        let places = Places::default().with("name", "x").with("name", "y");
        assert_eq!(places.fill(file), "y of y, {other} {{}}");
    }

    /// Given the folder `templates`, then each of its files is in a template.
    #[test]
    fn each_file_of_the_folder_is_in_a_template() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates");
        let texts: Vec<&str> =
            [PROJECT, SLAVE, SLAVE_MISSION, MASTER, BOARD].concat().iter().map(|file| file.text).collect();
        let mut folders = vec![folder];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    folders.push(path);
                } else {
                    let text = fs::read_to_string(&path).expect("text");
                    assert!(texts.contains(&&*text), "{} is in no template", path.display());
                }
            }
        }
    }
}
