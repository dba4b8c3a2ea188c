//! A client of a bus of the spacecraft by SLCAN.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};

/// Ends a line and means "done".
const END: u8 = b'\r';

/// Means "refused".
const BELL: u8 = 0x07;

/// A data frame with an 11-bit identifier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// COB-ID.
    pub id: u16,
    /// At most 8 bytes.
    pub data: Vec<u8>,
}

/// An open channel.
#[derive(Debug)]
pub struct Channel {
    stream: TcpStream,
    /// Received bytes that were not parsed.
    input: Vec<u8>,
}

impl Channel {
    /// Opens the channel at an address like `socket://127.0.0.1:29501`.
    ///
    /// # Errors
    /// When no server listens there.
    pub fn open(url: &str) -> anyhow::Result<Channel> {
        let address = url.strip_prefix("socket://").with_context(|| format!("not a socket: {url}"))?;
        let mut stream = TcpStream::connect(address).with_context(|| format!("cannot reach {url}"))?;
        stream.set_nodelay(true)?;
        stream.write_all(b"O\r")?;
        Ok(Channel { stream, input: Vec::new() })
    }

    /// Sends a data frame to the bus.
    ///
    /// # Errors
    /// When the spacecraft has closed the connection.
    pub fn send(&mut self, id: u16, data: &[u8]) -> anyhow::Result<()> {
        let digits: String = data.iter().map(|byte| format!("{byte:02X}")).collect();
        let line = format!("t{id:03X}{}{digits}\r", data.len());
        self.stream.write_all(line.as_bytes()).context("the spacecraft has hung up")
    }

    /// Returns the next data frame of other nodes, if there is one before `until`.
    ///
    /// # Errors
    /// When the spacecraft has closed the connection, has refused a line, or sends an invalid line.
    pub fn receive(&mut self, until: Instant) -> anyhow::Result<Option<Frame>> {
        loop {
            while let Some(end) = self.input.iter().position(|byte| [END, BELL].contains(byte)) {
                let line: Vec<u8> = self.input.drain(..=end).collect();
                ensure!(!line.ends_with(&[BELL]), "the spacecraft has refused a line");
                if let Some(text) = line.strip_prefix(b"t") {
                    let text = std::str::from_utf8(text).context("no ASCII")?.trim_end();
                    return parse(text).with_context(|| format!("not a frame: t{text}")).map(Some);
                }
            }
            let rest = until.saturating_duration_since(Instant::now());
            if rest.is_zero() {
                return Ok(None);
            }
            self.read(rest)?;
        }
    }

    fn read(&mut self, patience: Duration) -> anyhow::Result<()> {
        let mut chunk = [0; 4096];
        self.stream.set_read_timeout(Some(patience))?;
        match self.stream.read(&mut chunk) {
            Ok(0) => anyhow::bail!("the spacecraft has hung up"),
            Ok(count) => self.input.extend(chunk.iter().take(count)),
            Err(error) if [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&error.kind()) => {}
            Err(error) => return Err(error).context("cannot read from the spacecraft"),
        }
        Ok(())
    }
}

/// Parses identifier, length and bytes.
fn parse(text: &str) -> Option<Frame> {
    let id = u16::from_str_radix(text.get(..3)?, 16).ok()?;
    let length: usize = text.get(3..4)?.parse().ok()?;
    let digits = text.get(4..).filter(|digits| digits.len() == 2 * length)?;
    let byte = |at: usize| u8::from_str_radix(digits.get(2 * at..2 * at + 2)?, 16).ok();
    Some(Frame { id, data: (0..length).map(byte).collect::<Option<_>>()? })
}
