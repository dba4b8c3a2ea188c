//! Debug probe of a running board: drains the RTT buffer and decodes defmt frames. The log of a program without defmt
//! is read as lines of text.

use std::fmt;
use std::ops::Range;

use defmt_decoder::DecodeError;

use crate::image::Image;
use crate::memory::Memory;
use crate::wire::time::Time;

/// Severity of a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Level {
    /// `defmt::trace!`
    Trace,
    /// `defmt::debug!`
    Debug,
    /// `defmt::info!`
    Info,
    /// `defmt::warn!`
    Warn,
    /// `defmt::error!`
    Error,
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{self:?}").to_uppercase())
    }
}

/// A decoded line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// Instant at which the probe read its last byte, at most a quantum after the program wrote it.
    pub at: Time,
    /// `None` for `defmt::println!` and for text.
    pub level: Option<Level>,
    /// The message without timestamp and level.
    pub text: String,
}

/// The control block's identifier; absent until the program has initialised its memory.
const MAGIC: &[u8; 10] = b"SEGGER RTT";
/// Offsets in the control block: up channel 0.
const BUFFER: u32 = 28;
const WRITE: u32 = 36;
const READ: u32 = 40;
const FLAGS: u32 = 44;
/// Bytes of the control block up to the end of up channel 0.
const CONTROL_BLOCK: u32 = 48;
/// The program waits for room in its buffer.
const BLOCK_IF_FULL: u32 = 2;
/// rzcobs ends every frame with this byte.
const END_OF_FRAME: u8 = 0;

/// The probe's side of the log of one board.
#[derive(Clone, Debug, Default)]
pub struct Rtt {
    control_block: Option<u32>,
    /// The program writes text, not defmt.
    is_text: bool,
    pending: Vec<u8>,
    /// Frames that did not decode: overwritten before the probe read them, or cut by a reset.
    pub(crate) malformed: u64,
    pulled: bool,
}

impl Rtt {
    /// Makes a reader for a board that runs `image`.
    pub fn new(image: &Image) -> Self {
        // A log that cannot be decoded is not read.
        let control_block = image.symbol("_SEGGER_RTT").filter(|_| image.log_table().is_ok());
        let is_text = matches!(image.log_table(), Ok(None));
        Rtt { control_block: control_block.map(|symbol| symbol.address), is_text, ..Rtt::default() }
    }

    /// Returns the addresses of the control block that a probe reads.
    pub(crate) fn control_block(&self) -> Range<u32> {
        self.control_block.filter(|_| !self.pulled).map_or(0..0, |block| block..block + CONTROL_BLOCK)
    }

    /// Handles a restart of the program: an incomplete frame will not be completed.
    pub(crate) fn reset(&mut self, memory: &mut Memory) {
        if self.is_text && !self.pending.is_empty() {
            // The line ends here; it is shown with the next.
            self.pending.push(b'\n');
        } else if !self.pending.is_empty() {
            self.malformed += 1;
            self.pending.clear();
        }
        // The start-up code clears one index before the other. In between, bytes that were read would look unread.
        if let Some(block) = self.control_block
            && is_set_up(memory, block)
        {
            for index in [WRITE, READ] {
                let _ = memory.copy_in(block + index, &[0; 4]);
            }
        }
    }

    /// Removes the probe after it has set blocking mode, as probe-rs does. It reads nothing any more.
    pub(crate) fn pull(&mut self, memory: &mut Memory) {
        self.pulled = true;
        if let Some(block) = self.control_block {
            // Fails only if the control block is not in RAM, in which case no program waits.
            let _ = memory.copy_in(block + FLAGS, &BLOCK_IF_FULL.to_le_bytes());
        }
    }

    /// Takes what the program wrote since the last call.
    pub(crate) fn drain(&mut self, memory: &mut Memory, image: &Image, at: Time, lines: &mut Vec<LogLine>) {
        let Some(block) = self.control_block.filter(|_| !self.pulled) else { return };
        let (write, read) = (word(memory, block + WRITE), word(memory, block + READ));
        if write == read {
            return;
        }
        let (buffer, size) = (word(memory, block + BUFFER), word(memory, block + BUFFER + 4));
        if !is_set_up(memory, block) || write >= size || read >= size {
            return;
        }
        let mut ring = vec![0; size as usize];
        if memory.copy_out(buffer, &mut ring).is_err()
            || memory.copy_in(block + READ, &write.to_le_bytes()).is_err()
        {
            return;
        }
        let (write, read) = (write as usize, read as usize);
        if read < write {
            self.pending.extend_from_slice(&ring[read..write]);
        } else {
            self.pending.extend_from_slice(&ring[read..]);
            self.pending.extend_from_slice(&ring[..write]);
        }
        if self.is_text { self.show_text(at, lines) } else { self.decode(image, at, lines) }
    }

    /// Shows whole lines.
    fn show_text(&mut self, at: Time, lines: &mut Vec<LogLine>) {
        let Some(end) = self.pending.iter().rposition(|&byte| byte == b'\n') else { return };
        let text = String::from_utf8_lossy(&self.pending[..end]).into_owned();
        self.pending.drain(..=end);
        lines.extend(text.split('\n').map(|line| LogLine {
            at,
            level: None,
            text: line.trim_end_matches('\r').to_owned(),
        }));
    }

    /// Decodes complete frames only, because the stream decoder, which borrows the table, cannot keep a partial one.
    fn decode(&mut self, image: &Image, at: Time, lines: &mut Vec<LogLine>) {
        let (Some(table), Some(end)) =
            (image.log_table().ok().flatten(), self.pending.iter().rposition(|&byte| byte == END_OF_FRAME))
        else {
            return;
        };
        let mut decoder = table.new_stream_decoder();
        decoder.received(&self.pending[..=end]);
        self.pending.drain(..=end);
        loop {
            match decoder.decode() {
                Ok(frame) => lines.push(LogLine {
                    at,
                    level: frame.level().map(level),
                    text: frame.display_message().to_string(),
                }),
                Err(DecodeError::UnexpectedEof) => return,
                Err(DecodeError::Malformed) => self.malformed += 1,
            }
        }
    }
}

/// Returns whether the program has made its control block since power-on.
fn is_set_up(memory: &Memory, block: u32) -> bool {
    let mut magic = [0; MAGIC.len()];
    memory.copy_out(block, &mut magic).is_ok() && magic == *MAGIC
}

/// Reads a word of the control block. A control block outside of RAM reads as an empty channel.
fn word(memory: &Memory, address: u32) -> u32 {
    memory.word_at(address).unwrap_or(0)
}

fn level(level: defmt_parser::Level) -> Level {
    match level {
        defmt_parser::Level::Trace => Level::Trace,
        defmt_parser::Level::Debug => Level::Debug,
        defmt_parser::Level::Info => Level::Info,
        defmt_parser::Level::Warn => Level::Warn,
        defmt_parser::Level::Error => Level::Error,
    }
}
