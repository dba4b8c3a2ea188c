//! The text of a file: sections, lines, and what may stand in them.

use std::fmt::{Display, Write};

use crate::Error;

/// Most characters of a text: a line has 255, and the longest keyword takes its share (CiA 306 4.2).
pub const LINE: usize = 241;

/// A file in the making.
#[derive(Default)]
pub struct File(String);

impl File {
    /// Begins a section.
    pub fn section(&mut self, name: impl Display) {
        let before = if self.0.is_empty() { "" } else { "\n" };
        self.line(format_args!("{before}[{name}]"));
    }

    /// A keyword and its value.
    pub fn set(&mut self, keyword: impl Display, value: impl Display) {
        self.line(format_args!("{keyword}={value}"));
    }

    /// The same for a yes or no.
    pub fn flag(&mut self, keyword: impl Display, value: bool) {
        self.set(keyword, u8::from(value));
    }

    /// The file.
    pub fn into_text(self) -> String {
        self.0
    }

    fn line(&mut self, line: impl Display) {
        writeln!(self.0, "{line}").expect("a String takes everything");
    }
}

/// Whether every reader takes a text for what it is. A semicolon and a number sign begin a comment, a backslash escapes what
/// follows it or continues the line, quotation marks and blanks at the ends are cut off.
///
/// # Errors
/// [`Error::Text`].
pub fn checked(text: &str) -> Result<(), Error> {
    let is_plain = |byte| matches!(byte, b' '..=b'~') && !matches!(byte, b';' | b'#' | b'\\');
    let plain = text.bytes().all(is_plain) && !text.starts_with(['"', '\'', '`']);
    let whole = text.trim() == text && text.len() <= LINE;
    if plain && whole { Ok(()) } else { Err(Error::Text { text: text.into() }) }
}
