//! A board whose crate is in another folder: the shipped images are built for it and run on it.

use std::fs;

use second::programs::boards::elsewhere;
use serde_json::Value;

use crate::TOOLS;

/// Given the crate of a board elsewhere, then `build` prints where its images are: in a folder that no board of this project has.
#[test]
fn images_are_built_for_a_board_elsewhere() {
    let board = elsewhere(env!("CARGO_TARGET_TMPDIR"));
    let (code, lines, stderr) = TOOLS.run(&["build", "--profile", "standard", "--board", &board]);
    assert_eq!(code, 0, "{stderr}");
    for (line, image) in lines.lines().zip(["master", "slave", "minimal"]) {
        assert!(line.starts_with(image) && line.ends_with(&format!("/{image}")), "{lines}");
        assert!(line.contains("/firmware/moved-") && line.contains("-standard/"), "{lines}");
    }
    assert_eq!(lines.lines().count(), 3);
}

/// Given the crate of a board elsewhere, when the shipped images run on it and the nominal bus is cut, then all of them
/// follow the master. They are found again without a build, and the images of this project's boards are unchanged.
#[test]
fn shipped_images_fly_on_a_board_elsewhere() {
    let usual = ecss_can_cli::images::build("pyboard-v11", "standard").expect("images");
    let before = fs::read(&usual.slave).expect("an image");
    let board = elsewhere(env!("CARGO_TARGET_TMPDIR"));
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = here.path().to_str().expect("UTF-8");
    let flight =
        ["fly", "--board", &board, "--profile", "standard", "--slaves", "1", "--minimal", "1", "--out", out];
    for more in [&["--seconds", "3", "--cut-at", "1.5"][..], &["--seconds", "2", "--no-build"]] {
        let (code, stdout, stderr) = TOOLS.run(&[&flight[..], more].concat());
        assert_eq!(code, 0, "{stdout}{stderr}");
        let summary = fs::read(here.path().join("summary.json")).expect("a summary");
        let summary: Value = serde_json::from_slice(&summary).expect("JSON");
        assert_eq!((&summary["board"], &summary["lost_frames"]), (&"moved".into(), &0.into()), "{summary}");
        assert_eq!(summary["slaves_operational_at_end"], 2);
    }
    assert_eq!(fs::read(&usual.slave).expect("an image"), before);
}
