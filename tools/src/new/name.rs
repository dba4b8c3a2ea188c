//! The name of a new package.

/// Longest name that a registry accepts, in characters.
const LONGEST: usize = 64;

/// Names of cargo's folders, of Rust's own crates, and of devices of Windows: cargo refuses them.
const RESERVED: [&str; 18] = [
    "alloc",
    "aux",
    "build",
    "con",
    "core",
    "deps",
    "examples",
    "incremental",
    "nul",
    "prn",
    "proc-macro",
    "proc_macro",
    "std",
    "test",
    "com1",
    "com2",
    "lpt1",
    "lpt2",
];

/// Keywords of Rust that a crate cannot have as its name.
const KEYWORDS: [&str; 52] = [
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do", "dyn",
    "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop",
    "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return", "self", "static",
    "struct", "super", "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual",
    "where", "while", "yield", "_",
];

/// Checks a name by the rules of cargo.
///
/// # Errors
/// A text with what was wrong and what is allowed.
pub(super) fn check(name: &str) -> Result<String, String> {
    let allowed = "allowed are a small letter, and then small letters, digits, - and _, such as heater";
    let is_inner =
        |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || "-_".contains(letter);
    let first = name.chars().next();
    if !first.is_some_and(|letter| letter.is_ascii_lowercase()) || !name.chars().all(is_inner) {
        return Err(allowed.into());
    }
    if name.len() > LONGEST {
        return Err(format!("it has {} characters; allowed are up to {LONGEST}", name.len()));
    }
    if KEYWORDS.contains(&name) {
        return Err(format!("it is a keyword of Rust; {allowed}"));
    }
    if RESERVED.contains(&name) {
        return Err(format!("cargo reserves it; {allowed}"));
    }
    Ok(name.to_owned())
}

/// Name of the crate in Rust.
pub(super) fn of_crate(name: &str) -> String {
    name.replace('-', "_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_by_the_rules_of_cargo_are_accepted() {
        for name in ["heater", "heater-2", "h405", "a", "my_heater"] {
            assert_eq!(check(name).as_deref(), Ok(name));
        }
        assert_eq!(of_crate("heater-2"), "heater_2");
    }

    #[test]
    fn other_names_are_refused_with_what_is_allowed() {
        for name in ["", "2heater", "Heater", "a/b", "heizgerät", "-a", "a b", "../a", "_a"] {
            assert!(check(name).unwrap_err().starts_with("allowed are"), "{name}");
        }
        assert!(check("yield").unwrap_err().contains("keyword"));
        assert!(check("test").unwrap_err().contains("reserves"));
        assert!(check(&"a".repeat(65)).unwrap_err().contains("65 characters; allowed are up to 64"));
    }
}
