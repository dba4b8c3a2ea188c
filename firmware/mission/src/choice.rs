//! Features that exclude each other: an image has one profile and one bit rate.

/// Refuses any two of these features together.
macro_rules! at_most_one {
    ($of:literal: $first:literal $(, $other:literal)*) => {
        $(
            #[cfg(all(feature = $first, feature = $other))]
            compile_error!(concat!("features `", $first, "` and `", $other, "` are two ", $of, ": choose one"));
        )*
        at_most_one!($of: $($other),*);
    };
    ($of:literal:) => {};
}

at_most_one!("profiles": "librecube", "standby");
at_most_one!("bit rates": "kbit-10", "kbit-20", "kbit-50", "kbit-125", "kbit-250", "kbit-500");
