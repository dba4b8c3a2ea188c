//! Recording of one bus in the log format of `candump -L`.
//!
//! One line a frame, `(seconds.micros) channel ID#DATA`, as can-utils reads it: 3 digits for a standard identifier, 8
//! for an extended one, `#R` and the DLC for a remote frame (no digit for 0). A DLC above 8 shows as its 8 data bytes.

use std::io::{self, Write};

use crate::wire::frame::{WireFrame, WireId};
use crate::wire::time::Time;

/// Writes the frames of one channel.
#[derive(Debug)]
pub struct CandumpWriter<W> {
    writer: W,
    channel: String,
}

impl<W: Write> CandumpWriter<W> {
    /// Names the channel, such as `nominal`.
    pub fn new(writer: W, channel: impl Into<String>) -> Self {
        CandumpWriter { writer, channel: channel.into() }
    }

    /// Appends one frame that was complete at `at`; microseconds are rounded down.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&mut self, at: Time, frame: &WireFrame) -> io::Result<()> {
        let (seconds, micros) = (at.as_us() / 1_000_000, at.as_us() % 1_000_000);
        write!(self.writer, "({seconds:010}.{micros:06}) {} ", self.channel)?;
        match frame.id {
            WireId::Standard(id) => write!(self.writer, "{id:03X}#")?,
            WireId::Extended(id) => write!(self.writer, "{id:08X}#")?,
        }
        if frame.remote {
            self.writer.write_all(b"R")?;
            if frame.dlc > 0 {
                write!(self.writer, "{}", frame.dlc.min(8))?;
            }
        }
        for byte in frame.payload() {
            write!(self.writer, "{byte:02X}")?;
        }
        writeln!(self.writer)
    }

    /// Flushes and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> io::Result<W> {
        self.writer.flush()?;
        Ok(self.writer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(frames: &[(Time, WireFrame)]) -> String {
        let mut writer = CandumpWriter::new(Vec::new(), "nominal");
        for (at, frame) in frames {
            writer.write(*at, frame).expect("a vector takes everything");
        }
        String::from_utf8(writer.finish().expect("a vector takes everything")).expect("ASCII")
    }

    #[test]
    fn every_kind_of_frame_in_the_format_of_candump() {
        let remote = |id, dlc| WireFrame { id, remote: true, dlc, data: [0; 8] };
        let text = log(&[
            (Time::from_us(48), WireFrame::standard(0x080, &[])),
            (Time::from_us(1_000_000), WireFrame::standard(0x701, &[0x05])),
            (Time::from_us(12_345_678), WireFrame::standard(0x001, &[1, 2, 3, 4, 5, 6, 7, 0xFF])),
            (
                Time::from_ms(20_000),
                WireFrame {
                    id: WireId::Extended(0x12),
                    remote: false,
                    dlc: 1,
                    data: [0xAB, 0, 0, 0, 0, 0, 0, 0],
                },
            ),
            (Time::from_ms(20_001), remote(WireId::Standard(0x701), 0)),
            (Time::from_ms(20_002), remote(WireId::Extended(0x1FFF_FFFF), 5)),
            (
                Time::from_ms(20_003),
                WireFrame { id: WireId::Standard(0x181), remote: false, dlc: 15, data: [9; 8] },
            ),
        ]);
        assert_eq!(
            text,
            "(0000000000.000048) nominal 080#\n\
             (0000000001.000000) nominal 701#05\n\
             (0000000012.345678) nominal 001#01020304050607FF\n\
             (0000000020.000000) nominal 00000012#AB\n\
             (0000000020.001000) nominal 701#R\n\
             (0000000020.002000) nominal 1FFFFFFF#R5\n\
             (0000000020.003000) nominal 181#0909090909090909\n"
        );
    }

    #[test]
    fn a_tick_before_the_microsecond_is_the_microsecond_before() {
        let text = log(&[(Time(Time::from_us(7).0 - 1), WireFrame::standard(0x080, &[]))]);
        assert_eq!(text, "(0000000000.000006) nominal 080#\n");
    }
}
