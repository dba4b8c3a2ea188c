//! Log messages of the applications: by defmt with the feature `defmt`, else by `log`.
//!
//! The macros `error`, `warn`, `info` and `debug` take a message in the format of defmt (`{}`, `{=u8}` or `{=u16:04X}`
//! for a value), followed by the values. A crate that uses them with the feature `defmt` depends on defmt. On the host
//! the type of a value is ignored, and each value is written by its `Debug`.
//!
//! ```
//! mission::warn!("unknown command {=u16:04X}h", 0x12_u16);
//! ```

#[cfg(not(feature = "defmt"))]
mod line;

#[cfg(not(feature = "defmt"))]
#[doc(hidden)]
pub use {line::Line, log};

/// Logs a message of level error.
#[macro_export]
macro_rules! error {
    ($($message:tt)*) => { $crate::__message!(error, $($message)*) };
}

/// Logs a message of level warning.
#[macro_export]
macro_rules! warn {
    ($($message:tt)*) => { $crate::__message!(warn, $($message)*) };
}

/// Logs a message of level info.
#[macro_export]
macro_rules! info {
    ($($message:tt)*) => { $crate::__message!(info, $($message)*) };
}

/// Logs a message of level debug.
#[macro_export]
macro_rules! debug {
    ($($message:tt)*) => { $crate::__message!(debug, $($message)*) };
}

#[cfg(feature = "defmt")]
#[doc(hidden)]
#[macro_export]
macro_rules! __message {
    ($level:ident, $($message:tt)*) => { ::defmt::$level!($($message)*) };
}

#[cfg(not(feature = "defmt"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __message {
    ($level:ident, $message:literal $(, $value:expr)* $(,)?) => {
        $crate::fmt::log::$level!("{}", $crate::fmt::Line { message: $message, values: &[$(&$value),*] })
    };
}
