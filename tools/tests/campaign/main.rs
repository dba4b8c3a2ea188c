//! The campaign of random faults: its judges, its regressions, and a share of its runs.
//!
//! `tests/scripts` has scripts, a file for each: `cargo campaign --replay FILE` runs one of them.

mod broken;
mod images;
mod jolts;
mod patches;
mod regressions;
mod share;
mod takeover;

use std::path::Path;

use ecss_can_cli::campaign::{World, fly};

/// Runs each script of a folder in `tests/scripts`. Returns the violations, with the name of the file and the script.
fn violations(folder: &str, world: World) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scripts").join(folder);
    let files =
        std::fs::read_dir(&folder).expect("a folder of scripts").map(|file| file.expect("a file").path());
    let mut files: Vec<_> = files.collect();
    files.sort();
    assert!(!files.is_empty(), "{}", folder.display());
    let of = |file: &std::path::PathBuf| {
        let script = std::fs::read_to_string(file).expect("a script");
        let violations = fly(world, &script.parse().expect("a script")).violations;
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        violations.into_iter().map(|violation| format!("{name}: {violation}\n{script}")).collect::<String>()
    };
    files.iter().map(of).collect()
}
