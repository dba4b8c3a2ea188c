//! Dictionary of a slave at run time: SDO, SYNC and PDOs.

use super::{FILTERS_OF_PEERS, SYNC_FILTER, SlaveCore};
use crate::link::Stamp;
use crate::node::Device;
use crate::node::events::SlaveEvents;
use crate::node::index::{CONSUMER_HEARTBEAT, LAST_RPDO_MAPPING, PRODUCER_HEARTBEAT, RPDO, SYNC_COB_ID};
use crate::node::services::Extension;
use crate::node::services::SdoStep;
use crate::node::turn::Turn;
use crate::sdo::SdoServers;
use crate::types::{Address, Bus, Frame};

impl<D: Device, E: Extension<D>> SlaveCore<D, E> {
    /// Handles an SDO request. Returns the object that it wrote.
    #[inline(always)] // called from one place
    pub fn on_request(
        &mut self,
        bus: Bus,
        frame: &Frame,
        turn: &mut Turn<'_, E::SlaveEvent>,
    ) -> Option<Address> {
        E::sample_for(&mut self.services, frame, turn.now);
        if !self.serve(SdoStep::Request(frame), bus, turn) {
            self.services.buses_mut().count_malformed(bus);
        }
        self.services.take_written()
    }

    /// Runs the SDO servers and sends their responses on `bus`.
    #[inline(never)] // of three callers
    pub fn serve(&mut self, step: SdoStep, bus: Bus, turn: &mut Turn<'_, E::SlaveEvent>) -> bool {
        let (now, out) = (turn.now, &mut *turn.out);
        let expires = now + self.services.sdo_lifetime();
        self.services.serve(step, now, &mut move |frame| out.send_until(bus, frame, expires))
    }

    /// Handles a received SYNC.
    #[inline] // row `instructions.sync_tpdo_static`
    pub fn on_sync(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn<'_, E::SlaveEvent>) {
        if let Ok(counter) = self.services.on_sync(bus, frame, stamp) {
            if self.state().allows_pdo() {
                self.services.exchange(bus, counter, None, turn);
            }
            turn.out.event(E::SlaveEvent::sync(bus, *stamp));
        } else {
            self.services.buses_mut().count_malformed(bus);
        }
    }

    /// Notes that an object of CANopen was written: services and filters follow.
    pub fn on_own_written(&mut self, at: Address, turn: &mut Turn<'_, E::SlaveEvent>) {
        self.services.on_own_written(at, turn);
        if D::Sdo::SECOND_SERVER == Some(at.index) {
            self.note_filter(self.second_sdo_filter());
        }
        match at.index {
            SYNC_COB_ID => self.note_filter(SYNC_FILTER),
            CONSUMER_HEARTBEAT => {
                let entry = usize::from(at.sub.saturating_sub(1));
                self.note_filter(FILTERS_OF_PEERS + entry);
            }
            PRODUCER_HEARTBEAT => self.follow_heartbeat(turn.now),
            RPDO..=LAST_RPDO_MAPPING => {
                self.note_filter(self.filters_of_rpdos() + usize::from(at.index & 0x1FF));
            }
            _ => {}
        }
        self.update_taken();
    }

    /// Sends what the services have to send.
    pub fn run_device(&mut self, bus: Bus, turn: &mut Turn<'_, E::SlaveEvent>) {
        let Turn { until, now, out } = turn;
        let send = &mut |frame, expires, _| out.offer(bus, frame, expires);
        self.services.poll(*until, *now, self.control.reporting_state(), send);
        if self.services.is_sdo_busy() {
            self.serve(SdoStep::Poll(turn.until), bus, turn);
        }
    }
}
