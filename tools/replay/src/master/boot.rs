//! Boot-up process of a master, fed with the SDO transfers that flew.
//!
//! The process decides what it asks. The record shows when it asked, and what the slave answered.

use std::ops::{Deref, DerefMut};

use ecss_can::boot::{Boot, BootRequest, Expected, Identified, TimePdo};
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::profile::Profile;
use ecss_can::sdo::Error;
use ecss_can::types::{AbortCode, Address, Bus, CobId, Duration, Frame, Instant, NodeId};

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
const DEVICE_TYPE: Address = Address::new(0x1000, 0);

/// Time in which no other node is asked after one that did not answer.
const PAUSE: Duration = Duration::from_millis(500);
/// The program counts this pause from the end of its patience. The abort, from which the replay counts, is requested later.
const ABORT_DELAY: Duration = Duration::from_micros(500);

/// The process, and the SDO client that it shares with the questions to new nodes.
pub struct BootProcess {
    boot: Boot,
    transfer: Option<Transfer>,
    /// No new node is asked before.
    not_before: Instant,
}

/// Transfer that runs.
struct Transfer {
    node: NodeId,
    /// Command and object of its first frame.
    begin: [u8; 4],
    /// It reads the device type of a new node.
    is_question: bool,
    /// Its first frame was requested.
    is_sent: bool,
}

impl BootProcess {
    /// Makes the process of the slaves of a profile.
    pub fn new(profile: &'static Profile) -> BootProcess {
        let mut boot = Boot::new(profile.boot, OBJECTS, profile.settings);
        for slave in profile.slaves {
            boot.assign(slave.node, slave.assignment());
        }
        BootProcess { boot, transfer: None, not_before: Instant::ZERO }
    }

    /// Another master is active: forgets slaves.
    pub fn lose_role(&mut self) {
        self.boot.stand_by();
        self.not_before = Instant::ZERO;
    }

    fn begin(&mut self, profile: &Profile) {
        let expected = |node| {
            let slave = profile.slaves.iter().find(|slave| slave.node == node);
            slave.map_or(Expected::default(), |slave| slave.expected)
        };
        let (node, command, at) = match self.boot.request(expected, Some(TIME)) {
            Some(BootRequest::Read { node, at, .. }) => (node, 0x40, at),
            Some(BootRequest::Write { node, at, value }) => (node, 0x23 | (4 - value.len() as u8) << 2, at),
            None => return,
        };
        self.start(node, command, at, false);
    }

    fn start(&mut self, node: NodeId, command: u8, at: Address, is_question: bool) {
        let [low, high] = at.index.to_le_bytes();
        let begin = [command, low, high, at.sub];
        self.transfer = Some(Transfer { node, begin, is_question, is_sent: false });
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

impl Master {
    /// The transfer ends without an answer. The new node that it asked is asked again.
    pub(super) fn ask_again(&mut self) {
        if let Some(transfer) = self.boot.transfer.take()
            && transfer.is_question
        {
            self.redundancy.peers_mut().ask_again(transfer.node);
        }
    }

    /// The program requested a frame, perhaps of an SDO transfer.
    pub(super) fn on_sdo_request(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        let Some(node) = frame.id().node().filter(|node| frame.id() == CobId::sdo_request(*node)) else {
            return;
        };
        let (command, rest) =
            (frame.data().first().map(|byte| byte >> 5), frame.data().get(4..).unwrap_or(&[]));
        self.ask_by(now + ABORT_DELAY);
        let Some(transfer) = &mut self.boot.transfer else { return };
        match command {
            Some(1 | 2) if !transfer.is_sent => {
                transfer.is_sent = true;
                let data = [&transfer.begin, rest].concat();
                if let Ok(begin) = Frame::new(CobId::sdo_request(transfer.node), &data) {
                    self.produced.push(Produced::frame(now, bus, begin));
                }
            }
            // An abort: the node did not answer in time.
            Some(4) if transfer.node == node && transfer.is_sent => {
                let is_question = transfer.is_question;
                self.boot.transfer = None;
                if is_question {
                    self.boot.not_before = now + PAUSE;
                    self.redundancy.peers_mut().on_no_answer(node, now);
                } else {
                    self.boot.on_done(Err(Error::Timeout), |_| false);
                }
            }
            _ => {}
        }
    }

    pub(super) fn on_sdo_response(&mut self, node: NodeId, frame: &Frame, now: Instant) {
        // A late answer to an earlier transfer names another object, an abort perhaps none.
        let at = frame.data().get(1..4);
        let is_abort = frame.data().starts_with(&[0x80, 0, 0, 0]);
        let is_ours = |transfer: &mut Transfer| {
            transfer.node == node && transfer.is_sent && (is_abort || at == transfer.begin.get(1..))
        };
        if !self.redundancy.is_announced() {
            return;
        }
        let Some(transfer) = self.boot.transfer.take_if(is_ours) else {
            if self.redundancy.peers().is_answer_late(node) {
                self.redundancy.on_answer(node, now);
            }
            return;
        };
        if transfer.is_question {
            return self.redundancy.on_answer(node, now);
        }
        let &[command, _, _, _, ref data @ ..] = frame.data() else { return };
        let outcome = match command >> 5 {
            2 => {
                let unused = usize::from(command >> 2 & 3);
                let read = data.get(..data.len().saturating_sub(unused)).unwrap_or(data);
                self.boot.on_data(read);
                Ok(())
            }
            3 => Ok(()),
            _ => {
                let code = u32::from_le_bytes(data.try_into().unwrap_or_default());
                Err(AbortCode::from_code(code).map_or(Error::UnknownAbort(code), Error::Abort))
            }
        };
        self.boot.on_done(outcome, |_| false);
    }

    /// Sends the commands of the process, and begins the next transfer.
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
        // Its slave booted up again, or is lost.
        let is_asking = self.boot.is_asking();
        self.boot.transfer.take_if(|transfer| !transfer.is_question && !is_asking);
        if self.boot.transfer.is_none() && self.redundancy.is_announced() {
            self.boot.begin(self.profile);
            self.ask_by(now);
        }
    }

    /// Begins the next question to a new node, if that is due by `until`.
    fn ask_by(&mut self, until: Instant) {
        if self.asks_at().is_some_and(|at| at <= until)
            && let Some(node) = self.redundancy.peers_mut().take_unasked()
        {
            self.boot.start(node, 0x40, DEVICE_TYPE, true);
        }
    }

    /// Returns when the next new node is asked. `None` while the client is not free for it.
    pub(super) fn asks_at(&self) -> Option<Instant> {
        let is_free = self.boot.transfer.is_none() && self.redundancy.is_announced();
        let is_wanted = self.redundancy.peers().is_any_unasked();
        (is_free && is_wanted && !self.boot.is_busy()).then_some(self.boot.not_before)
    }
}
