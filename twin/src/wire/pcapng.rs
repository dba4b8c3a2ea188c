//! Recording of several buses in one pcapng file.
//!
//! Link type CAN_SOCKETCAN (227): identifier with flags in network byte order, length, two reserved bytes, raw DLC
//! above 8, data. Each bus is an interface with a name; stamps are nanoseconds since the start of the simulation.

use std::borrow::Cow;
use std::io::{self, Write};
use std::time::Duration;

use pcap_file::pcapng::PcapNgWriter;
use pcap_file::pcapng::blocks::enhanced_packet::EnhancedPacketBlock;
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption,
};
use pcap_file::{DataLink, Endianness, PcapError};

use crate::wire::frame::{WireFrame, WireId};
use crate::wire::time::{TICKS_PER_US, Time};

/// Extended frame, in the identifier word.
const EFF: u32 = 1 << 31;
/// Remote frame, in the identifier word.
const RTR: u32 = 1 << 30;
/// Resolution of the stamps: 10 to the power of minus nine.
const NANOSECONDS: u8 = 9;

/// Writes the frames of several buses in the order of its calls.
pub struct PcapngWriter<W: Write> {
    inner: PcapNgWriter<W>,
}

impl<W: Write> PcapngWriter<W> {
    /// Writes the head of the file with one interface for each of `buses`, in this order.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(writer: W, buses: &[&str]) -> io::Result<Self> {
        let mut inner = PcapNgWriter::with_endianness(writer, Endianness::Little).map_err(io_error)?;
        for &name in buses {
            let interface = InterfaceDescriptionBlock {
                linktype: DataLink::CAN_SOCKETCAN,
                snaplen: 0,
                options: vec![
                    InterfaceDescriptionOption::IfName(Cow::Borrowed(name)),
                    InterfaceDescriptionOption::IfTsResol(NANOSECONDS),
                ],
            };
            inner.write_pcapng_block(interface).map_err(io_error)?;
        }
        Ok(PcapngWriter { inner })
    }

    /// Appends one frame that was complete on the bus with this index at `at`. Call in the order of time.
    ///
    /// # Errors
    /// Those of the writer; an index without a bus.
    pub fn write(&mut self, bus: usize, at: Time, frame: &WireFrame) -> io::Result<()> {
        let (packet, length) = socketcan(frame);
        let block = EnhancedPacketBlock {
            interface_id: u32::try_from(bus).map_err(io::Error::other)?,
            timestamp: Duration::from_nanos(nanoseconds(at)),
            original_len: length as u32,
            data: Cow::Borrowed(&packet[..length]),
            options: Vec::new(),
        };
        self.inner.write_pcapng_block(block).map_err(io_error)?;
        Ok(())
    }

    /// Flushes and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<W> {
        let mut writer = self.inner.into_inner();
        writer.flush()?;
        Ok(writer)
    }
}

fn io_error(error: PcapError) -> io::Error {
    match error {
        PcapError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// Rounded down; no overflow within the range of [`Time`].
fn nanoseconds(at: Time) -> u64 {
    at.as_us() * 1000 + at.0 % TICKS_PER_US * 1000 / TICKS_PER_US
}

/// Returns the packet and its length in bytes.
fn socketcan(frame: &WireFrame) -> ([u8; 16], usize) {
    let mut word = match frame.id {
        WireId::Standard(id) => u32::from(id),
        WireId::Extended(id) => id | EFF,
    };
    if frame.remote {
        word |= RTR;
    }
    let mut packet = [0; 16];
    packet[..4].copy_from_slice(&word.to_be_bytes());
    packet[4] = frame.dlc.min(8);
    if frame.dlc > 8 {
        packet[7] = frame.dlc;
    }
    packet[8..].copy_from_slice(&frame.data);
    (packet, 8 + frame.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(bytes: &[u8]) -> Vec<u32> {
        bytes.chunks(4).map(|word| u32::from_le_bytes(word.try_into().expect("padded to 32 bits"))).collect()
    }

    /// Blocks written out by hand after the pcapng specification (draft-ietf-opsawg-pcapng, sections 4.1 to 4.3).
    #[test]
    fn two_named_interfaces_and_a_packet_on_each() {
        let mut writer =
            PcapngWriter::new(Vec::new(), &["nominal", "redundant"]).expect("a vector takes everything");
        writer.write(0, Time::from_us(48), &WireFrame::standard(0x701, &[0x7F])).expect("bus 0 is there");
        let remote = WireFrame { id: WireId::Extended(0x12), remote: true, dlc: 2, data: [0; 8] };
        writer.write(1, Time::from_ms(5_000), &remote).expect("bus 1 is there");
        let bytes = writer.finish().expect("a vector takes everything");

        let text = |bytes: [u8; 4]| u32::from_le_bytes(bytes);
        let resolution = [1 << 16 | 9, 9]; // if_tsresol, one byte
        #[rustfmt::skip]
        let expected = [
            // Section header: length, byte order, version 1.0, section length unknown.
            0x0A0D_0D0A, 28, 0x1A2B_3C4D, 1, u32::MAX, u32::MAX, 28,
            // Interface 227, no snap length, if_name of 7 bytes, if_tsresol.
            1, 44, 227, 0, 7 << 16 | 2, text(*b"nomi"), text(*b"nal\0"), resolution[0], resolution[1], 0, 44,
            1, 48, 227, 0, 9 << 16 | 2, text(*b"redu"), text(*b"ndan"), text(*b"t\0\0\0"), resolution[0], resolution[1], 0, 48,
            // Packet on 0 at 48,000 ns, 9 bytes: identifier in network order, length 1, data.
            6, 44, 0, 0, 48_000, 9, 9, text([0, 0, 7, 1]), text([1, 0, 0, 0]), 0x7F, 44,
            // Packet on 1 at 5,000,000,000 ns = 1_2A05_F200h, 8 bytes: EFF and RTR, DLC 2.
            6, 40, 1, 1, 0x2A05_F200, 8, 8, text([0xC0, 0, 0, 0x12]), text([2, 0, 0, 0]), 40,
        ];
        assert_eq!(words(&bytes), expected);
    }

    #[test]
    fn a_bus_that_is_not_there_is_an_error() {
        let mut writer = PcapngWriter::new(Vec::new(), &["nominal"]).expect("a vector takes everything");
        assert!(writer.write(1, Time::ZERO, &WireFrame::standard(0x080, &[])).is_err());
    }

    #[test]
    fn a_dlc_above_8_is_kept_beside_8_data_bytes() {
        let frame = WireFrame { id: WireId::Standard(0x181), remote: false, dlc: 12, data: [1; 8] };
        let (packet, length) = socketcan(&frame);
        assert_eq!((packet, length), ([0, 0, 1, 0x81, 8, 0, 0, 12, 1, 1, 1, 1, 1, 1, 1, 1], 16));
    }
}
