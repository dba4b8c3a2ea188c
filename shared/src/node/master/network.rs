//! NMT state of the master itself (CiA 301 7.3.2).

use super::{Master, MasterEvent, MasterServices, Turn, objects};
use crate::nmt::machine::Reaction;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::{BusCommand, SpacecraftDevice};
use crate::redundancy::MasterBoards;
use crate::store::Group;
use crate::types::{NmtState, NodeId};

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Sends the boot-up message and enters Operational without a command (CiA 301 7.3.2.2.1).
    pub(super) fn boot_up(&mut self, turn: &mut Turn) {
        let (boot_up, state) = self.redundancy_mut().boot_up(turn.now);
        turn.out.command(self.redundancy.active(), BusCommand::Send(boot_up));
        self.is_booting = true;
        self.services.configure(turn.now);
        let sync = self.sync.change(self.services.wakes_mut());
        sync.configure(self.services.objects().communication.sync.config(), turn.now);
        sync.set_dither(self.services.network().sync_dither);
        sync.start(turn.now);
        self.entered(state, turn);
    }

    pub(super) fn entered(&mut self, state: NmtState, turn: &mut Turn) {
        self.services.entered(state, turn.now);
        if !state.allows_sync() {
            self.sync.no_sooner().restart_counter();
        }
        self.show_state(NodeId::MASTER, state.byte());
        turn.out.event(MasterEvent::State(state));
    }

    /// Commands slaves, or itself: asked by its application, or by a write to 1F82h. A standby sends nothing.
    pub(super) fn on_nmt_request(&mut self, message: NmtMessage, turn: &mut Turn) {
        if !self.is_active() {
            let node = if let Target::Node(node) = message.target { node } else { NodeId::MASTER };
            return turn.out.event(MasterEvent::Refused { node });
        }
        self.on_application_command(message.target, turn);
        if self.redundancy_mut().on_command(message.command, message.target) {
            self.boot_mut().on_commanded(message.target);
        }
        if message.target == Target::Node(NodeId::MASTER) {
            self.on_own_command(message.command, turn);
        } else if !self.send_nmt(message, turn)
            && let Target::Node(node) = message.target
        {
            turn.out.event(MasterEvent::Refused { node });
        }
    }

    /// A command of its application, or of a client in 1F82h.
    pub(super) fn on_own_command(&mut self, command: Command, turn: &mut Turn) {
        if command == Command::ResetNode {
            // Until the application resets the chip it goes on as it was.
            return turn.out.event(MasterEvent::ResetNode);
        }
        let reaction = self.redundancy_mut().on_own_command(command);
        match reaction {
            Reaction::Unchanged | Reaction::ResetNode => {}
            Reaction::Entered(state) => self.entered(state, turn),
            Reaction::ResetCommunication => {
                self.initial.restore(self.services.objects_mut());
                self.services.load(Group::Communication);
                let objects = self.services.objects();
                let redundancy = objects::written_redundancy(objects, &self.initial);
                self.take_assignments();
                self.redundancy_mut().configure(redundancy, turn.now);
                self.filters_mut().note_change();
                self.boot_up(turn);
            }
        }
    }
}
