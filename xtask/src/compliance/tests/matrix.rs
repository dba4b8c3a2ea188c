//! What stands on the page, and Table 11-1.

use super::*;

/// Given a requirement with a reading and a deviation. Then each stands in the table of its kind, the row of the requirement links to both
/// and is partly compliant, and the summary counts both.
#[test]
fn interpretations_stand_in_the_table_of_their_kind() {
    let interpretations =
        [interpretation(Kind::Reading, "We take it so."), interpretation(Kind::Deviation, "We do not.")];
    let page = page::write(&table(), &interpretations, &[], &[], &both());
    let part = |from: &str| page.split(from).nth(1).expect(from).split("\n## ").next().unwrap_or_default();
    assert!(part("\n## Deviations").ends_with("| 8.3.3a | We do not. | [page](wiring.md) |\n"), "{page}");
    assert!(part("\n## Extensions").ends_with("| --- | --- | --- |\n"), "{page}");
    assert!(part("\n## Readings").ends_with("| 8.3.3a | We take it so. | [page](wiring.md) |\n"), "{page}");
    let row = "| 8.3.3a | a rule | software | yes | P | T | [heartbeats](../source.rs) | [deviation](#deviations)<br>[reading](#readings) |";
    assert!(page.contains(row), "{page}");
    let summary = counts::summary(&table(), &interpretations, &both());
    let end =
        "1 compliant, 1 partly, 0 not, 1 open; 1 with a deviation, 0 with an extension, 1 with a reading";
    assert!(summary.ends_with(end), "{summary}");
}

/// Given requirements that apply, do not apply, or are permissions. Then the row has the status and the method of those that apply.
#[test]
fn rows_have_status_and_method_if_they_apply() {
    let other = |applies, id| Requirement { applies, method: None, ..row(id, Who::Board) };
    let mut table = [table(), vec![other(Applies::No, "5.6a"), other(Applies::May, "5.7a")]].concat();
    table[2].page = "wiring.md#buses".to_owned();
    let page = page::write(&table, &[], &[], &[], &both());
    for row in [
        "| 8.3.3a | a rule | software | yes | C | T | [heartbeats](../source.rs) |  |",
        "| 5.5a | a rule | integrator | yes | open | I | [wiring.md#buses](wiring.md#buses) |  |",
        "| 5.6a | a rule | board | no |  |  |  |  |",
        "| 5.7a | a rule | board | may |  |  |  |  |",
        "| 5 | 0 | 0 | 0 | 1 | 1 | 1 |",
        "| 8 | 2 | 0 | 0 | 0 | 0 | 0 |",
    ] {
        assert!(page.contains(row), "{row}: {page}");
    }
    let untested = page::write(&table, &[], &[], &[], &[]);
    assert!(untested.contains("| 8.3.3a | a rule | software | yes | N | T |  |  |"), "{untested}");
}

/// Given Table 11-1, then the page has each of its sections with its mark, also those for reference.
///
/// Verifies: ECSS 11.1d
/// Notices: ECSS 11.1d: the page marks sections for reference as optional.
#[test]
fn sections_of_table_11_1_stand_on_the_page_with_their_marks() {
    let page = page::write(&table(), &[], &[], &clauses(), &[]);
    for row in [
        "| 7.2.4.2 | SDO services | O |",
        "| 7.2.6 | TIME | NA |",
        "| 7.3.5 | Restricted CAN identifiers | R |",
        "| 7.4 | Object dictionary | A |",
    ] {
        assert!(page.contains(row), "{row}");
    }
}

/// Given a requirement that sums up another one, then the page says so behind its own tests.
#[test]
fn a_summary_stands_behind_the_tests_of_its_requirement() {
    let page = page::write(&table(), &[], &[summary("8.3.3b", "8.3.3a 5.6", "It does.")], &[], &both());
    let row = "| 8.3.3b | a rule | software | yes | C | T | [heartbeats](../source.rs)<br>*and the tests of 8.3.3a, 5.6: It does.* |";
    assert!(page.contains(row), "{page}");
}

/// Sections that Table 11-1 does not mark with A, by its marks. The standard leaves the cells of 7.4.2 to 7.4.6 and of 7.4.8.5 empty.
const MARKS: [(&str, &[&str]); 3] = [
    (
        "NA",
        &[
            "5.3",
            "7.1.1",
            "7.2.2.3",
            "7.2.2.4.3",
            "7.2.2.5.2",
            "7.2.3",
            "7.2.4.3.16",
            "7.2.6",
            "7.2.6.2",
            "7.2.6.3",
            "7.2.7",
            "7.2.8.2.2.1",
            "7.2.8.2.2.2",
            "7.2.8.3.2.1",
            "7.3.1",
            "7.4.8.5",
        ],
    ),
    ("O", &["7.2.4", "7.2.4.2", "7.3.2.2.5", "7.4.8"]),
    ("R", &["3", "4", "7.1.2", "7.3.4", "7.3.5", "7.4.1", "7.4.2 to 6", "7.4.7", "7.4.7.2", "7.5.2"]),
];

/// Given our copy of Table 11-1, then no section has another mark than in the standard.
///
/// Verifies: ECSS 11.1a, 11.1b, 11.1c, 11.1d
/// Notices: ECSS 11.1d: section 7.3.5, for reference, has another mark in our table.
#[test]
fn sections_have_the_marks_of_table_11_1() {
    let clauses = clauses();
    let sections = |mark: &str| {
        let marked = clauses.iter().filter(|clause| clause.applicability == mark);
        marked.map(|clause| clause.section.as_str()).collect::<Vec<_>>()
    };
    for (mark, expected) in MARKS {
        assert_eq!(sections(mark), expected, "{mark}");
    }
    assert_eq!(sections("A").len(), 54);
}

/// Given Table 11-1, then what applies is there or has a reason why not, what is not used but there has a reason, and what is for
/// reference needs no answer.
///
/// Verifies: ECSS 11.1a, 11.1b, 11.1c, 11.1d
#[test]
fn sections_of_table_11_1_are_answered_by_their_marks() {
    for clause in clauses() {
        let is_absent =
            clause.ours == "no" || clause.ours.starts_with("no,") || clause.ours.starts_with("no;");
        let is_used = ["yes", "sent", "checked"].iter().any(|word| clause.ours.starts_with(word));
        let is_right = match clause.applicability.as_str() {
            "A" => !clause.ours.is_empty() && (!is_absent || !clause.reason.is_empty()),
            "O" => !clause.ours.is_empty(),
            "NA" => !clause.ours.is_empty() && (!is_used || !clause.reason.is_empty()),
            _ => clause.reason.is_empty(),
        };
        assert!(is_right, "{clause:?}");
    }
}
