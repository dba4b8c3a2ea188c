//! One line of SLCAN, as Lawicel's CAN232 and CANUSB understand it.
//!
//! A line is a command of ASCII characters up to a carriage return. It is answered with a carriage return, which may be
//! preceded by the requested value, or with BEL if it is invalid or not allowed. Commands of the serial line (U, P, A,
//! X, Q, W) are not supported: a socket has no baud rate, and frames are always forwarded at once. Commands of the
//! acceptance filter (M, m) are not supported either: a client gets every frame.

use can_twin::wire::frame::{WireFrame, WireId};

/// Ends a line in both directions; alone it is a positive answer.
pub const OK: u8 = b'\r';

/// Negative answer.
pub const ERROR: u8 = 0x07;

/// The longest line: `T`, 8 digits of identifier, DLC, 8 bytes.
pub const LONGEST: usize = 1 + 8 + 1 + 16;

/// Command of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Empty line, which is always accepted.
    Empty,
    /// `Sn`, `sxxyy`: the bit rate, bit/s.
    BitRate(u32),
    /// `O`: take part in the bus.
    Open,
    /// `L`: take part, but drive nothing.
    Listen,
    /// `C`: leave the bus.
    Close,
    /// `t`, `T`, `r`, `R`: send a frame.
    Send(WireFrame),
    /// `V`: version of the hardware and the software.
    Version,
    /// `v`: version of the software.
    SoftwareVersion,
    /// `N`: serial number.
    SerialNumber,
    /// `F`: status flags.
    Status,
    /// `Z0`, `Z1`: whether received frames carry a time stamp.
    Stamps(bool),
}

/// The rates of `S0` to `S8`, bit/s.
const BIT_RATES: [u32; 9] = [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

impl Command {
    /// Parses a line without its carriage return. Returns `None` if it is invalid.
    pub fn parse(line: &[u8]) -> Option<Command> {
        let Some((name, rest)) = line.split_first() else { return Some(Command::Empty) };
        match (name, rest) {
            (b'O', []) => Some(Command::Open),
            (b'L', []) => Some(Command::Listen),
            (b'C', []) => Some(Command::Close),
            (b'V', []) => Some(Command::Version),
            (b'v', []) => Some(Command::SoftwareVersion),
            (b'N', []) => Some(Command::SerialNumber),
            (b'F', []) => Some(Command::Status),
            (b'Z', [b'0']) => Some(Command::Stamps(false)),
            (b'Z', [b'1']) => Some(Command::Stamps(true)),
            (b'S', [digit @ b'0'..=b'8']) => Some(Command::BitRate(BIT_RATES[usize::from(digit - b'0')])),
            (b's', _) => bytes(rest).map(|registers| Command::BitRate(sja1000_rate(registers))),
            (b't' | b'r', _) => frame(rest, 3, *name == b'r').map(Command::Send),
            (b'T' | b'R', _) => frame(rest, 8, *name == b'R').map(Command::Send),
            _ => None,
        }
    }
}

/// Returns the bit rate of BTR0 and BTR1 of an SJA1000 with a 16 MHz crystal.
fn sja1000_rate([btr0, btr1]: [u8; 2]) -> u32 {
    let prescaler = u32::from(btr0 & 0x3F) + 1;
    let quanta = 3 + u32::from(btr1 & 0x0F) + u32::from(btr1 >> 4 & 0x07);
    8_000_000 / (prescaler * quanta)
}

fn frame(text: &[u8], digits: usize, remote: bool) -> Option<WireFrame> {
    let (id, rest) = text.split_at_checked(digits)?;
    let (&dlc @ b'0'..=b'8', data) = rest.split_first()? else { return None };
    let (id, dlc) = (number(id)?, dlc - b'0');
    let id = match digits {
        3 => WireId::Standard(u16::try_from(id).ok().filter(|id| *id <= 0x7FF)?),
        _ => WireId::Extended(Some(id).filter(|id| *id <= 0x1FFF_FFFF)?),
    };
    let expected = if remote { 0 } else { 2 * usize::from(dlc) };
    if data.len() != expected {
        return None;
    }
    let mut frame = WireFrame { id, remote, dlc, data: [0; 8] };
    for (byte, digits) in frame.data.iter_mut().zip(data.chunks_exact(2)) {
        *byte = number(digits)? as u8;
    }
    Some(frame)
}

/// Parses exactly `N` bytes in hexadecimal.
fn bytes<const N: usize>(text: &[u8]) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    if text.len() != 2 * N {
        return None;
    }
    for (byte, digits) in bytes.iter_mut().zip(text.chunks_exact(2)) {
        *byte = number(digits)? as u8;
    }
    Some(bytes)
}

/// Parses at most 8 hexadecimal digits of either case.
fn number(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |value, digit| Some(value << 4 | char::from(*digit).to_digit(16)?))
}

/// Appends the line of a received frame; `stamp` in milliseconds.
pub fn write_frame(out: &mut Vec<u8>, frame: &WireFrame, stamp: Option<u16>) {
    use std::io::Write;
    let (standard, extended) = if frame.remote { ('r', 'R') } else { ('t', 'T') };
    // Writing to a vector cannot fail.
    let _ = match frame.id {
        WireId::Standard(id) => write!(out, "{standard}{id:03X}"),
        WireId::Extended(id) => write!(out, "{extended}{id:08X}"),
    };
    // SLCAN has no DLC above 8; such a DLC means 8 bytes.
    let _ = write!(out, "{}", frame.dlc.min(8));
    frame.payload().iter().for_each(|byte| drop(write!(out, "{byte:02X}")));
    if let Some(stamp) = stamp {
        let _ = write!(out, "{stamp:04X}");
    }
    out.push(OK);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn standard(id: u16, data: &[u8]) -> Option<Command> {
        Some(Command::Send(WireFrame::standard(id, data)))
    }

    #[test]
    fn good_lines_have_their_meaning() {
        let extended = WireFrame { id: WireId::Extended(0x1FFF_FFFF), ..WireFrame::standard(0, &[0xAB]) };
        let remote = WireFrame { remote: true, dlc: 3, ..WireFrame::standard(0x703, &[]) };
        for (line, command) in [
            (&b""[..], Some(Command::Empty)),
            (b"O", Some(Command::Open)),
            (b"L", Some(Command::Listen)),
            (b"C", Some(Command::Close)),
            (b"V", Some(Command::Version)),
            (b"v", Some(Command::SoftwareVersion)),
            (b"N", Some(Command::SerialNumber)),
            (b"F", Some(Command::Status)),
            (b"Z0", Some(Command::Stamps(false))),
            (b"Z1", Some(Command::Stamps(true))),
            (b"S0", Some(Command::BitRate(10_000))),
            (b"S6", Some(Command::BitRate(500_000))),
            (b"S8", Some(Command::BitRate(1_000_000))),
            // SJA1000 with 16 MHz: 8 quanta of 125 ns, and the same with the prescaler at 4.
            (b"s0014", Some(Command::BitRate(1_000_000))),
            (b"s031C", Some(Command::BitRate(125_000))),
            (b"t0000", standard(0x000, &[])),
            (b"t7FF80102030405060708", standard(0x7FF, &[1, 2, 3, 4, 5, 6, 7, 8])),
            (b"t1232abCD", standard(0x123, &[0xAB, 0xCD])),
            (b"T1FFFFFFF1ab", Some(Command::Send(extended))),
            (b"r7033", Some(Command::Send(remote))),
            (
                b"R1FFFFFFF3",
                Some(Command::Send(WireFrame { remote: true, dlc: 3, data: [0; 8], ..extended })),
            ),
        ] {
            assert_eq!(Command::parse(line), command, "{}", line.escape_ascii());
        }
    }

    #[test]
    fn bad_lines_have_none() {
        for line in [
            &b"o"[..],
            b"X1",
            b"U0",
            b" O",
            b"OO",
            b"O1",
            b"C ",
            b"Z",
            b"Z2",
            b"Z10",
            b"S",
            b"S9",
            b"S88",
            b"s",
            b"s001",
            b"s00144",
            b"s00G4",
            b"M00000000", // no acceptance filter
            b"t",
            b"t12",
            b"t123",            // no DLC
            b"t8000",           // 12 bits
            b"t1239",           // DLC 9
            b"t123A",           // DLC in hexadecimal
            b"t1231",           // byte missing
            b"t12312",          // half a byte
            b"t1231122",        // byte too many
            b"t1231 1",         // blank
            b"t+121",           // sign
            b"t12x0",           // no digit
            b"T000001230 ",     // trailing blank
            b"T200000000",      // 30 bits
            b"T1234567",        // identifier too short
            b"r7033000000",     // a remote frame has no data
            b"R000007033FF",    // nor has this
            b"t1232\xC3\xA9ab", // no ASCII
            b"\x00",
            b"\xFF\xFE",
            b"d1230", // CAN FD
        ] {
            assert_eq!(Command::parse(line), None, "{}", line.escape_ascii());
        }
    }

    fn written(frame: &WireFrame, stamp: Option<u16>) -> String {
        let mut out = Vec::new();
        write_frame(&mut out, frame, stamp);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn received_frames_are_written_as_lines() {
        let frame = WireFrame::standard(0x80, &[]);
        assert_eq!(written(&frame, None), "t0800\r");
        assert_eq!(written(&WireFrame::standard(0x703, &[0x7F]), Some(0xEA5F)), "t70317FEA5F\r");
        let long = WireFrame { dlc: 15, ..WireFrame::standard(0x123, &[0xFF; 8]) };
        assert_eq!(written(&long, None), "t1238FFFFFFFFFFFFFFFF\r");
        let extended = WireFrame { id: WireId::Extended(0x1_2345), ..frame };
        assert_eq!(written(&extended, None), "T000123450\r");
        let remote = WireFrame { remote: true, dlc: 4, ..frame };
        assert_eq!(written(&remote, None), "r0804\r");
        assert_eq!(written(&WireFrame { remote: true, dlc: 4, ..extended }, Some(7)), "R0001234540007\r");
    }

    #[test]
    fn the_longest_line_is_a_full_extended_frame() {
        assert!(Command::parse(b"T1FFFFFFF80102030405060708").is_some());
        assert_eq!(b"T1FFFFFFF80102030405060708".len(), LONGEST);
    }
}
