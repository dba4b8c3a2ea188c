//! Events of a slave's controllers that its redundancy depends on, except received frames.

use super::{Out, Slave};
use crate::node::{Device, LinkEvent};
use crate::types::{Bus, CobId, Instant};

impl<D: Device> Slave<D> {
    pub(super) fn on_bus_event(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        self.canopen.on_bus_event(bus, bus == self.redundancy.selected(), event, now, out);
        let is_due = match event {
            LinkEvent::Transmitted { frame, stamp } => {
                let id = self.canopen.control.id();
                if frame.id() == CobId::heartbeat(id) {
                    self.canopen.services.note_heartbeat(stamp);
                    self.canopen.services.on_heartbeat_sent();
                }
                self.redundancy.on_sent(frame, stamp.at, id)
            }
            LinkEvent::Failed { frame, .. } => self.redundancy.on_end(frame),
            _ => false,
        };
        if is_due {
            self.canopen.services.next = now;
        }
        self.run(now, now, out);
    }
}
