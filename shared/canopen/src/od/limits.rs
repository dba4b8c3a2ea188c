//! Limits of a number in the dictionary.

use super::DataType;
use super::reason::Reason;
use crate::types::AbortCode;

/// Least and greatest value of a number. Both are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// `i64::MIN` for none.
    low: i64,
    /// `i64::MAX` for none.
    high: i64,
}

impl Limits {
    /// Makes limits. `None`: the type alone limits that side.
    pub const fn new(low: Option<i64>, high: Option<i64>) -> Limits {
        let low = if let Some(low) = low { low } else { i64::MIN };
        Limits { low, high: if let Some(high) = high { high } else { i64::MAX } }
    }

    /// Returns the least value, if there is one.
    pub fn low(&self) -> Option<i64> {
        (self.low != i64::MIN).then_some(self.low)
    }

    /// Returns the greatest value, if there is one.
    pub fn high(&self) -> Option<i64> {
        (self.high != i64::MAX).then_some(self.high)
    }

    /// Stops the build if `low` is above `high`, or if one of them is no value of the type.
    #[track_caller]
    pub(super) const fn assert_fit(&self, data_type: DataType) {
        if self.low > self.high {
            let low = Reason::new("`low = ").integer(self.low as i128).text("` is above `high = ");
            low.integer(self.high as i128).text("`: no value is allowed").refuse();
        }
        let (least, greatest) = range(data_type);
        let misfit = if self.low != i64::MIN && is_outside(self.low, least, greatest) {
            ("`low = ", self.low)
        } else if self.high != i64::MAX && is_outside(self.high, least, greatest) {
            ("`high = ", self.high)
        } else {
            return;
        };
        let limit = Reason::new(misfit.0).integer(misfit.1 as i128);
        let allowed = limit.text("` is no value of the type: it has ").integer(least);
        allowed.text(" to ").integer(greatest).refuse();
    }

    /// Stops the build if this number, of a value at power-on, is outside the limits.
    #[track_caller]
    pub(super) const fn assert_default(&self, number: i128) {
        let default = Reason::new("default ").integer(number);
        if number < self.low as i128 {
            default.text(" is below `low = ").integer(self.low as i128).text("`").refuse();
        }
        if number > self.high as i128 {
            default.text(" is above `high = ").integer(self.high as i128).text("`").refuse();
        }
    }

    /// Checks the number in the low bits of `bits`, as many as the type has.
    ///
    /// # Errors
    /// [`AbortCode::ValueTooHigh`], [`AbortCode::ValueTooLow`].
    pub fn check(&self, data_type: DataType, bits: u64) -> Result<(), AbortCode> {
        // The uppermost bit of the type: one shift of 64 bits, which is a call on a chip of 32, is enough.
        let top = 1_u64.wrapping_shl(u32::from(data_type.bits().unwrap_or(64)).wrapping_sub(1));
        let number = bits & top.wrapping_mul(2).wrapping_sub(1);
        let number = if data_type.is_signed() {
            (number ^ top).wrapping_sub(top).cast_signed()
        } else {
            number.min(i64::MAX as u64).cast_signed()
        };
        if number > self.high {
            Err(AbortCode::ValueTooHigh)
        } else if number < self.low {
            Err(AbortCode::ValueTooLow)
        } else {
            Ok(())
        }
    }
}

/// Least and greatest value of an integer type.
const fn range(data_type: DataType) -> (i128, i128) {
    let bits = match data_type.bits() {
        Some(bits) => bits as u32,
        None => 64,
    };
    if data_type.is_signed() { (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) } else { (0, (1 << bits) - 1) }
}

const fn is_outside(limit: i64, least: i128, greatest: i128) -> bool {
    (limit as i128) < least || (limit as i128) > greatest
}
