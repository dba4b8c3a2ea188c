//! A table of constants that no flipped bit in memory moves or extends.

use core::ptr;

/// A reference to a table of constants, in three copies: it is the table that two of them name.
///
/// ```
/// use async_canopen::types::Table;
///
/// let table = Table::of(&[2, 3, 5]);
/// assert_eq!(table.get(), [2, 3, 5]);
/// ```
#[derive(Debug)]
pub struct Table<T: 'static>([&'static [T]; 3]);

impl<T> Clone for Table<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Table<T> {}

impl<T> Table<T> {
    /// Makes the reference.
    pub const fn of(table: &'static [T]) -> Table<T> {
        Table([table; 3])
    }

    /// Returns the table.
    pub fn get(&self) -> &'static [T] {
        let [first, second, third] = self.0;
        // Place and length: a wrong one must not be read.
        if ptr::eq(first, second) { first } else { third }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: &[u8] = &[2, 3, 5];

    /// Given a table, when one of its copies has another length or another place, then it is what it was.
    #[test]
    fn a_copy_that_differs_is_not_read() {
        for wrong in [&NUMBERS[..2], &NUMBERS[1..], &[]] {
            for copy in 0..3 {
                let mut table = Table::of(NUMBERS);
                table.0[copy] = wrong;
                assert_eq!(table.get(), NUMBERS, "copy {copy}");
            }
        }
    }
}
