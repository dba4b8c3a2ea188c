//! What makes `cargo xtask compliance --check` fail.

mod matrix;

use std::fs;
use std::path::{Path, PathBuf};

use super::requirements::{Applies, Interpretation, Kind, Method, Requirement, Summary};
use super::sources::{read, root};
use super::tags::Tag;
use super::tags::{self, Reading, Target};
use super::*;

/// So that this file has no tag in a comment.
const MARK: &str = "/// Verifies: ECSS";

fn row(id: &str, who: Who) -> Requirement {
    let (text, remark) = ("a rule".to_owned(), "the harness of clause 5".to_owned());
    let method = Some(if who == Who::Software { Method::T } else { Method::I });
    let (id, page) = (id.to_owned(), String::new());
    Requirement { id, who, applies: Applies::Yes, method, page, text, remark }
}

/// Two on software, one that is not.
fn table() -> Vec<Requirement> {
    vec![row("8.3.3a", Who::Software), row("8.3.3b", Who::Software), row("5.5a", Who::Integrator)]
}

fn source(lines: &[&str]) -> Vec<Tag> {
    source_of("source.rs", lines)
}

/// Tests without a line `Notices:` count as if they had one for each requirement.
fn source_of(file: &str, lines: &[&str]) -> Vec<Tag> {
    let reading = Reading { file: file.to_owned(), is_tested: true, ..Reading::default() };
    let mut tags = tags::read(&lines.join("\n").replace("MARK", MARK), &reading).expect("Rust").tags;
    for tag in tags.iter_mut().filter(|tag| tag.noticed.is_empty()) {
        tag.noticed = tag.ids.iter().chain(&tag.of_module).cloned().collect();
    }
    tags
}

fn both() -> Vec<Tag> {
    source(&["/// A test.", "///", "MARK 8.3.3a, 8.3.3b", "#[test]", "fn heartbeats() {}"])
}

#[test]
fn a_test_notices_what_it_verifies_alone() {
    let slip = "/// Notices: ECSS";
    let tags = source(&[
        "MARK 8.3.3a, 8.3.3b",
        &format!("{slip} 8.3.3b: the slave toggles early."),
        &format!("{slip} 8.3.3c: never."),
        "#[test]",
        "fn heartbeats() {}",
    ]);
    assert_eq!(tags[0].noticed, ["8.3.3b", "8.3.3c"]);
    let expected = [
        "source.rs:1: heartbeats notices 8.3.3c, which it does not verify",
        "8.3.3a: no test that names it has a line `Notices:` for it",
    ];
    assert_eq!(check(&table(), &tags), expected);
    let summary = counts::summary(&table(), &[], &tags);
    assert!(summary.contains("2 on software (2 traced to tests, 1 of them with a violation"), "{summary}");
}

/// Given two requirements, of which the second one is tested by `cargo xtask test-all` alone.
#[test]
fn each_requirement_has_a_test_of_the_first_tier() {
    let first = ["MARK 8.3.3a", "#[test]", "fn heartbeats() {}"];
    let later = ["MARK 8.3.3a, 8.3.3b", "#[test]", "fn on_the_wire() {}"];
    let mut tags = source_of("tests/host/tests/worlds/boot.rs", &first);
    tags.extend(source_of("tests/second/tests/host/boot.rs", &later));
    assert_eq!(check(&table(), &tags), ["8.3.3b: no test of the first tier names it"]);
    let expected = "Requirements on software by number of tests: 1 with one, 1 with two, 0 with three, 0 with more; 1 have a test of the \
                    first tier (`cargo test`)";
    assert_eq!(counts::tests_per_requirement(&table(), &tags), expected);
}

/// Given a file whose own comment names a requirement. Then each of its tests verifies it, and says so no second time.
#[test]
fn a_module_may_name_what_all_of_its_tests_verify() {
    let module = MARK.replace("///", "//!") + " 8.3.3a";
    let lines = [
        "//! Bus.",
        "//!",
        &module,
        "fn helper() {}",
        "#[test]",
        "fn one() {}",
        "MARK 8.3.3b",
        "#[test]",
        "fn two() {}",
    ];
    let tags = source(&lines);
    let found: Vec<_> = tags
        .iter()
        .map(|tag| (tag.function.as_str(), tag.runs, tag.names("8.3.3a"), tag.names("8.3.3b")))
        .collect();
    assert_eq!(found, [("one", true, true, false), ("two", true, true, true)]);
    assert_eq!(check(&table()[1..2], &tags[1..]), ["source.rs:7: there is no requirement 8.3.3a"]);

    let twice = source(&[&module, "MARK 8.3.3a, 8.3.3b", "#[test]", "fn one() {}"]);
    assert_eq!(check(&table(), &twice)[0], "source.rs:2: one names 8.3.3a, as its module does already");
    let none = source(&[&module, "fn helper() {}"]);
    assert_eq!(check(&table(), &none)[0], "source.rs:1: the tag is not on a test that runs");
    // Of the module inside alone.
    let inside = source(&["mod tests {", &module, "#[test]", "fn one() {}", "}", "#[test]", "fn two() {}"]);
    assert_eq!(inside.iter().map(|tag| tag.function.as_str()).collect::<Vec<_>>(), ["one"]);
}

#[test]
fn each_requirement_on_software_and_each_tag_has_its_other_half() {
    let first = || source(&["MARK 8.3.3a", "#[test]", "fn heartbeats() {}"]);
    let strange = || [both(), source(&["", "MARK 8.3.3z", "#[test]", "fn more() {}"])].concat();
    let larger = || [table(), vec![row("8.3.3c", Who::Software)]].concat();
    for (table, tags, expected) in [
        (table(), both(), None),
        (table(), first(), Some("8.3.3b: no test names it")),
        (table(), strange(), Some("source.rs:2: there is no requirement 8.3.3z")),
        (larger(), both(), Some("8.3.3c: no test names it")),
    ] {
        assert_eq!(check(&table, &tags), Vec::from_iter(expected));
    }
}

#[test]
fn a_tag_counts_on_a_test_that_runs_alone() {
    let places: [&[&str]; 6] = [
        &["MARK 8.3.3a", "fn no_test() {}"],
        &["MARK 8.3.3a", "#[test]", "#[ignore]", "fn ignored() {}"],
        &["MARK 8.3.3a", "#[ignore = \"slow\"]", "#[test]", "fn ignored() {}"],
        &["MARK 8.3.3a", "struct Type;"],
        &["#[test]", "fn plain() {", "    // Verifies: ECSS 8.3.3a", "}"],
        &["MARK 8.3.3a", "mod tests {", "    #[test]", "    fn inside() {}", "}"],
    ];
    for lines in places {
        let tags = source(lines);
        let found = check(&table(), &tags);
        assert!(found[0].ends_with(": the tag is not on a test that runs"), "{lines:?}: {found:?}");
        assert!(found.iter().any(|found| found == "8.3.3a: no test names it"), "{lines:?}: {found:?}");
    }
}

#[test]
fn tests_in_macros_and_modules_and_of_async_functions_count() {
    let places: [&[&str]; 4] = [
        &["proptest! {", "MARK 8.3.3a, 8.3.3b", "#[test]", "fn random(value in 0..9) {}", "}"],
        &["mod tests {", "MARK 8.3.3a, 8.3.3b", "#[test]", "fn inside() {}", "}"],
        &["MARK 8.3.3a, 8.3.3b", "#[tokio::test]", "pub(crate) async fn waits() {}"],
        &["MARK 8.3.3a", "MARK 8.3.3b", "#[cfg(unix)]", "#[test]", "fn twice() {}"],
    ];
    for lines in places {
        assert_eq!(check(&table(), &source(lines)), [""; 0], "{lines:?}");
    }
}

#[test]
fn all_tags_of_a_test_and_members_of_a_range_count_for_limit() {
    let ids = |lines: &[&str]| source(lines)[0].ids.clone();
    assert_eq!(
        ids(&["MARK 7.1.3a to d", "#[test]", "fn utc() {}"]),
        ["7.1.3a", "7.1.3b", "7.1.3c", "7.1.3d"]
    );
    let tags = source(&["MARK 7.1.3a to d", "MARK 7.1.3e, 7.1.3f", "#[test]", "fn utc() {}"]);
    let rows: Vec<_> = ('a'..='f').map(|letter| row(&format!("7.1.3{letter}"), Who::Software)).collect();
    assert_eq!(check(&rows, &tags), ["source.rs:1: utc names 6 requirements, at most 5 are allowed"]);
}

#[test]
fn a_row_without_a_reason_is_found() {
    let mut table = table();
    table[2].remark.clear();
    let no = Requirement { applies: Applies::No, method: None, ..row("9.9z", Who::Integrator) };
    table.push(Requirement { remark: "we would rather not".to_owned(), ..no });
    table.push(Requirement { method: None, ..row("9.9y", Who::Integrator) });
    table.push(Requirement { applies: Applies::May, ..row("9.9x", Who::Integrator) });
    table.push(Requirement { method: Some(Method::R), ..row("8.3.3b", Who::Software) });
    table.remove(1);
    table.push(row("5.5b", Who::Board));
    table.push(row("5.5b", Who::Board));
    let expected = [
        "5.5a: not met by software, and no reason",
        "9.9z: not applicable, and the remark names no clause that permits it",
        "9.9y: a requirement that applies has a method of verification, and only such a one",
        "9.9x: a requirement that applies has a method of verification, and only such a one",
        "8.3.3b: on software, and not verified by test",
        "5.5b: it has two rows",
    ];
    assert_eq!(check(&table, &both()), expected);
}

#[test]
fn modules_are_followed_and_files_without_target_run_nothing() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let write = |name: &str, id: &str, rest: &str| {
        let file = folder.path().join(name);
        fs::create_dir_all(file.parent().expect("a folder")).expect("folders");
        let test = format!("{MARK} {id}\n#[test]\nfn of_{}() {{}}\n{rest}", id.replace('.', "_"));
        fs::write(file, test).expect("a file");
    };
    write("main.rs", "1a", "mod child;\nmod inline { mod deep; }\n#[path = \"random/x.rs\"]\nmod named;");
    write("child.rs", "2a", "mod grandchild;");
    write("child/grandchild.rs", "3a", "");
    write("inline/deep/mod.rs", "4a", "mod sibling;");
    write("inline/deep/sibling.rs", "5a", "");
    write("random/x.rs", "6a", "");
    write("forgotten.rs", "7a", "");
    write("untested.rs", "8a", "");
    let target = Target { package: "one".to_owned(), ..Target::default() };
    let of = |name, is_tested| root(&folder.path().join(name), is_tested, target.clone());
    let roots = vec![of("untested.rs", false), of("main.rs", true)];
    let found = read(roots, folder.path()).expect("Rust");
    let tests: Vec<String> = found.iter().filter(|tag| tag.target == target).map(Tag::test).collect();
    let names = ["child::of_2a", "child::grandchild::of_3a", "inline::deep::of_4a"];
    let more = ["inline::deep::sibling::of_5a", "of_1a", "named::of_6a", "of_8a"];
    assert_eq!(tests, [&names[..], &more].concat());
    let mut found: Vec<(String, bool)> =
        found.into_iter().map(|tag| (tag.ids[0].clone(), tag.runs)).collect();
    found.sort();
    let expected: Vec<_> = ('1'..='8').map(|number| (format!("{number}a"), number <= '6')).collect();
    assert_eq!(found, expected);
}

#[test]
fn the_tables_of_the_standard_are_whole() {
    // Requirements of each clause, counted in the standard.
    let expected = [("5", 80), ("6", 42), ("7", 38), ("8", 29), ("9", 44), ("10", 24), ("11", 4)];
    let requirements = requirements();
    for (clause, number) in expected {
        let found = requirements.iter().filter(|row| row.id.split('.').next() == Some(clause)).count();
        assert_eq!(found, number, "clause {clause}");
    }
    assert_eq!(requirements.len(), 261);
    let marks = ["A", "O", "NA", "R"];
    assert!(clauses().iter().all(|clause| marks.contains(&clause.applicability.as_str())));
}

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

#[test]
fn each_interpretation_names_a_requirement_and_a_page() {
    let (requirements, interpretations) = (requirements(), interpretations());
    assert_eq!(check_interpretations(&requirements, &interpretations, &docs()), [""; 0]);
    // In the order of the standard, and one sentence of a line.
    let place = |one: &Interpretation| requirements.iter().position(|row| row.id == one.id);
    assert!(interpretations.is_sorted_by_key(place));
    assert!(interpretations.iter().all(|one| one.text.split_whitespace().count() <= 25));
}

/// The errors of the standard that are known have a row each.
#[test]
fn known_errors_of_the_standard_are_interpreted() {
    let interpretations = interpretations();
    let known = [
        "6.4a", "6.5.1a.4", "6.5.1a.5", "7.1.3d", "8.3.1b", "8.3.3g", "8.3.3l", "9.3a", "9.4.4c", "9.4.7.3a",
        "11.1c",
    ];
    for id in known {
        assert!(interpretations.iter().any(|one| one.id == id), "{id}");
    }
}

fn interpretation(kind: Kind, text: &str) -> Interpretation {
    Interpretation { id: "8.3.3a".to_owned(), kind, text: text.to_owned(), page: "wiring.md".to_owned() }
}

#[test]
fn an_interpretation_without_requirement_sentence_or_page_is_found() {
    for (id, text, page, reason) in [
        ("8.3.3a", "We do so.", "wiring.md#straps", None),
        ("8.3.3z", "We do so.", "wiring.md", Some("8.3.3z: its interpretation names no requirement")),
        ("8.3.3a", "", "wiring.md", Some("8.3.3a: its interpretation is no sentence")),
        ("8.3.3a", "We do so.", "no_page.md", Some("8.3.3a: its interpretation names no page of docs")),
        ("8.3.3a", "We do so.", "", Some("8.3.3a: its interpretation names no page of docs")),
    ] {
        let (id, page) = (id.to_owned(), page.to_owned());
        let one = Interpretation { id, page, ..interpretation(Kind::Reading, text) };
        assert_eq!(check_interpretations(&table(), &[one], &docs()), Vec::from_iter(reason));
    }
}

#[test]
fn page_that_is_not_there_and_page_of_software_are_found() {
    let with = |who, page: &str| Requirement { page: page.to_owned(), ..row("5.5a", who) };
    for (row, expected) in [
        (with(Who::Board, "wiring.md#buses"), None),
        (with(Who::Board, "eds"), None),
        (with(Who::Board, "no_page.md"), Some("5.5a: its page is not in docs")),
        (with(Who::Software, "wiring.md"), Some("5.5a: on software, and with a page in place of tests")),
    ] {
        assert_eq!(check_pages(&[row], &docs()), Vec::from_iter(expected));
    }
    assert_eq!(check_pages(&requirements(), &docs()), [""; 0]);
}

#[test]
fn each_summary_names_requirements_on_software_and_says_why() {
    assert_eq!(check_summaries(&requirements(), &summaries()), [""; 0]);
}

fn summary(id: &str, clauses: &str, reason: &str) -> Summary {
    Summary { id: id.to_owned(), clauses: clauses.to_owned(), reason: reason.to_owned() }
}

#[test]
fn a_clause_is_no_part_of_one_with_a_longer_number() {
    let clause = summary("11.1a", "6.1 8.3.3a", "It does.");
    assert!(clause.has("6.1a") && clause.has("8.3.3a.1"));
    assert!(!clause.has("6.10a") && !clause.has("8.3.3b"));
}

#[test]
fn a_summary_without_requirement_clause_or_sentence_is_found() {
    for (id, clauses, reason, finding) in [
        ("8.3.3b", "8.3.3a", "It does.", None),
        ("5.5a", "8.3", "It does.", Some("5.5a: its summary names no requirement on software")),
        ("8.3.3b", "8.3", "It does.", Some("8.3.3b: its summary names the requirement itself")),
        (
            "8.3.3b",
            "8.3.3a 5.5",
            "It does.",
            Some("8.3.3b: its summary names a clause without a requirement on software"),
        ),
        ("8.3.3b", "8.3.3a", "", Some("8.3.3b: the reason of its summary is no sentence")),
    ] {
        let found = check_summaries(&table(), &[summary(id, clauses, reason)]);
        assert_eq!(found, Vec::from_iter(finding), "{id}: {clauses}");
    }
}
