//! Two nodes with one Node-ID: the clash is reported, and the node that booted last is silent.

use super::{Out, Slave};
use crate::emcy::ErrorCode;
use crate::heartbeat;
use crate::link::Stamp;
use crate::nmt::{Clash, Command, Reaction};
use crate::node::{Device, SlaveEvent};
use crate::redundancy::Parameters;
use crate::types::{Bus, Frame, Instant};

/// Heartbeat periods after boot-up for which a node yields to one that it hears while its own heartbeat is late:
/// two rounds of the pattern of late heartbeats.
const ROUNDS: u32 = 2 * 32;

impl<D: Device> Slave<D> {
    /// A heartbeat with the Node-ID of this node, which does not receive its own.
    pub(super) fn on_own_heartbeat(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        now: Instant,
        out: &mut Out,
    ) {
        #[cfg(feature = "model")]
        if self.selector.is_broken(crate::redundancy::Broken::IgnoresClash) {
            return self.canopen.services.buses.ignored(bus);
        }
        let Some(state) = heartbeat::decode(frame) else { return self.canopen.services.buses.malformed(bus) };
        let Parameters { consumer, producer, .. } = *self.selector.parameters();
        let heartbeat = &self.canopen.heartbeat;
        let periods = if heartbeat.is_held_back(stamp.at) { ROUNDS } else { 2 };
        let probation = consumer.max(producer.times(periods));
        let clash = self.clashes.on_heartbeat(state, stamp.at, probation);
        self.canopen.services.next = now;
        if clash == Clash::Known {
            return;
        }
        let yields = clash == Clash::Newcomer;
        out.event(SlaveEvent::Clash { bus, yields });
        self.canopen.services.raise(ErrorCode::CAN_ID_COLLISION, [self.canopen.id.get(), 0, 0, 0, 0]);
        if yields {
            // Stopped forbids the message, which goes out now, whatever the inhibit time.
            self.canopen.services.dictionary.emcy.hasten();
            self.canopen.run_device(self.selector.selected(), now, now, out);
            if let Reaction::Entered(state) = self.canopen.nmt.on_command(Command::Stop) {
                self.canopen.entered(state, now, out);
            }
            self.canopen.heartbeat.stop();
        }
    }

    /// The other node was silent long enough.
    pub(super) fn on_clash_over(&mut self, now: Instant, out: &mut Out) {
        self.canopen.services.clear(ErrorCode::CAN_ID_COLLISION, self.canopen.id.get());
        out.event(SlaveEvent::ClashOver);
        if self.clashes.restore() {
            self.enter_pre_operational(now, out);
            self.canopen.heartbeat.announce(now);
        }
    }
}
