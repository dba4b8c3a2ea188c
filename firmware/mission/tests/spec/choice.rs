//! Features of the mission that exclude each other.

use std::process::Command;

/// Returns the features of the manifest that choose a profile or a bit rate.
fn choices() -> (Vec<&'static str>, Vec<&'static str>) {
    let features =
        include_str!("../../Cargo.toml").split("[features]").nth(1).unwrap().split("\n[").next().unwrap();
    let names = features.lines().filter_map(|line| line.strip_suffix(" = []"));
    names.partition(|name| !name.starts_with("kbit-"))
}

/// Compiles the module that refuses features. Returns what the compiler reports, nothing if it accepts them.
fn compiled(features: &[&str]) -> String {
    compiled_source(concat!(env!("CARGO_MANIFEST_DIR"), "/src/choice.rs"), features)
}

/// Compiles a file without dependencies. Returns what the compiler reports, nothing if it accepts the file.
fn compiled_source(source: &str, features: &[&str]) -> String {
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

/// Bit rates that the choice may name, kbit/s.
const BIT_RATES: &str = "#[allow(nonstandard_style)] pub enum BitRate { KBIT_10 = 10, KBIT_20 = 20, KBIT_50 = 50, \
    KBIT_125 = 125, KBIT_250 = 250, KBIT_500 = 500, MBIT_1 = 1_000 }";

/// Given the feature of each bit rate, or none, when the choice of the bit rate is compiled with it, then images run at
/// this rate. The choice offers all rates of the standard and the slower ones.
///
/// Verifies: ECSS 5.4.2b, 5.4.2a, 5.4.2a.1, 5.4.2a.2, 5.4.2a.3
/// Notices: ECSS 5.4.2b: images for 250 kbit/s run at 500 kbit/s.
/// Notices: ECSS 5.4.2a.2: images for 250 kbit/s run at 500 kbit/s.
#[test]
fn images_run_at_the_bit_rate_of_their_feature() {
    let (_, features) = choices();
    assert_eq!(features, ["kbit-500", "kbit-250", "kbit-125", "kbit-50", "kbit-20", "kbit-10"]);
    let profiles = include_str!("../../src/profiles.rs");
    let (_, choice) = profiles.split_once("const BIT_RATE: BitRate = ").unwrap();
    let (choice, _) = choice.split_once("};").unwrap();
    let mut all: Vec<(&[&str], u16)> = features.chunks(1).zip([500, 250, 125, 50, 20, 10]).collect();
    all.push((&[], 1_000));
    for (chosen, kbit) in all {
        let rate = format!("const BIT_RATE: BitRate = {choice}}};");
        let source = format!("{}/bit_rate_{kbit}.rs", env!("CARGO_TARGET_TMPDIR"));
        let program = format!("{BIT_RATES}\n{rate}\nconst _: () = assert!(BIT_RATE as u32 == {kbit});\n");
        std::fs::write(&source, program).unwrap();
        assert_eq!(compiled_source(&source, chosen), "", "{kbit} kbit/s");
    }
}
