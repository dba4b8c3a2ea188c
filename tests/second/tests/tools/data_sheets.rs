//! The committed EDS and DCF, read by third-party packages.

use std::path::Path;

use second::{device, script, tools};

fn is_understood(slave: &Path) {
    let slave = slave.to_str().expect("UTF-8");
    for name in ["data_sheets.py", "data_sheets_elsewhere.py"] {
        script::judge(name, &[("SLAVE_EDS", slave)]).unwrap_or_else(|failure| panic!("{failure:#}"));
    }
}

/// Verifies: ECSS 6.6a
#[test]
fn data_sheets_are_understood_by_packages_of_others() {
    is_understood(&tools::workspace().join("docs/eds/slave.eds"));
}

#[test]
fn values_of_every_type_are_understood_as_well() {
    is_understood(&device::data_sheet().expect("it is made"));
}
