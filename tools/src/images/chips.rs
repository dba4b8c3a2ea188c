//! Chip support, checked for a chip of each line, and slaves on the drivers of embassy-stm32.

use std::process::Command;

use crate::images::{Error, Job, LOG, TARGET, output, run, workspace};

/// Chip support.
const PACKAGE: &str = "ecss-can-stm32f4";

/// A chip of each line that `ecss-can-stm32f4` supports, as embassy-stm32 names it.
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

/// Chips that are compiled: the largest of each family. The other chips of its family have the same registers and fewer peripherals:
/// no CRYP and HASH (F40x, F42x, F469), no Ethernet and DCMI (F405), no LTDC (F427).
const COMPILED: [&str; 4] = ["stm32f417vg", "stm32f439zi", "stm32f446re", "stm32f479ni"];

/// Slaves on the CAN drivers of embassy-stm32, and the boards that they compile for: two with FDCAN, one with bxCAN.
pub(in crate::images) const ON_EMBASSY: &str = "embassy-slave";
const BOARDS_ON_EMBASSY: [&str; 3] = ["nucleo-g474re", "nucleo-h743zi", "pyboard-v11"];

/// Package of the CANopen slave, also compiled for a target without compare-and-swap: Cortex-M0.
const CANOPEN: &str = "async-canopen";
const SMALLEST: &str = "thumbv6m-none-eabi";

/// Checks that embassy-stm32 has each of [`CHIPS`], and that chip support compiles for one of each family, with all of its features.
/// Also that the slaves on the drivers of embassy-stm32 compile, and `async-canopen` for a Cortex-M0.
///
/// # Errors
/// See [`Error`].
pub fn check_chips() -> Result<(), Error> {
    let root = workspace();
    // Cargo only resolves the features, because chips exclude each other when they are compiled.
    let mut tree = Command::new("cargo");
    tree.current_dir(&root).args(["tree", "--locked", "--quiet", "--depth", "0", "--target", TARGET]);
    tree.args(["--package", PACKAGE, "--features", &features(&CHIPS)]);
    let (line, resolved) = output(&mut tree)?;
    if !resolved.status.success() {
        return Err(Error::Failed(line, resolved.status));
    }
    let check = |what: &str, package: &str, features: &str, rest: &[&str]| {
        let job = Job {
            home: &root,
            prepare: &|| Ok(()),
            task: format!("check {what}"),
            log: LOG,
            is_locked: true,
        };
        let what = ["--package", package, "--features", features].map(str::to_owned);
        job.run(&["check"], &what, rest, run)
    };
    for chip in COMPILED {
        check(&format!("chip support for {chip}"), PACKAGE, &features(&[chip]), &[])?;
    }
    for board in BOARDS_ON_EMBASSY {
        check(&format!("a slave for {board}"), ON_EMBASSY, &format!("{ON_EMBASSY}/{board}"), &[])?;
    }
    check("a slave for Cortex-M0", CANOPEN, "critical-section,defmt", &["--target", SMALLEST])
}

/// All features of chip support, for some chips.
fn features(chips: &[&str]) -> String {
    let chips: Vec<_> = chips.iter().map(|chip| format!("embassy-stm32/{chip}")).collect();
    format!("defmt,{}", chips.join(","))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use ecss_can_memory::Chip;

    use super::*;

    /// Each chip is supported, and no line is missing.
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

    #[test]
    fn compiled_chips_are_among_the_checked_ones() {
        assert!(COMPILED.iter().all(|chip| CHIPS.contains(chip)));
    }
}
