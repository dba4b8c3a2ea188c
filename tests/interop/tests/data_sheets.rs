//! The committed EDS and DCF, read by a package that others wrote.

use std::path::Path;

use interop::script;

/// Verifies: ECSS 6.6a
#[test]
fn data_sheets_are_understood_by_the_canopen_package() {
    let directory =
        Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).map(|root| root.join("docs/eds"));
    let directory = directory.expect("the root of the workspace");
    script::judge("data_sheets.py", &[("DATA_SHEETS", directory.to_str().expect("UTF-8"))])
        .unwrap_or_else(|failure| panic!("{failure:#}"));
}
