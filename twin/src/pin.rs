//! Pins of a package.

/// A pin of the package.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pin {
    /// Port, 'A' to 'K'.
    pub port: char,
    /// Number in the port, 0 to 15.
    pub number: u8,
}

impl Pin {
    /// Number of ports, A to K.
    pub const PORTS: usize = 11;

    /// `Pin::new('B', 4)` is PB4.
    ///
    /// # Panics
    /// When there is no such pin: a mistake in a test, not an input.
    pub const fn new(port: char, number: u8) -> Self {
        assert!(port >= 'A' && port <= 'K' && number < 16, "pins are PA0 to PK15");
        Pin { port, number }
    }

    /// The pin with this name, such as `PB4`; `None` for any other text.
    pub fn named(name: &str) -> Option<Pin> {
        let mut letters = name.strip_prefix('P')?.chars();
        let port = letters.next().filter(|port| ('A'..='K').contains(port))?;
        let digits = letters.as_str();
        let number =
            digits.parse().ok().filter(|number: &u8| *number < 16 && number.to_string() == digits)?;
        Some(Pin { port, number })
    }

    /// Returns the index of the port; port A is 0.
    pub const fn port_index(self) -> usize {
        self.port as usize - 'A' as usize
    }
}

impl std::fmt::Display for Pin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "P{}{}", self.port, self.number)
    }
}
