//! NMT state of the master itself (CiA 301 7.3.2).

use super::{Master, MasterEvent, Out, objects};
use crate::nmt::{Command, NmtMessage, Reaction, Target};
use crate::node::{BusCommand, Device};
use crate::redundancy::MasterBoards;
use crate::store::Group;
use crate::types::{Instant, NmtState, NodeId};

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// Sends the boot-up message and enters Operational without a command (CiA 301 7.3.2.2.1).
    pub(super) fn boot_up(&mut self, now: Instant, out: &mut Out) {
        let (boot_up, state) = self.redundancy.boot_up(now);
        out.command(self.redundancy.active(), BusCommand::Send(boot_up));
        self.is_booting = true;
        self.services.configure(now);
        let objects = &self.services.dictionary.objects;
        self.sync.configure(objects.communication.sync.config(), now);
        self.sync.set_dither(objects.application.network.sync_dither);
        self.sync.start(now);
        self.entered(state, now, out);
    }

    pub(super) fn entered(&mut self, state: NmtState, now: Instant, out: &mut Out) {
        self.services.entered(state, now);
        if !state.allows_sync() {
            self.sync.restart_counter();
        }
        self.services.next = now;
        self.show_state(NodeId::MASTER, state.byte());
        out.event(MasterEvent::State(state));
    }

    /// Commands slaves, or itself: asked by its application, or by a write to 1F82h. A standby sends nothing.
    pub(super) fn on_nmt_request(&mut self, message: NmtMessage, now: Instant, out: &mut Out) {
        if !self.is_active() {
            let node = if let Target::Node(node) = message.target { node } else { NodeId::MASTER };
            return out.event(MasterEvent::Refused { node });
        }
        self.on_application_command(message.target, out);
        if self.redundancy.on_command(message.command, message.target) {
            self.boot.on_commanded(message.target);
        }
        if message.target == Target::Node(NodeId::MASTER) {
            self.on_own_command(message.command, now, out);
        } else if !self.send_nmt(message, now, out)
            && let Target::Node(node) = message.target
        {
            out.event(MasterEvent::Refused { node });
        }
    }

    /// A command of its application, or of a client in 1F82h.
    pub(super) fn on_own_command(&mut self, command: Command, now: Instant, out: &mut Out) {
        if command == Command::ResetNode {
            // Until the application resets the chip it goes on as it was.
            return out.event(MasterEvent::ResetNode);
        }
        match self.redundancy.on_own_command(command) {
            Reaction::Unchanged | Reaction::ResetNode => {}
            Reaction::Entered(state) => self.entered(state, now, out),
            Reaction::ResetCommunication => {
                self.initial.restore(&mut self.services.dictionary.objects);
                self.services.load(Group::Communication);
                let objects = &self.services.dictionary.objects;
                let redundancy = objects::written_redundancy(objects, &self.initial);
                self.take_assignments();
                self.redundancy.configure(redundancy, now);
                self.are_filters_due = true;
                self.boot_up(now, out);
            }
        }
    }
}
