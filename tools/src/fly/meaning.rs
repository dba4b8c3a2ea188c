//! Meaning of frames in CANopen, decoded from identifiers only.
//!
//! Written from the standards and without the protocol crate: an observer that shares code with the nodes would share
//! their mistakes.

use std::fmt;

use can_twin::wire::frame::{WireFrame, WireId};

use crate::images::support::node::{MASTER, Node, SECOND_MASTER};

/// Spacecraft Time PDO of the master (ECSS 7.2.2).
const SPACECRAFT_TIME: u16 = 0x181;

/// Part of the traffic that has a meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// All of it: the images are the shipped ones, so commands and telemetry are known.
    Mission,
    /// Messages defined by CANopen and ECSS-E-ST-50-15C; PDOs are counted, not decoded.
    Protocol,
}

/// A frame's meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// NMT module control (CiA 301 7.2.8.3.1); node 0 means all.
    Nmt { command: NmtCommand, node: Node },
    /// SYNC (CiA 301 7.2.5).
    Sync,
    /// Emergency with its error code, the error register and the field of the manufacturer (CiA 301 7.2.7).
    Emergency { node: Node, code: u16, register: u8, details: [u8; 5] },
    /// Spacecraft Time PDO of the master (ECSS 7.2.2).
    SpacecraftTime(Scet),
    /// Local Time PDO of a slave (ECSS 7.2.2).
    LocalTime { node: Node, scet: Scet },
    /// Unconfirmed command to a slave (ECSS 9.4.2): code, value (5 bytes) and sequence.
    Telecommand { node: Node, code: u16, value: u64, sequence: u8 },
    /// Telemetry request to a slave (ECSS 9.4.3).
    TelemetryRequest { node: Node, code: u16 },
    /// Telemetry of a slave (ECSS 9.4.3).
    Telemetry { node: Node, code: u16, value: u64 },
    /// Cyclic telemetry of a minimal slave, sent with SYNC (ECSS 9.4.3): number of commands executed.
    CyclicState { node: Node, executed: u32 },
    /// Claim of an active master board, sent on both buses with each heartbeat. `board`: 680h is of the board strapped prime, 681h of
    /// the second one. `slaves`: number of slaves that it hears on the active bus.
    Claim { board: Node, slaves: u8 },
    /// A PDO of an image that is not known.
    Pdo,
    /// SDO, either way, with the server in a node (CiA 301 7.2.4).
    Sdo { node: Node },
    /// Boot-up (CiA 301 7.2.8.3.3).
    BootUp { node: Node },
    /// Heartbeat (CiA 301 7.2.8.3.2.2).
    Heartbeat { node: Node, state: NmtState },
}

/// Commands of NMT module control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NmtCommand {
    Start,
    Stop,
    EnterPreOperational,
    ResetNode,
    ResetCommunication,
}

/// NMT states in heartbeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NmtState {
    Stopped,
    Operational,
    PreOperational,
}

/// Spacecraft Elapsed Time: fine time first in the frame, little-endian (ECSS figure 7-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scet {
    /// Seconds.
    pub coarse: u32,
    /// 2^-24 seconds.
    pub fine: u32,
}

impl Meaning {
    /// Returns the meaning of a frame; `None` if it has none on this spacecraft: foreign or malformed.
    pub fn decode(frame: &WireFrame, scope: Scope) -> Option<Meaning> {
        let WireId::Standard(id) = frame.id else { return None };
        if frame.remote {
            return None;
        }
        let data = frame.payload();
        let node = (id & 0x7F) as Node;
        if scope == Scope::Protocol && is_free(id) {
            return Some(match Scet::decode(data) {
                Some(scet) if id == SPACECRAFT_TIME => Meaning::SpacecraftTime(scet),
                _ => Meaning::Pdo,
            });
        }
        match (id & 0x780, node) {
            (0x000, 0) => {
                let &[command, node] = data else { return None };
                Some(Meaning::Nmt { command: NmtCommand::from_byte(command)?, node })
            }
            (0x080, 0) => (data.len() <= 1).then_some(Meaning::Sync),
            (0x680, 0 | 1) => {
                let &[slaves, strap] = data else { return None };
                let board = if strap == 0 { MASTER } else { SECOND_MASTER };
                (strap == node).then_some(Meaning::Claim { board, slaves })
            }
            (_, 0) => None,
            (0x080, _) => {
                let &[low, high, register, ref details @ ..] = data else { return None };
                let (code, details) = (u16::from_le_bytes([low, high]), details.try_into().ok()?);
                Some(Meaning::Emergency { node, code, register, details })
            }
            (0x180, _) => {
                let scet = Scet::decode(data)?;
                let is_master = node == MASTER;
                Some(if is_master {
                    Meaning::SpacecraftTime(scet)
                } else {
                    Meaning::LocalTime { node, scet }
                })
            }
            (0x280, _) => {
                let &[a, b, c, d, _led] = data else { return None };
                Some(Meaning::CyclicState { node, executed: u32::from_le_bytes([a, b, c, d]) })
            }
            (0x300, _) => {
                let (code, rest) = code_and_value(data)?;
                let (value, sequence) = (rest & 0xFF_FFFF_FFFF, (rest >> 40) as u8);
                Some(Meaning::Telecommand { node, code, value, sequence })
            }
            (0x380, _) => {
                let (code, value) = code_and_value(data)?;
                Some(Meaning::Telemetry { node, code, value })
            }
            (0x400, _) => {
                let (code, _) = code_and_value(data)?;
                Some(Meaning::TelemetryRequest { node, code })
            }
            (0x580 | 0x600, _) => (data.len() == 8).then_some(Meaning::Sdo { node }),
            (0x700, _) => {
                let &[state] = data else { return None };
                // Bit 7 is reserved (CiA 301 7.2.8.3.2.2), and the toggle bit of node guarding. No boot-up message has it.
                match state {
                    0x00 => Some(Meaning::BootUp { node }),
                    0x04 | 0x84 => Some(Meaning::Heartbeat { node, state: NmtState::Stopped }),
                    0x05 | 0x85 => Some(Meaning::Heartbeat { node, state: NmtState::Operational }),
                    0x7F | 0xFF => Some(Meaning::Heartbeat { node, state: NmtState::PreOperational }),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

/// Returns whether a mission may assign the identifier to a PDO: not restricted (CiA 301 7.3.5), not of SYNC, TIME or
/// EMCY.
fn is_free(id: u16) -> bool {
    matches!(id, 0x181..=0x580 | 0x600 | 0x680..=0x6DF | 0x700)
}

impl NmtCommand {
    fn from_byte(byte: u8) -> Option<Self> {
        Some(match byte {
            0x01 => NmtCommand::Start,
            0x02 => NmtCommand::Stop,
            0x80 => NmtCommand::EnterPreOperational,
            0x81 => NmtCommand::ResetNode,
            0x82 => NmtCommand::ResetCommunication,
            _ => return None,
        })
    }
}

impl Scet {
    fn decode(data: &[u8]) -> Option<Self> {
        (data.len() == 7).then(|| Scet {
            fine: little_endian(&data[..3]) as u32,
            coarse: little_endian(&data[3..]) as u32,
        })
    }
}

fn code_and_value(data: &[u8]) -> Option<(u16, u64)> {
    (data.len() >= 2).then(|| (little_endian(&data[..2]) as u16, little_endian(&data[2..])))
}

fn little_endian(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u64::from(byte))
}

impl fmt::Display for NmtCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NmtCommand::Start => "start",
            NmtCommand::Stop => "stop",
            NmtCommand::EnterPreOperational => "enter pre-operational",
            NmtCommand::ResetNode => "reset node",
            NmtCommand::ResetCommunication => "reset communication",
        })
    }
}

impl NmtState {
    /// Returns the name in texts.
    pub fn name(self) -> &'static str {
        match self {
            NmtState::Stopped => "stopped",
            NmtState::Operational => "operational",
            NmtState::PreOperational => "pre-operational",
        }
    }
}

impl fmt::Display for Scet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let micros = (u64::from(self.fine) * 1_000_000) >> 24;
        write!(f, "{}.{micros:06} s", self.coarse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(id: u16, data: &[u8]) -> Option<Meaning> {
        Meaning::decode(&WireFrame::standard(id, data), Scope::Mission)
    }

    #[test]
    fn network_management_is_decoded() {
        let reset = NmtCommand::ResetCommunication;
        assert_eq!(decode(0x000, &[0x01, 0]), Some(Meaning::Nmt { command: NmtCommand::Start, node: 0 }));
        assert_eq!(decode(0x000, &[0x82, 4]), Some(Meaning::Nmt { command: reset, node: 4 }));
        assert_eq!(decode(0x703, &[0x00]), Some(Meaning::BootUp { node: 3 }));
        for (byte, state) in
            [(0x04, NmtState::Stopped), (0x05, NmtState::Operational), (0x7F, NmtState::PreOperational)]
        {
            // Bit 7 is reserved.
            let beats = [byte, byte | 0x80].map(|byte| decode(0x701, &[byte]));
            assert_eq!(beats, [Some(Meaning::Heartbeat { node: 1, state }); 2], "{byte:02X}h");
        }
    }

    #[test]
    fn process_data_is_decoded() {
        let command = Meaning::Telecommand { node: 2, code: 0x1234, value: 0xDEAD_BEEF, sequence: 9 };
        let emergency = Meaning::Emergency { node: 2, code: 0x8110, register: 0x11, details: [0; 5] };
        for (id, data, expected) in [
            (0x080, &[][..], Some(Meaning::Sync)),
            (0x302, &[0x34, 0x12, 0xEF, 0xBE, 0xAD, 0xDE, 0, 9], Some(command)),
            (0x285, &[0x02, 0x01, 0, 0, 1], Some(Meaning::CyclicState { node: 5, executed: 258 })),
            (0x285, &[0x02, 0x01, 0, 0], None),
            (0x402, &[0x01, 0x00], Some(Meaning::TelemetryRequest { node: 2, code: 1 })),
            (0x382, &[0x01, 0x00, 0x2A], Some(Meaning::Telemetry { node: 2, code: 1, value: 42 })),
            (0x082, &[0x10, 0x81, 0x11, 0, 0, 0, 0, 0], Some(emergency)),
            (0x602, &[0x40, 0x18, 0x10, 2, 0, 0, 0, 0], Some(Meaning::Sdo { node: 2 })),
            (0x582, &[0x43, 0x18, 0x10, 2, 0x15, 0x50, 0, 0], Some(Meaning::Sdo { node: 2 })),
        ] {
            assert_eq!(decode(id, data), expected, "{id:03X}h {data:02X?}");
        }
    }

    /// A claim has two bytes: the number of slaves, and the strap of the sender, which the COB-ID repeats.
    #[test]
    fn claims_of_both_master_boards_are_decoded() {
        assert_eq!(decode(0x680, &[3, 0]), Some(Meaning::Claim { board: MASTER, slaves: 3 }));
        assert_eq!(decode(0x681, &[0, 1]), Some(Meaning::Claim { board: SECOND_MASTER, slaves: 0 }));
        for (id, data) in
            [(0x680, &[3, 1][..]), (0x681, &[3, 0]), (0x680, &[3]), (0x681, &[3, 1, 0]), (0x682, &[3, 2])]
        {
            assert_eq!(decode(id, data), None, "{id:03X}h {data:02X?}");
        }
    }

    #[test]
    fn spacecraft_time_is_decoded_fine_part_first() {
        let half_past_seven = decode(0x181, &[0x00, 0x00, 0x80, 7, 0, 0, 0]);
        assert_eq!(half_past_seven, Some(Meaning::SpacecraftTime(Scet { coarse: 7, fine: 1 << 23 })));
        let Some(Meaning::SpacecraftTime(scet)) = half_past_seven else { unreachable!() };
        assert_eq!(scet.to_string(), "7.500000 s");
    }

    /// Given frames of an unknown mission, then only messages defined by the standards have a meaning other than "PDO".
    #[test]
    fn frames_of_an_unknown_mission_are_pdos() {
        let decode = |id, data: &[u8]| Meaning::decode(&WireFrame::standard(id, data), Scope::Protocol);
        for id in [0x182, 0x200, 0x302, 0x382, 0x402, 0x4FF, 0x57F, 0x6A0] {
            assert_eq!(decode(id, &[1]), Some(Meaning::Pdo), "{id:03X}h");
        }
        let scet = Scet { coarse: 7, fine: 1 << 23 };
        assert_eq!(decode(0x181, &[0, 0, 0x80, 7, 0, 0, 0]), Some(Meaning::SpacecraftTime(scet)));
        assert_eq!(decode(0x181, &[1, 2]), Some(Meaning::Pdo));
        assert_eq!(decode(0x603, &[0; 8]), Some(Meaning::Sdo { node: 3 }));
        assert_eq!(decode(0x703, &[0]), Some(Meaning::BootUp { node: 3 }));
        let emergency = Meaning::Emergency { node: 3, code: 0, register: 0, details: [0; 5] };
        assert_eq!(decode(0x083, &[0; 8]), Some(emergency));
        for id in [0x100, 0x180, 0x6E0, 0x7E5] {
            assert_eq!(decode(id, &[0; 8]), None, "{id:03X}h");
        }
    }

    #[test]
    fn malformed_frames_have_no_meaning() {
        for (id, data) in [
            (0x000, &[0x01][..]), // node missing
            (0x000, &[0x03, 2]),  // no such command
            (0x702, &[]),         // state missing
            (0x702, &[0x06]),     // no such state
            (0x702, &[0x86]),
            (0x702, &[0x80]),             // no boot-up message
            (0x181, &[1, 2, 3, 4, 5, 6]), // one byte short
            (0x302, &[1]),                // half a code
            (0x7E5, &[0; 8]),             // LSS: not on this spacecraft
        ] {
            assert_eq!(decode(id, data), None, "{id:03X}h {data:02X?}");
        }
        let remote = WireFrame { remote: true, ..WireFrame::standard(0x702, &[]) };
        assert_eq!(Meaning::decode(&remote, Scope::Mission), None);
    }
}
