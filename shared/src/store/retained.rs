//! RAM that no start initialises.

/// Two words of RAM that outlive a reset.
pub trait RetainedMemory {
    /// Returns the words that were written last. After power-on they have any value.
    fn read(&self) -> [u32; 2];

    /// Replaces both words.
    fn write(&mut self, words: [u32; 2]);
}
