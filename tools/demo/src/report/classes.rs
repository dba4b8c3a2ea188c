//! Colours and letters of a flight's pictures, by class.

use crate::drawing::paint::{BASE, Sheet};

/// Classes of the pictures of a flight.
pub const SHEETS: &[Sheet] = &[
    BASE,
    "
active { fill: #e3edf9 / #1d2f47 }
bus-nominal { fill: #2563b0 / #6aa9f0; font-size: 15; font-weight: bold }
bus-redundant { fill: #8b3fa8 / #cf8fe8; font-size: 15; font-weight: bold }
cut-label { fill: #c4232f / #ff6b6b; font-weight: bold }
switch-label { fill: #8b3fa8 / #cf8fe8; font-weight: bold }
in-bar { fill: #13251b / #07130c; font-size: 12 }
cut { stroke: #c4232f / #ff6b6b; stroke-width: 2; stroke-dasharray: 5,3 }
switch { stroke: #8b3fa8 / #cf8fe8; stroke-width: 2 }
phase-off { fill: #eaecf0 / #242b35 }
phase-starting { fill: #c3c9d3 / #475264 }
phase-standby { fill: #9db8e6 / #3f5f96 }
phase-pre-operational { fill: #f2b84b / #d99c2b }
phase-operational { fill: #5bb381 / #3f9c69 }
phase-stopped { fill: #e0705f / #c95a4b }
phase-silent { fill: #a03b5c / #8a3350 }
on-nominal { fill: #2563b0 / #6aa9f0 }
on-redundant { fill: #8b3fa8 / #cf8fe8 }
",
];
