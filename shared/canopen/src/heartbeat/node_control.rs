//! NMT slave with its boot-up message and heartbeat (CiA 301 7.2.8.2, 7.2.8.3).

use super::{Staggered, encode};
use crate::nmt::{Command, ErrorBehaviour, NmtSlave, Reaction};
use crate::types::{Canonical, Duration, Frame, Instant, NmtState, NodeId};

/// Node control of a slave: Node-ID, NMT state, boot-up message and heartbeat.
///
/// Until it is acknowledged, a slave repeats its boot-up message in place of heartbeats. So the first message that
/// another node receives of it is the boot-up message.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub struct NodeControl {
    id: NodeId,
    nmt: NmtSlave,
    heartbeat: Staggered,
    /// `true`: the boot-up message was not acknowledged yet, nor one in place of a heartbeat.
    is_booting: bool,
}

impl NodeControl {
    /// Makes a slave in Initialising. `period`: heartbeat period, zero for none. `late`: delay of a late heartbeat,
    /// as for [`Staggered::new`]. `autostart`: as for [`NmtSlave::new`].
    pub const fn new(id: NodeId, period: Duration, late: Duration, autostart: bool) -> Self {
        let heartbeat = Staggered::new(id, period, late);
        NodeControl { id, nmt: NmtSlave::new(autostart), heartbeat, is_booting: false }
    }

    /// Returns the Node-ID.
    #[inline]
    pub const fn id(&self) -> NodeId {
        self.id
    }

    /// Sets the Node-ID, also that of the heartbeats.
    pub const fn set_id(&mut self, id: NodeId) {
        self.id = id;
        self.heartbeat.set_node(id);
    }

    /// Returns the NMT state.
    #[inline]
    pub const fn state(&self) -> NmtState {
        self.nmt.state()
    }

    /// Returns the state that other nodes may know: Initialising until the boot-up message is acknowledged. Emergencies
    /// wait for it, and SDO requests before it are of the life before (CiA 301 7.2.8.3.3, 7.3.2.2.1).
    pub const fn reporting_state(&self) -> NmtState {
        if self.is_booting { NmtState::Initialising } else { self.nmt.state() }
    }

    /// Sets the pattern of late heartbeats, as [`Staggered::set_pattern`].
    pub const fn set_pattern(&mut self, pattern: u32) {
        self.heartbeat.set_pattern(pattern);
    }

    /// Sets whether the next boot-up leads to Operational, as [`NmtSlave::set_autostart`].
    pub(crate) fn set_autostart(&mut self, autostart: bool) {
        self.nmt.set_autostart(autostart);
    }

    /// Returns the period of the heartbeats. Zero: none.
    pub const fn period(&self) -> Duration {
        self.heartbeat.period()
    }

    /// Takes a new period, as [`Staggered::set_period`].
    pub(crate) fn set_period(&mut self, period: Duration, now: Instant) {
        self.heartbeat.set_period(period, now);
    }

    /// Leaves Initialising. Returns the boot-up message. The first heartbeat follows after a period.
    pub fn boot(&mut self, now: Instant) -> Frame {
        self.nmt.boot();
        self.heartbeat.restart(now);
        self.is_booting = self.heartbeat.period() > Duration::ZERO;
        encode(self.id, NmtState::Initialising)
    }

    /// Takes a command that addresses this node. A change of the state makes a heartbeat due at once. With
    /// [`Reaction::ResetNode`] the heartbeats end.
    pub fn on_command(&mut self, command: Command, now: Instant) -> Reaction {
        let reaction = self.nmt.on_command(command);
        match reaction {
            // The master learns of it now, not a period later.
            Reaction::Entered(_) => self.heartbeat.announce(now),
            Reaction::ResetNode => self.heartbeat.stop(),
            Reaction::Unchanged | Reaction::ResetCommunication => {}
        }
        reaction
    }

    /// Notes that the master is missed, as [`NmtSlave::on_master_missed`].
    pub fn on_master_missed(&mut self) -> Reaction {
        self.nmt.on_master_missed()
    }

    /// Takes another communication error, as [`NmtSlave::on_communication_error`].
    pub(crate) fn on_communication_error(&mut self, behaviour: ErrorBehaviour) -> Reaction {
        self.nmt.on_communication_error(behaviour)
    }

    /// Enters Stopped and ends the heartbeats, until [`NodeControl::announce`] or [`NodeControl::boot`].
    pub fn fall_silent(&mut self) -> Reaction {
        self.heartbeat.stop();
        self.nmt.on_command(Command::Stop)
    }

    /// Makes the next heartbeat due at once.
    pub fn announce(&mut self, now: Instant) {
        self.heartbeat.announce(now);
    }

    /// Returns whether a heartbeat was due before `at` and waits because it is a late one.
    pub fn is_held_back(&self, at: Instant) -> bool {
        self.heartbeat.is_held_back(at)
    }

    /// Returns whether a heartbeat was due on time just before `at`, as [`Staggered::is_just_due`].
    pub fn is_just_due(&self, at: Instant) -> bool {
        self.heartbeat.is_just_due(at)
    }

    /// Takes a frame of this node that was acknowledged. Returns whether it is the first boot-up message since the
    /// boot. A heartbeat that waited since the life before is none.
    pub fn on_sent(&mut self, frame: &Frame) -> bool {
        *frame == encode(self.id, NmtState::Initialising) && core::mem::take(&mut self.is_booting)
    }

    /// Returns the heartbeat when it is due.
    pub fn poll(&mut self, now: Instant) -> Option<Frame> {
        let frame = self.poll_on_time(now)?;
        self.heartbeat.arrange_next();
        Some(frame)
    }

    /// Returns the heartbeat when it is due. The next one is on time.
    pub(crate) fn poll_on_time(&mut self, now: Instant) -> Option<Frame> {
        self.heartbeat.poll(now, self.reporting_state())
    }

    /// Returns whether the heartbeats are on schedule, as [`Producer::is_on_schedule`](super::Producer::is_on_schedule).
    pub fn is_on_schedule(&self, now: Instant) -> bool {
        self.heartbeat.is_on_schedule(now)
    }

    /// Returns when the next heartbeat is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.heartbeat.deadline()
    }
}
