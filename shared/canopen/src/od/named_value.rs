//! Names of the values of an enumeration, for EDS and DCF.

/// Value of an enumeration. Images do not have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NamedValue {
    /// Number that SDOs and PDOs carry.
    pub number: i64,
    /// Name of its variant.
    pub name: &'static str,
}
