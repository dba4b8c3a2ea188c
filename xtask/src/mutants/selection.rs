//! Tells cargo-mutants which mutants are meant.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use super::sample::Mutant;

/// The regular expression of one name.
pub fn expression(name: &str) -> String {
    let mut text = String::from("^");
    for char in name.chars() {
        if r"\.+*?()|[]{}^$#&-~".contains(char) {
            text.push('\\');
        }
        text.push(char);
    }
    text + "$"
}

/// A diff that adds the lines of `mutants`, for `--in-diff`.
///
/// Expressions select no mutant that deletes a field of a struct: cargo-mutants 27.1 takes all of those. It takes the lines of
/// a diff for every kind.
///
/// # Errors
/// Of `read`, which gives the text of a file.
pub fn diff<E>(mutants: &[Mutant<'_>], mut read: impl FnMut(&str) -> Result<String, E>) -> Result<String, E> {
    let mut lines: BTreeMap<&str, BTreeSet<usize>> = BTreeMap::new();
    for mutant in mutants {
        lines.entry(mutant.file).or_default().insert(mutant.line);
    }
    let mut diff = String::new();
    for (file, lines) in lines {
        let text = read(file)?;
        let text: Vec<_> = text.lines().collect();
        let _ = writeln!(diff, "--- a/{file}\n+++ b/{file}");
        for (added, line) in lines.into_iter().enumerate() {
            let before = line.saturating_sub(added + 1);
            let content = line.checked_sub(1).and_then(|at| text.get(at)).unwrap_or(&"");
            let _ = writeln!(diff, "@@ -{before},0 +{line},1 @@\n+{content}");
        }
    }
    Ok(diff)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expression_means_one_name() {
        assert_eq!(
            expression("a.rs:1:2: replace + with | in F<T>"),
            r"^a\.rs:1:2: replace \+ with \| in F<T>$"
        );
    }

    #[test]
    fn the_diff_adds_the_lines_in_their_order() {
        let names = ["b.rs:2:1: delete ! in f", "a.rs:3:1: x", "a.rs:1:5: y", "a.rs:3:7: z"];
        let mutants: Vec<_> = names.iter().map(|name| Mutant::read(name).expect("a mutant")).collect();
        let diff = diff(&mutants, |file| Ok::<_, ()>(format!("{file} one\ntwo\nthree\n")));
        let expected = "--- a/a.rs\n+++ b/a.rs\n@@ -0,0 +1,1 @@\n+a.rs one\n@@ -1,0 +3,1 @@\n+three\n\
                        --- a/b.rs\n+++ b/b.rs\n@@ -1,0 +2,1 @@\n+two\n";
        assert_eq!(diff.as_deref(), Ok(expected));
    }
}
