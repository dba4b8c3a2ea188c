//! Boot-up process of a master, fed with the SDO transfers that flew.
//!
//! The process decides what it asks. The record shows when it asked, and what the slave answered.

use std::ops::{Deref, DerefMut};

use ecss_can::boot::{Boot, BootRequest, Expected, Identified, TimePdo};
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::profile::Profile;
use ecss_can::sdo::Error;
use ecss_can::types::{AbortCode, Address, Bus, CobId, Frame, Instant, NodeId};

use super::Master;
use crate::machine::Produced;

/// Objects of a slave by CiA 301.
const OBJECTS: Identified = Identified {
    device_type: 0x1000,
    identity: 0x1018,
    configuration: 0x1020,
    rpdo: 0x1400,
    emergency: 0x1014,
    tpdo: 0x1800,
};
/// Spacecraft time of the mission: 181h with SYNCs.
const TIME: TimePdo = TimePdo { id: CobId::local_time(NodeId::MASTER), transmission: 1 };
/// 1000h, read by an SDO (CiA 301 7.2.4.3.5).
const READ_DEVICE_TYPE: [u8; 4] = [0x40, 0x00, 0x10, 0x00];

/// The process, and the transfer that it waits for.
pub struct BootProcess {
    boot: Boot,
    asked: Option<NodeId>,
}

impl BootProcess {
    pub fn new(profile: &'static Profile) -> BootProcess {
        let mut boot = Boot::new(profile.boot, OBJECTS, profile.settings);
        for slave in profile.slaves {
            boot.assign(slave.node, slave.assignment());
        }
        BootProcess { boot, asked: None }
    }
}

impl Deref for BootProcess {
    type Target = Boot;

    fn deref(&self) -> &Boot {
        &self.boot
    }
}

impl DerefMut for BootProcess {
    fn deref_mut(&mut self) -> &mut Boot {
        &mut self.boot
    }
}

/// First bytes of the request that begins a transfer, but for the command.
fn multiplexer(at: Address) -> [u8; 3] {
    let [low, high] = at.index.to_le_bytes();
    [low, high, at.sub]
}

impl Master {
    /// The program requested a frame, perhaps the begin of an SDO transfer.
    pub(super) fn on_sdo_request(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        let Some(node) = frame.id().node().filter(|node| frame.id() == CobId::sdo_request(*node)) else { return };
        let is_initiate = matches!(frame.data().first().map(|command| command >> 5), Some(1 | 2));
        if !is_initiate {
            return;
        }
        let is_assigned = self.profile.slaves.iter().any(|slave| slave.node == node);
        if !is_assigned {
            // The question for the device type. The machine decides which node is next.
            if frame.data().starts_with(&READ_DEVICE_TYPE) {
                self.question = self.redundancy.peers_mut().take_unasked();
                let asked = self.question.map(CobId::sdo_request);
                let question = asked.and_then(|id| Frame::new(id, frame.data()).ok());
                self.produced.extend(question.map(|frame| Produced::frame(now, bus, frame)));
            }
            return;
        }
        let expected = |node| {
            let slave = self.profile.slaves.iter().find(|slave| slave.node == node);
            slave.map_or(Expected::default(), |slave| slave.expected)
        };
        let (id, command, at) = match self.boot.boot.request(expected, Some(TIME)) {
            Some(BootRequest::Read { node, at, .. }) => (node, 0x40, at),
            Some(BootRequest::Write { node, at, value }) => (node, 0x23 | (4 - value.len() as u8) << 2, at),
            None => return,
        };
        self.boot.asked = Some(id);
        let [low, high, sub] = multiplexer(at);
        let rest = frame.data().get(4..).unwrap_or(&[]);
        let data = [&[command, low, high, sub], rest].concat();
        if let Ok(asked) = Frame::new(CobId::sdo_request(id), &data) {
            self.produced.push(Produced::frame(now, bus, asked));
        }
    }

    pub(super) fn on_sdo_response(&mut self, node: NodeId, frame: &Frame, now: Instant) {
        if !self.redundancy.is_announced() {
            return;
        }
        if self.question.take_if(|asked| *asked == node).is_some() {
            return self.redundancy.on_answer(node, now);
        }
        if self.boot.asked.take_if(|asked| *asked == node).is_none() || !self.boot.is_asking() {
            return;
        }
        let &[command, _, _, _, ref data @ ..] = frame.data() else { return };
        let outcome = match command >> 5 {
            2 => {
                let unused = usize::from(command >> 2 & 3);
                self.boot.on_data(&data[..data.len().saturating_sub(unused)]);
                Ok(())
            }
            3 => Ok(()),
            _ => {
                let code = u32::from_le_bytes(data.try_into().unwrap_or_default());
                Err(AbortCode::from_code(code).map_or(Error::UnknownAbort(code), Error::Abort))
            }
        };
        self.boot.on_done(outcome, |_| false);
        self.poll_boot(now);
    }

    /// Sends the commands of the process.
    pub(super) fn poll_boot(&mut self, now: Instant) {
        self.boot.poll(now);
        if let Some((node, _)) = self.boot.take_deviation() {
            let message = NmtMessage { command: Command::EnterPreOperational, target: Target::Node(node) };
            self.command(message, now);
        }
        while self.boot.take_failure().is_some() {}
        if let Some(node) = self.boot.take_start()
            && !self.redundancy.peers().is_held(node)
        {
            self.command(NmtMessage { command: Command::Start, target: Target::Node(node) }, now);
        }
    }
}
