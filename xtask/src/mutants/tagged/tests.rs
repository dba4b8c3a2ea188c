//! Which tests must notice a violation, and what their output says.

use std::process::ExitStatus;

use super::*;

fn tag(folder: &str, place: Option<usize>, function: &str, id: &str) -> Tag {
    let target = Target {
        package: folder.replace('/', "-"),
        folder: folder.to_owned(),
        options: vec!["--lib".to_owned()],
        place,
    };
    let (function, ids) = (function.to_owned(), vec![id.to_owned()]);
    Tag { function, ids, target, runs: true, ..Tag::default() }
}

fn shown(runs: &[Run<'_>]) -> Vec<String> {
    runs.iter().map(|run| format!("{} {}", run.target.package, run.tests.join(" "))).collect()
}

/// Given packages one inside of another, tests of two tiers, and a summary, then the own tests come first, among them those of the
/// package with the changed file.
#[test]
fn own_tests_of_the_changed_package_come_first() {
    let tags = [
        tag("shared", Some(0), "one", "8.3.3h"),
        tag("shared/canopen", Some(1), "two", "8.3.3h"),
        tag("tests/second", None, "later", "8.3.3h"),
        tag("tests/host", Some(2), "three", "8.3.3h"),
        tag("tests/host", Some(2), "four", "8.3.3h"),
        tag("shared/canopen", Some(1), "five", "6.1a"),
    ];
    let summary = Summary { id: "8.3.3h".into(), clauses: "6.1".into(), reason: String::new() };
    let of = |id, changed: &str| shown(&runs(id, &tags, std::slice::from_ref(&summary), &[changed.into()]));
    let expected = ["shared-canopen two", "shared one", "tests-host three four", "shared-canopen five"];
    assert_eq!(of("8.3.3h", "shared/canopen/src/lib.rs"), expected);
    let expected = ["shared one", "shared-canopen two", "tests-host three four", "shared-canopen five"];
    assert_eq!(of("8.3.3h", "shared/src/lib.rs"), expected);
    assert_eq!(of("6.1a", "boards/a.rs"), ["shared-canopen five"]);
}

/// Given outputs of tests, then a failed test counts, and a crash, a time-out or an error of the compiler does not.
#[test]
fn failed_test_alone_finds_a_defect() {
    let tags = [tag("shared", Some(0), "one", "1a"), tag("shared", Some(0), "two", "1a")];
    let runs = runs("1a", &tags, &[], &[]);
    let ending = |out: &str, err: &str| {
        let [stdout, stderr] = [out, err].map(|text| text.as_bytes().to_vec());
        runs[0].ending(&Output { status: ExitStatus::default(), stdout, stderr })
    };
    let result = "test result: FAILED.";
    let ok = "running 2 tests\ntest one ... ok\ntest two - should panic ... ok\ntest result: ok.\n";
    let failed = format!("running 2 tests\ntest one ... ok\ntest two ... FAILED\n{result}\n");
    let compiler = "error: could not compile `shared` (lib) due to 1 previous error";
    for (out, err, expected) in [
        (ok, "", Ending::Passed),
        (&failed, "", Ending::Failed("two".to_owned())),
        (&failed, compiler, Ending::Useless("it does not compile")),
        ("running 2 tests\ntest one ... ok\n", "signal: 6, SIGABRT", Ending::Useless("the tests crashed")),
        ("running 2 tests\n", "(exit status: 124)", Ending::Useless("the tests did not end")),
    ] {
        assert_eq!(ending(out, err).expect("the tests are there"), expected, "{out}{err}");
    }
    let missing = ending(&failed.replace("test two", "test three"), "").expect_err("a test is missing");
    assert!(missing.to_string().contains("there is no test two"), "{missing}");
    let none = ending("", "error: no test target named `spec`").expect_err("no test ran");
    assert!(none.to_string().contains("no test target named `spec`"), "{none}");
}
