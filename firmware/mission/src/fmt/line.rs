//! A message of defmt as text.

use core::fmt::{Debug, Display, Formatter, Result};

/// A message with placeholders of defmt, and its values.
pub struct Line<'a> {
    /// `{}`, `{=u8}` or `{=u16:04X}` for each value.
    pub message: &'a str,
    /// One for each placeholder.
    pub values: &'a [&'a dyn Debug],
}

impl Display for Line<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let mut rest = self.message;
        for value in self.values {
            let Some((text, behind)) = rest.split_once('{') else { break };
            let (placeholder, behind) = behind.split_once('}').unwrap_or((behind, ""));
            f.write_str(text)?;
            match hexadecimal_width(placeholder) {
                Some(width) => write!(f, "{value:0width$X?}")?,
                None => write!(f, "{value:?}")?,
            }
            rest = behind;
        }
        f.write_str(rest)
    }
}

/// Width of a placeholder like `=u16:04X`. `None`: decimal.
fn hexadecimal_width(placeholder: &str) -> Option<usize> {
    placeholder.split_once(':')?.1.strip_suffix('X')?.parse().ok()
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::string::ToString;

    use super::*;

    /// Given placeholders with and without type and width, when a message is written, then numbers have the width and base of their
    /// placeholder, and the text around them stays.
    #[test]
    fn message_of_defmt_is_text_with_its_values() {
        let written = |message, values: &[&dyn Debug]| Line { message, values }.to_string();
        assert_eq!(written("no values", &[]), "no values");
        assert_eq!(written("unknown command {=u16:04X}h", &[&0x1A_u16]), "unknown command 001Ah");
        assert_eq!(written("{}: yields {=bool}", &[&Some(3), &true]), "Some(3): yields true");
        assert_eq!(written("{=[u8; 2]:02X}.", &[&[10_u8, 255]]), "[0A, FF].");
    }

    #[test]
    fn a_message_with_fewer_values_keeps_its_placeholders() {
        assert_eq!(Line { message: "{} and {}", values: &[&1] }.to_string(), "1 and {}");
    }
}
