//! Features of the mission that exclude each other.

use std::process::Command;

/// The features of the manifest that choose a profile or a bit rate.
fn choices() -> (Vec<&'static str>, Vec<&'static str>) {
    let features =
        include_str!("../../Cargo.toml").split("[features]").nth(1).unwrap().split("\n[").next().unwrap();
    let names = features.lines().filter_map(|line| line.strip_suffix(" = []"));
    names.partition(|name| !name.starts_with("kbit-"))
}

/// Compiles the module that refuses features. Returns what the compiler reports, nothing if it accepts them.
fn compiled(features: &[&str]) -> String {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/src/choice.rs");
    let mut compiler = Command::new("rustc");
    compiler.args(["--edition=2024", "--crate-type=lib", "--emit=metadata", "--error-format=short"]);
    compiler.args(["--out-dir", env!("CARGO_TARGET_TMPDIR"), "-Aunused", source]);
    for feature in features {
        compiler.args(["--cfg", &format!("feature=\"{feature}\"")]);
    }
    let output = compiler.output().expect("the compiler runs");
    let report = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.success(), report.is_empty(), "{report}");
    report
}

/// Given two features that choose a profile, or two that choose a bit rate, when the mission is compiled with both, then the
/// error names both, and there is one for them.
#[test]
fn two_profiles_or_two_bit_rates_do_not_compile() {
    let (profiles, bit_rates) = choices();
    assert_eq!((profiles.len(), bit_rates.len()), (2, 6));
    for (what, features) in [("profiles", &profiles), ("bit rates", &bit_rates)] {
        for (nth, one) in features.iter().enumerate() {
            for other in &features[..nth] {
                let report = compiled(&[one, other]);
                let names = [one, other].iter().all(|name| report.contains(&format!("`{name}`")));
                assert!(names && report.contains(&format!("two {what}: choose one")), "{report}");
                assert_eq!(report.matches("features `").count(), 1, "{report}");
            }
        }
    }
}

#[test]
fn a_profile_and_a_bit_rate_compile_together() {
    let (profiles, bit_rates) = choices();
    assert_eq!(compiled(&[]), "");
    for profile in &profiles {
        for bit_rate in &bit_rates {
            assert_eq!(compiled(&[profile, bit_rate]), "");
        }
    }
}
