//! Chip support, compiled for a chip of each line.

use crate::{Error, Job, LOG, run, workspace};

/// A chip of each line that `boards-stm32f4` supports, as embassy-stm32 names it.
pub const CHIPS: [&str; 11] = [
    "stm32f405rg",
    "stm32f407vg",
    "stm32f415rg",
    "stm32f417vg",
    "stm32f427vi",
    "stm32f429zi",
    "stm32f437vi",
    "stm32f439zi",
    "stm32f446re",
    "stm32f469ni",
    "stm32f479ni",
];

/// Checks that chip support compiles for each of [`CHIPS`], with all of its features.
///
/// # Errors
/// See [`Error`].
pub fn check_chips() -> Result<(), Error> {
    let root = workspace();
    for chip in CHIPS {
        let task = format!("check chip support for {chip}");
        let job = Job { home: &root, task, log: LOG, is_locked: true };
        let features = format!("defmt,embassy-stm32/{chip}");
        let what = ["--package", "boards-stm32f4", "--features", &features].map(str::to_owned);
        job.run(&["check"], &what, &[], run)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use boards_memory::Chip;

    use super::*;

    /// Each chip is supported, and no line is forgotten.
    #[test]
    fn chips_are_one_of_each_supported_line() {
        let checked: BTreeSet<_> = CHIPS.iter().map(|chip| &chip[6..9]).collect();
        assert_eq!(checked.len(), CHIPS.len());
        let supported: BTreeSet<_> = (400..500)
            .map(|line| line.to_string())
            .filter(|line| {
                Chip::named(&format!("stm32f{line}vg")).is_ok()
                    || Chip::named(&format!("stm32f{line}ve")).is_ok()
            })
            .collect();
        assert_eq!(checked, supported.iter().map(String::as_str).collect());
    }
}
