//! `cargo xtask selftest`: on the emulated board, and with a probe-rs that only records its arguments.

use crate::XTASK;

#[test]
fn emulated_board_prints_each_check() {
    let (code, stdout, stderr) = XTASK.run(&["selftest", "--twin", "--board", "nucleo-f446re"]);
    assert_eq!(code, 0, "{stderr}");
    let lines: Vec<&str> = stdout.lines().collect();
    assert!(lines.contains(&"1 clock: good"), "{stdout}");
    assert!(lines.contains(&"9 straps: good"), "{stdout}");
    assert_eq!(lines.last(), Some(&"selftest: all good"), "{stdout}");
}

#[test]
fn arguments_of_probe_rs_are_refused_on_the_emulated_board() {
    XTASK.refuses(&["selftest", "--twin", "--", "--probe", "1234:5678"], &["--twin"]);
}

/// Given a probe-rs in PATH, then it gets the chip, the image and the arguments, and its exit code is passed on.
#[cfg(unix)]
#[test]
fn image_is_handed_to_probe_rs() {
    use second::programs::fake::{fake, path_without};

    let here = tempfile::tempdir().expect("a temporary directory");
    let written = fake(here.path(), "probe-rs", 7);
    let path = path_without("probe-rs", Some(here.path()));
    let status = XTASK.command(&["selftest", "--", "--probe", "1234:5678"]).env("PATH", path).status();
    assert_eq!(status.expect("xtask starts").code(), Some(7));
    let told = std::fs::read_to_string(written).expect("probe-rs was called");
    let words: Vec<&str> = told.lines().collect();
    let [run, option, chip, image, rest @ ..] = &words[..] else { panic!("{told}") };
    assert_eq!([*run, *option, *chip], ["run", "--chip", "STM32F405RG"]);
    assert!(image.ends_with("pyboard-v11-standard/selftest"), "{image}");
    assert_eq!(rest, ["--probe", "1234:5678"]);
}
