//! The committed EDS and DCF, read by a package that others wrote.

use std::path::Path;

use interop::{device, script, tools};

fn is_understood(slave: &Path) {
    let slave = slave.to_str().expect("UTF-8");
    script::judge("data_sheets.py", &[("SLAVE_EDS", slave)]).unwrap_or_else(|failure| panic!("{failure:#}"));
}

/// Verifies: ECSS 6.6a
#[test]
fn data_sheets_are_understood_by_the_canopen_package() {
    is_understood(&tools::workspace().join("docs/eds/slave.eds"));
}

#[test]
fn values_of_every_type_are_understood_as_well() {
    is_understood(&device::data_sheet().expect("it is made"));
}
