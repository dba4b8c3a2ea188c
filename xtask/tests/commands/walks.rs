//! The walks through the code in docs/architecture.md.

use std::fs;

use ecss_can_cli::images::support::project;

/// Rows of the tables with a file and a function: `| node | `file` | `function` |`.
fn steps(page: &str) -> impl Iterator<Item = (&str, &str)> {
    page.lines().filter_map(|line| {
        let mut cells = line.split('|').map(|cell| cell.trim().trim_matches('`')).skip(2);
        let cells = (cells.next()?, cells.next()?);
        cells.0.ends_with(".rs").then_some(cells)
    })
}

#[test]
fn every_function_of_a_walk_is_in_its_file() {
    let page = fs::read_to_string(project::path("docs/architecture.md")).expect("a page");
    let steps: Vec<_> = steps(&page).collect();
    assert!(steps.len() > 30, "{} steps", steps.len());
    let missing: Vec<_> = steps
        .into_iter()
        .filter(|(file, function)| {
            let source = fs::read_to_string(project::path(file)).unwrap_or_default();
            !["(", "<"].iter().any(|next| source.contains(&format!("fn {function}{next}")))
        })
        .collect();
    assert!(missing.is_empty(), "mend the walks: {missing:#?}");
}
