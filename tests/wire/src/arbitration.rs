//! Who goes on sending when several controllers start together.

use crate::encode::Encoded;

/// Result of a bitwise arbitration; members are indices into the list of contenders.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Outcome {
    /// Those that send to the end, or until the collision. More than one when their frames are equal so far.
    pub(crate) transmitters: Vec<usize>,
    /// Those that lost, with the bit (0 = SOF) at which they did.
    pub(crate) lost: Vec<(usize, usize)>,
    /// Bit after the arbitration field at which the transmitters differ: a bit error.
    pub(crate) collision: Option<usize>,
}

/// Dominant beats recessive, bit by bit (ISO 11898-1, 10.2). Frames with equal arbitration fields and different rest
/// collide; frames equal in every bit are one frame with several transmitters.
pub(crate) fn arbitrate(contenders: &[Encoded]) -> Outcome {
    let mut outcome =
        Outcome { transmitters: (0..contenders.len()).collect(), lost: Vec::new(), collision: None };
    let shortest = contenders.iter().map(|c| c.bits().len()).min().unwrap_or(0);
    for bit in 0..shortest {
        if outcome.transmitters.len() < 2 {
            break;
        }
        let recessive = |&c: &usize| contenders[c].bits()[bit];
        if outcome.transmitters.iter().all(recessive) || !outcome.transmitters.iter().any(recessive) {
            continue;
        }
        let (losers, winners): (Vec<usize>, Vec<usize>) =
            outcome.transmitters.iter().partition(|&c| recessive(c));
        if losers.iter().any(|&c| bit >= contenders[c].arbitration_len()) {
            outcome.collision = Some(bit);
            break;
        }
        outcome.lost.extend(losers.into_iter().map(|c| (c, bit)));
        outcome.transmitters = winners;
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::encode;
    use crate::frame::{WireFrame, WireId};

    fn outcome(frames: &[WireFrame]) -> Outcome {
        arbitrate(&frames.iter().map(encode).collect::<Vec<_>>())
    }

    fn remote(id: WireId) -> WireFrame {
        WireFrame { id, remote: true, dlc: 0, data: [0; 8] }
    }

    #[test]
    fn loser_drops_out_at_its_first_recessive_bit() {
        // 080h = 000 1000 0000, 701h = 111 0000 0001: they differ in the first bit after SOF.
        let result = outcome(&[WireFrame::standard(0x701, &[5]), WireFrame::standard(0x080, &[])]);
        assert_eq!(result, Outcome { transmitters: vec![1], lost: vec![(0, 1)], collision: None });
    }

    #[test]
    fn data_beats_remote_and_standard_beats_extended() {
        let data = WireFrame::standard(0x123, &[1]);
        let standard_remote = remote(WireId::Standard(0x123));
        let extended = WireFrame {
            id: WireId::Extended(0x123 << 18),
            remote: false,
            dlc: 1,
            data: [1, 0, 0, 0, 0, 0, 0, 0],
        };
        assert_eq!(outcome(&[standard_remote, data]).transmitters, [1]);
        assert_eq!(outcome(&[extended, data]).transmitters, [1]);
        assert_eq!(outcome(&[extended, standard_remote]).transmitters, [1]);
        assert_eq!(outcome(&[remote(extended.id), extended]).transmitters, [1]);
        assert!(outcome(&[extended, standard_remote]).collision.is_none());
    }

    #[test]
    fn equal_arbitration_field_and_other_data_collide_after_it() {
        let result = outcome(&[WireFrame::standard(0x181, &[1]), WireFrame::standard(0x181, &[2])]);
        assert_eq!(result.transmitters, [0, 1]);
        // SOF + 11 + RTR + IDE + r0 + DLC 4 = 19 bits without stuffing, then data bits 0000_00 are common.
        assert!(result.collision.is_some_and(|bit| bit >= 25));
    }

    #[test]
    fn equal_frames_are_sent_together() {
        let frame = WireFrame::standard(0x181, &[1]);
        let result = outcome(&[frame, frame]);
        assert_eq!(result, Outcome { transmitters: vec![0, 1], lost: vec![], collision: None });
    }
}
