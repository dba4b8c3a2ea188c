//! What the handle of a master has beyond that of a CANopen node.

use easy_ext::ext;

use super::cable::{Cable, Measurement};
use super::extend::{Waiter, WholeNode};
use super::{Handle, Outside, Platform};
use crate::emcy::ActiveError;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::{Master, MasterRequest, Refusal, SelfTest, SpacecraftDevice, Status};
use crate::pdo::{Pdo, PdoValues};
use crate::redundancy::MasterBoards;
use crate::sdo::Error;
use crate::types::{Bus, Frame, Instant, NmtState, NodeId, Scet};

/// What the handle of a master has beyond that of a CANopen node.
///
/// Commands take the [`NodeId`] of a slave, or [`Target::All`] for all slaves. A command to the Node-ID of the master
/// commands the master itself. A master that cannot send a command reports
/// [`MasterEvent::Refused`](crate::node::MasterEvent::Refused): it is not active, or too many commands wait for the
/// announcement of a new bus.
#[ext(MasterHandle)]
impl<B: Platform, D: SpacecraftDevice, M: MasterBoards> Handle<B, Master<D, M>> {
    /// Commands slaves to reset ("reset node"). Until a slave sends its boot-up message, its last known state stays: it
    /// may be Operational.
    pub fn reset(&self, slaves: impl Into<Target>) {
        command(*self, Command::ResetNode, slaves.into());
    }

    /// Commands slaves to reset their communication.
    pub fn reset_communication(&self, slaves: impl Into<Target>) {
        command(*self, Command::ResetCommunication, slaves.into());
    }

    /// Commands slaves to enter Operational. A slave that was [stopped](MasterHandle::stop) or made Pre-operational by the
    /// application is released from it.
    pub fn start(&self, slaves: impl Into<Target>) {
        command(*self, Command::Start, slaves.into());
    }

    /// Commands slaves to enter Stopped. The master does not start them again before the application starts or resets
    /// them.
    pub fn stop(&self, slaves: impl Into<Target>) {
        command(*self, Command::Stop, slaves.into());
    }

    /// Commands slaves to enter Pre-operational. The master does not start them again before the application starts or
    /// resets them.
    pub fn enter_pre_operational(&self, slaves: impl Into<Target>) {
        command(*self, Command::EnterPreOperational, slaves.into());
    }

    /// Runs the boot-up process with an assigned slave again, as if the slave had just been heard.
    pub fn boot(&self, node: NodeId) {
        self.request(MasterRequest::Boot(node));
    }

    /// Makes this bus the active one. Does nothing if it is active already. Leave at least two heartbeat periods between two
    /// changes: a slave that hears heartbeats of the master on both buses in less time reports a second master (8150h).
    pub fn switch_to(&self, bus: Bus) {
        self.request(MasterRequest::SwitchBus(bus));
    }

    /// Sets the spacecraft time, as of now.
    pub fn set_time(&self, scet: Scet) {
        self.request(MasterRequest::SetTime(scet));
    }

    /// Makes this board the standby of another master board, which takes over after its consumer time. If it does not,
    /// this board becomes active again after its own consumer time. Does nothing with one master board, or if another
    /// one is active.
    pub fn stand_by(&self) {
        self.request(MasterRequest::StandBy);
    }

    /// Returns whether this master manages the network. A standby does not.
    pub fn is_active(&self) -> bool {
        self.inspect(Master::is_active)
    }

    /// Returns whether a slave takes commands. It is Operational by its heartbeat, or it is a [minimal
    /// slave](crate::profile::MinimalNode) without a heartbeat.
    pub fn may_command(&self, node: NodeId) -> bool {
        self.inspect(|master| master.may_command(node))
    }

    /// Returns the last state of a slave. `None` if the slave was never heard, is lost or forgotten.
    pub fn slave_state(&self, node: NodeId) -> Option<NmtState> {
        self.inspect(|master| master.slave_state(node))
    }

    /// Waits until a slave takes commands, as [`may_command`](MasterHandle::may_command) reports. Completes at once if it
    /// does already: after [`reset`](MasterHandle::reset) wait first for an event that reports another state. Of more than
    /// four tasks that wait for this node, the others notice the slave within 100 ms.
    ///
    /// # Cancel safety
    /// A dropped future has no effect.
    pub fn wait_operational(&self, node: NodeId) -> impl Future<Output = ()> {
        operational(*self, node)
    }

    /// Returns the state of the master at the present instant.
    pub fn status(&self) -> Status {
        let now = self.now();
        self.inspect(|master| master.status(now))
    }

    /// Calls `each` with each active error of the slaves, as far as they reported them (objects 2048h and 2049h). `each`
    /// cannot use a handle: see [`Outside`].
    pub fn active_errors(&self, each: impl FnMut(ActiveError) + Outside) {
        self.inspect(|master| master.active_errors().for_each(each));
    }

    /// Returns the spacecraft time at which the last SYNC was sent. `None` before the first one.
    pub fn scet_at_sync(&self) -> Option<Scet> {
        self.with(|master, _| master.scet_at_sync())
    }

    /// Puts the result of a self-test into object 2031h (ECSS 6.7b).
    pub fn report_self_test(&self, result: SelfTest) {
        self.with(|master, now| master.report_self_test(result, now));
    }

    /// Sends a transmit PDO of the device of the master by its transmission type, even if its content has not changed.
    ///
    /// # Errors
    /// [`Refusal::NotValid`], also for a PDO that the set of the device does not list, and [`Refusal::Busy`]. Both are counted
    /// on the active bus.
    pub fn send<T>(&self, pdo: Pdo<D, T>) -> Result<(), Refusal> {
        let number = D::PDOS.number_of(pdo);
        self.with(|master, now| master.send_pdo(number, now))
    }

    /// Sends values to a slave by one of its receive PDOs. The master needs no object for them.
    ///
    /// # Errors
    /// As [`send_frame`](MasterHandle::send_frame). [`Refusal::NotOperational`], counted on the active bus, if the slave does not
    /// take commands.
    pub fn send_to<E, T: PdoValues>(&self, slave: NodeId, pdo: Pdo<E, T>, values: T) -> Result<(), Refusal> {
        self.with(|master, now| master.send_to(slave, pdo, values, now))
    }

    /// Sends a frame that no PDO covers, with the lifetime of event-driven PDOs.
    ///
    /// # Errors
    /// [`Refusal::NotValid`] for a restricted COB-ID (CiA 301 7.3.5) and if the master is not Operational,
    /// [`Refusal::Busy`]. Both are counted on the active bus.
    pub fn send_frame(&self, frame: Frame) -> Result<(), Refusal> {
        self.with(|master, now| master.send_frame(frame, now))
    }

    /// Sends a command or a telemetry request to a minimal slave by one of its four receive PDOs (0 is the first;
    /// ECSS 9.4.2c).
    ///
    /// # Errors
    /// As [`send_frame`](MasterHandle::send_frame). [`Refusal::NotValid`] for a fifth PDO or more than 8 bytes.
    /// [`Refusal::NotOperational`] if the slave does not take commands.
    pub fn send_to_minimal(&self, node: NodeId, number: usize, data: &[u8]) -> Result<(), Refusal> {
        self.with(|master, now| master.send_to_minimal(node, number, data, now))
    }

    /// Measures the cable to a slave on the active bus by 16 of its heartbeats. Its clock has to follow the SYNCs
    /// of this master, and both have to stamp in hardware. For 2014h of the slave add the delay of its receiver,
    /// which this method does not measure.
    ///
    /// # Errors
    /// Those of the SDO client, which reads 2014h and 2016h. [`Error::BusChanged`]. [`Error::Timeout`] if there is
    /// no heartbeat that both have stamped.
    ///
    /// # Cancel safety
    /// A dropped future ends the measurement and aborts a transfer that is running. Call it again to measure from
    /// the start.
    pub fn measure_cable(&self, node: NodeId) -> impl Future<Output = Result<Cable, Error>> {
        Measurement(*self).run(node)
    }
}

fn command<B: Platform, D: SpacecraftDevice, M: MasterBoards>(
    master: Handle<B, Master<D, M>>,
    command: Command,
    target: Target,
) {
    master.request(MasterRequest::Nmt(NmtMessage { command, target }));
}

/// Waits as [`MasterHandle::wait_operational`], with a place that it takes when it is polled first.
async fn operational<B: Platform, D: SpacecraftDevice, M: MasterBoards>(
    master: Handle<B, Master<D, M>>,
    node: NodeId,
) {
    let place = Waiter::take(master);
    while !master.may_command(node) {
        place.wait_until(Instant::NEVER).await;
    }
}
