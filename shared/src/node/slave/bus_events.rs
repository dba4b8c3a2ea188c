//! Events of a slave's controllers that its redundancy depends on, except received frames.

use super::{Out, Slave};
use crate::emcy::ErrorCode;
use crate::node::{Device, LinkEvent};
use crate::types::{Bus, CobId, Instant};

impl<D: Device> Slave<D> {
    pub(super) fn on_bus_event(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        self.canopen.on_bus_event(bus, event, now, out);
        match event {
            LinkEvent::Transmitted { frame, stamp } if frame.id() == CobId::heartbeat(self.canopen.id) => {
                self.clashes.on_sent(stamp.at);
                self.canopen.services.note_heartbeat(stamp);
                self.canopen.services.on_heartbeat_sent();
            }
            LinkEvent::Transmitted { frame, .. } | LinkEvent::Failed { frame, .. }
                if self.warning.is_some()
                    && frame.data().starts_with(&ErrorCode::HEARTBEAT.get().to_le_bytes()) =>
            {
                self.warning = None;
                self.canopen.services.next = now;
            }
            _ => {}
        }
        self.run(now, now, out);
    }
}
