//! Events of a slave's controllers that its redundancy depends on, except received frames.

use super::Slave;
use crate::node::services::{PostMortemServices, TimeServices};
use crate::node::slave::Turn;
use crate::node::{LinkEvent, SpacecraftDevice};
use crate::types::{Bus, CobId};

impl<D: SpacecraftDevice> Slave<D> {
    pub(super) fn on_bus_event(&mut self, bus: Bus, event: &LinkEvent, turn: &mut Turn) {
        self.canopen.on_bus_event(bus, bus == self.redundancy.selected(), event, turn);
        match event {
            LinkEvent::Transmitted { frame, stamp } => {
                let id = self.canopen.id();
                if frame.id() == CobId::heartbeat(id) {
                    let services = self.canopen.services_mut();
                    services.note_heartbeat(stamp);
                    services.on_heartbeat_sent();
                }
                let wakes = self.canopen.wakes_mut();
                self.redundancy.step(wakes, |redundancy| redundancy.on_sent(frame, stamp.at, id));
            }
            LinkEvent::Failed { frame, .. } => {
                let wakes = self.canopen.wakes_mut();
                self.redundancy.step(wakes, |redundancy| redundancy.on_end(frame));
            }
            _ => {}
        }
        self.run(turn);
    }
}
