//! Names of constants from names of objects.

use std::collections::{HashMap, HashSet};

use super::values::Value;

/// Returns the names of the constants of these values. Names that occur twice, and `reserved` ones, end with the index.
pub fn of(values: &[Value], reserved: HashSet<String>) -> Vec<String> {
    let short: Vec<String> = values.iter().map(|value| screaming(&value.title)).collect();
    let mut is_long: Vec<bool> =
        short.iter().map(|name| name.is_empty() || reserved.contains(name)).collect();
    loop {
        let full = |nth: usize| {
            if is_long[nth] { format!("{}{}", short[nth], values[nth].suffix()) } else { short[nth].clone() }
        };
        let names: Vec<String> = (0..values.len()).map(full).collect();
        let mut counts = HashMap::new();
        names.iter().for_each(|name| *counts.entry(name).or_insert(0) += 1);
        // A name with its index may be that of another object without it.
        let doubled: Vec<usize> =
            (0..values.len()).filter(|nth| !is_long[*nth] && counts[&names[*nth]] > 1).collect();
        if doubled.is_empty() {
            return names;
        }
        doubled.into_iter().for_each(|nth| is_long[nth] = true);
    }
}

/// Returns a name in capitals. Other characters than ASCII letters and digits are an underscore between words, and a capital behind a
/// small letter begins a word.
pub fn screaming(title: &str) -> String {
    let (mut name, mut was_small) = (String::new(), false);
    for letter in title.chars() {
        let is_part = letter.is_ascii_alphanumeric();
        let begins = !is_part || was_small && letter.is_ascii_uppercase();
        if begins && !name.is_empty() && !name.ends_with('_') {
            name.push('_');
        }
        if is_part {
            name.push(letter.to_ascii_uppercase());
        }
        was_small = letter.is_ascii_lowercase();
    }
    let name = name.trim_end_matches('_');
    if name.starts_with(|first: char| first.is_ascii_digit()) { format!("_{name}") } else { name.to_owned() }
}
