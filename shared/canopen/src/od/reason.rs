//! Texts of errors that the compiler shows. Constants build them from numbers and words.

/// Bytes of a text.
const LEN: usize = 240;

/// Text of an error that a constant builds, at most 240 bytes. The rest is cut off.
#[derive(Clone, Copy, Debug)]
pub struct Reason {
    bytes: [u8; LEN],
    len: usize,
}

impl Reason {
    /// Makes a text that begins with these words.
    pub const fn new(text: &str) -> Reason {
        Reason { bytes: [0; LEN], len: 0 }.text(text)
    }

    /// Adds words to the text.
    pub const fn text(mut self, text: &str) -> Reason {
        let (bytes, mut nth) = (text.as_bytes(), 0);
        while nth < bytes.len() && self.len < LEN {
            self.bytes[self.len] = bytes[nth];
            (self.len, nth) = (self.len + 1, nth + 1);
        }
        self
    }

    /// Adds another text.
    pub const fn with(self, other: Reason) -> Reason {
        let (text, _) = other.bytes.split_at(other.len);
        match core::str::from_utf8(text) {
            Ok(text) => self.text(text),
            Err(_) => self,
        }
    }

    /// Adds the lowest `digits` digits of a number in hexadecimal, in the form of the standards: `1017h`.
    pub(crate) const fn hex(mut self, number: u16, digits: u32) -> Reason {
        let mut digit = digits;
        while digit > 0 && self.len < LEN {
            digit -= 1;
            self.bytes[self.len] = b"0123456789ABCDEF"[(number >> (4 * digit) & 0xF) as usize];
            self.len += 1;
        }
        self.text("h")
    }

    /// Adds a number in decimal.
    pub const fn number(self, number: u32) -> Reason {
        self.integer(number as i128)
    }

    /// Adds a number of up to 64 bits in decimal, with its sign.
    pub const fn integer(self, number: i128) -> Reason {
        let mut text = if number < 0 { self.text("-") } else { self };
        let number = number.unsigned_abs();
        let mut power = 1;
        while number / power >= 10 {
            power *= 10;
        }
        while power > 0 && text.len < LEN {
            text.bytes[text.len] = b'0' + (number / power % 10) as u8;
            (text.len, power) = (text.len + 1, power / 10);
        }
        text
    }

    /// Stops the build with this text.
    ///
    /// # Panics
    /// Always. In a constant this is a compile error.
    #[track_caller]
    pub const fn refuse(&self) -> ! {
        let (text, _) = self.bytes.split_at(self.len);
        match core::str::from_utf8(text) {
            Ok(text) => panic!("{}", text),
            Err(_) => panic!("refused"),
        }
    }
}
