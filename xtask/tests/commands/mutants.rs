//! `cargo xtask mutants` with a cargo-mutants that runs no test: it tells what the test wants it to tell.
#![cfg(unix)]

use std::fs;
use std::path::Path;

use second::programs::fake::{path_without, script};

use crate::XTASK;
use crate::docs::{metadata, root};

/// Configurations of cargo-mutants: those of the first step, and those of a second one or of the only one.
const CONFIGURATIONS: [&[&str]; 2] = [
    &["mutants.toml", "mutants-redundancy.toml"],
    &["mutants-all.toml", "mutants-applications.toml", "mutants-redundancy-two-faults.toml"],
];

const LIST: &str = "shared/src/lib.rs:1:1: replace one -> u8 with 0\n\
    shared/src/lib.rs:2:1: replace two -> u8 with 0\nshared/src/lib.rs:2:9: delete ! in two\n";

/// A program that lists these mutants. Run with the first configuration, then with the second one, it catches those that
/// `caught` of it names, and misses all others.
fn fake(folder: &Path, caught: [&str; 2]) {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("a file");
    write("list", LIST);
    for (names, caught) in CONFIGURATIONS.iter().zip(caught) {
        names.iter().for_each(|name| write(name, caught));
    }
    let here = folder.display();
    let text = format!(
        r#"[ "$1" = mutants ] || exit 1
[ "$2" = --version ] && exit 0
config=$(basename "$3")
[ "$4" = --list ] && exec cat {here}/list
echo "$@" >> {here}/arguments
while [ "$1" != --output ]; do shift; done
mkdir -p "$2/mutants.out" && cd "$2/mutants.out" || exit 1
cat {here}/$config > caught.txt
grep -vxFf caught.txt {here}/list > missed.txt
: > timeout.txt; : > unviable.txt
exit 2
"#
    );
    script(&folder.join("cargo-mutants"), &text);
}

/// Runs with that program. Returns exit code, stdout and stderr.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut mutants = XTASK.command(&["mutants", "--out", folder.to_str().expect("UTF-8")]);
    let path = path_without("cargo-mutants", Some(folder));
    let output = mutants.args(arguments).env("PATH", path).output().expect("xtask starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Given mutants of the protocol, of the applications and of the redundancy, then those that the tests of the first step miss meet those of
/// the second one, if there is one, and both are counted. Two of three are caught.
#[test]
fn mutants_meet_the_tests_of_their_steps() {
    let [one, two, three] = [0, 1, 2].map(|nth| LIST.lines().nth(nth).expect("a mutant"));
    let both = format!("{one}\n{three}");
    for (options, caught, by_first, calls) in [
        (
            &[][..],
            [one, three],
            " 1 of them by the tests by clause,",
            &["mutants.toml", "mutants-all.toml"][..],
        ),
        (&["--by-clause"], [&both, ""], " 2 of them by the tests by clause,", &["mutants.toml"]),
        (&["--applications"], ["", &both], "", &["mutants-applications.toml"]),
        (
            &["--redundancy"],
            [one, three],
            " 1 of them with one fault,",
            &["mutants-redundancy.toml", "mutants-redundancy-two-faults.toml"],
        ),
    ] {
        let here = tempfile::tempdir().expect("a temporary directory");
        fake(here.path(), caught.map(|names| format!("{names}\n")).each_ref().map(String::as_str));
        let (code, stdout, stderr) = run(here.path(), &[options, &["--at-least", "66"]].concat());
        let expected = format!(
            "missed: {two}\n2 of 3 mutants caught,{by_first} 0 by a test that did not end; 0 more do not compile\n"
        );
        assert_eq!((stdout, code), (expected, Some(0)), "{options:?}: {stderr}");

        let called = fs::read_to_string(here.path().join("arguments")).expect("it was called");
        let called: Vec<&str> = called.lines().collect();
        assert_eq!(called.len(), calls.len(), "{options:?}: {called:?}");
        for (called, config) in called.iter().zip(calls) {
            assert!(called.contains(&format!(".cargo/{config}")), "{options:?}: {called}");
            // Tests of other packages than the mutated one have no baseline.
            assert_eq!(
                called.contains("--baseline skip"),
                *config != "mutants.toml",
                "{options:?}: {called}"
            );
        }
        assert!(called[0].contains("with 0$") && called[0].contains("replace one"), "{options:?}");
        assert!(called[1..].iter().all(|call| !call.contains("replace one")), "{options:?}: it is caught");

        let (code, _, stderr) = run(here.path(), &[options, &["--at-least", "67"]].concat());
        assert_eq!(code, Some(1), "{options:?}: {stderr}");
        assert!(stderr.contains("fewer than 67 percent"), "{options:?}: {stderr}");
    }
    for options in [
        ["--applications", "--by-clause"],
        ["--redundancy", "--by-clause"],
        ["--redundancy", "--applications"],
    ] {
        XTASK.refuses(&[&["mutants"], &options[..]].concat(), &options);
    }
}

#[test]
fn one_seed_draws_one_sample() {
    let here = tempfile::tempdir().expect("a temporary directory");
    fake(here.path(), ["", ""]);
    let list = |arguments: &[&str]| run(here.path(), &[&["--list"], arguments].concat()).1;
    let all = list(&[]);
    let mut sorted: Vec<&str> = all.lines().collect();
    sorted.sort_unstable();
    let mut lines: Vec<&str> = LIST.lines().collect();
    lines.sort_unstable();
    assert_eq!(sorted, lines);
    assert!(all.starts_with(&list(&["--sample", "2"])) && list(&["--sample", "2"]).lines().count() == 2);
    let orders: Vec<String> = (0..20).map(|seed| list(&["--seed", &seed.to_string()])).collect();
    assert_eq!(orders[1], all, "the seed is 1 where none is given");
    assert!(orders.iter().any(|order| *order != all));
}

#[test]
fn wrong_numbers_are_refused() {
    for (option, value, expected) in
        [("--sample", "0", "'0'"), ("--at-least", "101", "'101'"), ("--seed", "x", "'x'")]
    {
        XTASK.refuses(&["mutants", option, value], &[option, expected]);
    }
}

/// Given the configurations of cargo-mutants, then each package whose tests they run exists: without its tests every mutant would
/// count as caught.
#[test]
fn packages_that_test_mutants_exist() {
    let packages = metadata().packages;
    for name in CONFIGURATIONS.concat() {
        let text = fs::read_to_string(root().join(".cargo").join(name)).expect(name);
        let config: toml::Table = text.parse().expect(name);
        let tested = config["test_package"].as_array().expect("a list");
        let is_known =
            |name: &&toml::Value| packages.iter().any(|package| name.as_str() == Some(package.name.as_str()));
        assert!(!tested.is_empty() && tested.iter().all(|name| is_known(&name)), "{name}: {tested:?}");
    }
}
