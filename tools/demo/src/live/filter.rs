//! The acceptance filter of an SLCAN channel: that of an SJA1000 in dual filter mode.
//!
//! Two filters, and a frame that passes either is accepted. A 0 in the mask means that the bit must be as in the code. An
//! 11-bit frame is compared by identifier, RTR and, in the first filter, its first data byte; a 29-bit frame by the 16
//! upper bits of its identifier (SJA1000 data sheet, 6.4.15).

use can_wire::frame::{WireFrame, WireId};

/// Code and mask, bytes 0 to 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// What the bits must be.
    pub code: [u8; 4],
    /// Which bits do not matter.
    pub mask: [u8; 4],
}

impl Default for Filter {
    /// Accepts everything.
    fn default() -> Self {
        Filter { code: [0; 4], mask: [0xFF; 4] }
    }
}

impl Filter {
    /// Whether the frame is forwarded.
    pub fn accepts(&self, frame: &WireFrame) -> bool {
        let [c0, c1, c2, c3] = self.code;
        let [m0, m1, m2, m3] = self.mask;
        let halves = [(c0, c1, m0, m1), (c2, c3, m2, m3)];
        let [first, second] = halves.map(|(c_high, c_low, m_high, m_low)| {
            (u16::from_be_bytes([c_high, c_low]), u16::from_be_bytes([m_high, m_low]))
        });
        let matches =
            |(code, mask): (u16, u16), bits: u16, relevant: u16| (code ^ bits) & !mask & relevant == 0;
        match frame.id {
            WireId::Extended(id) => {
                let upper = (id >> 13) as u16;
                matches(first, upper, 0xFFFF) || matches(second, upper, 0xFFFF)
            }
            WireId::Standard(id) => {
                let bits = id << 5 | u16::from(frame.remote) << 4;
                // The byte's upper half stands beside the identifier, its lower half in byte 3.
                let byte = frame.payload().first().copied();
                let by_data = byte.is_none_or(|byte| {
                    let code = c1 << 4 | c3 & 0x0F;
                    let mask = m1 << 4 | m3 & 0x0F;
                    (code ^ byte) & !mask == 0
                });
                by_data && matches(first, bits, 0xFFF0) || matches(second, bits, 0xFFF0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passing(filter: Filter, ids: &[u16]) -> Vec<u16> {
        let passes = |id: &u16| filter.accepts(&WireFrame::standard(*id, &[0x5A]));
        ids.iter().copied().filter(passes).collect()
    }

    #[test]
    fn everything_passes_until_told_otherwise() {
        let all = [0, 0x080, 0x703, 0x7FF];
        assert_eq!(passing(Filter::default(), &all), all);
    }

    #[test]
    fn each_filter_lets_one_identifier_through() {
        // 703h << 5 = E060h and 080h << 5 = 1000h; RTR and data do not matter.
        let filter = Filter { code: [0xE0, 0x60, 0x10, 0x00], mask: [0x00, 0x1F, 0x00, 0x1F] };
        assert_eq!(passing(filter, &[0, 0x080, 0x081, 0x702, 0x703, 0x7FF]), [0x080, 0x703]);
    }

    #[test]
    fn remote_frames_can_be_kept_out() {
        let data = WireFrame::standard(0x703, &[]);
        let remote = WireFrame { remote: true, ..data };
        let filter = Filter { code: [0; 4], mask: [0xFF, 0xEF, 0xFF, 0xEF] };
        assert!(filter.accepts(&data) && !filter.accepts(&remote));
    }

    #[test]
    fn the_first_filter_knows_the_first_byte() {
        // First filter: any identifier with 5Ah as its first byte; second: 000h alone.
        let filter = Filter { code: [0x00, 0x05, 0x00, 0x0A], mask: [0xFF, 0xF0, 0x00, 0x10] };
        assert_eq!(passing(filter, &[0x123, 0x000]), [0x123, 0x000]);
        let other = |id| filter.accepts(&WireFrame::standard(id, &[0x5B]));
        assert!(!other(0x123) && other(0x000));
    }

    #[test]
    fn extended_identifiers_are_compared_by_their_upper_bits() {
        let filter = Filter { code: [0x12, 0x34, 0x12, 0x34], mask: [0; 4] };
        let accepts =
            |id| filter.accepts(&WireFrame { id: WireId::Extended(id), ..WireFrame::standard(0, &[]) });
        assert!(accepts(0x1234 << 13) && accepts(0x1234 << 13 | 0x1FFF));
        assert!(!accepts(0x1235 << 13));
    }
}
