//! A value in three copies, of which two have to agree.

/// Corrects the one of three copies that differs from the two others. If all three differ, the first one is taken. Returns
/// whether one differed.
pub fn correct<T: Copy + PartialEq>(copies: [&mut T; 3]) -> bool {
    let [first, second, third] = copies;
    let wrong = match (first == second, second == third) {
        (true, true) => return false,
        (true, false) => (third, *first),
        (false, true) => (first, *second),
        (false, false) => {
            *third = *first;
            (second, *first)
        }
    };
    *wrong.0 = wrong.1;
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALUE: u32 = 0x1357_9BDF;

    /// Given three copies of a value, when any bit of one flips, then it is corrected. No copy of three equal ones is.
    #[test]
    fn a_flipped_bit_of_three_copies_is_corrected() {
        for (copy, bit) in (0..3).flat_map(|copy| (0..32).map(move |bit| (copy, bit))) {
            let mut copies = [VALUE; 3];
            copies[copy] ^= 1 << bit;
            for is_wrong in [true, false] {
                assert_eq!(correct(copies.each_mut()), is_wrong, "copy {copy}, bit {bit}");
                assert_eq!(copies, [VALUE; 3]);
            }
        }
    }

    /// Given three copies that all differ, then all become the first one.
    #[test]
    fn without_a_majority_the_first_copy_counts() {
        let mut copies = [VALUE, VALUE ^ 1, VALUE ^ 2];
        assert!(correct(copies.each_mut()));
        assert_eq!(copies, [VALUE; 3]);
    }
}
