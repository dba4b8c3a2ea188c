//! Rows as text.

use console::style;
use serde_json::Number;

use super::row::{Better, Row};

/// Returns all rows of an area, one line each.
pub fn lines(area: &str, rows: &[Row]) -> Vec<String> {
    rows.iter().map(|row| line(area, row)).collect()
}

fn line(area: &str, row: &Row) -> String {
    let target = row.target.as_ref().map_or(String::new(), |target| {
        let bound = if row.better == Better::Lower { "at most" } else { "at least" };
        format!("{bound} {}", number(target))
    });
    let verdict = match row.holds {
        Some(true) => style("holds").green().to_string(),
        Some(false) => style("DOES NOT HOLD").red().bold().to_string(),
        None if row.noisy => "noisy".into(),
        None => String::new(),
    };
    let name = format!("{area}.{}", row.name);
    let line = format!("{name:<42} {:>12} {:<24} {target:<18} {verdict}", number(&row.value), row.unit);
    line.trim_end().to_owned()
}

/// Returns a number with spaces between groups of three digits.
pub fn number(number: &Number) -> String {
    grouped(&number.to_string(), ' ')
}

/// Puts `separator` between groups of three digits.
pub fn grouped(number: &str, separator: char) -> String {
    let (whole, rest) = number.split_at(number.find('.').unwrap_or(number.len()));
    let (sign, digits) = whole.split_at(usize::from(whole.starts_with('-')));
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            grouped.push(separator);
        }
        grouped.push(digit);
    }
    format!("{sign}{grouped}{rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped() {
        let grouped = |text: &str| number(&serde_json::from_str(text).unwrap());
        assert_eq!(
            ["0", "999", "1000", "-1234567", "12345.678"].map(grouped),
            ["0", "999", "1 000", "-1 234 567", "12 345.678"]
        );
    }

    #[test]
    fn a_target_that_does_not_hold_stands_out() {
        let row = Row::lower("slave.ram", 20_000, "bytes").within(16_384);
        let line = line("size", &row);
        let words: Vec<_> = line.split_whitespace().collect();
        assert_eq!(words[0], "size.slave.ram");
        assert!(line.contains("20 000 bytes") && line.contains("at most 16 384"), "{line}");
        assert!(line.contains("DOES NOT HOLD"), "{line}");
    }
}
