//! Services of a slave at run time: SDO, SYNC and PDOs, and events of its controllers other than received frames.

use super::{FILTERS_OF_PEERS, SYNC_FILTER, SlaveCore};
use crate::emcy::ErrorCode;
use crate::link::Stamp;
use crate::link::port::Health;
use crate::node::buses::BusNews;
use crate::node::events::SlaveEvents;
use crate::node::index::{CONSUMER_HEARTBEAT, LAST_RPDO_MAPPING, PRODUCER_HEARTBEAT, RPDO, SYNC_COB_ID};
use crate::node::services::Extension;
use crate::node::services::SdoStep;
use crate::node::turn::Turn;
use crate::node::{Device, FailCause, LinkEvent};
use crate::sdo::SdoServers;
use crate::types::{Address, Bus, CobId, Duration, Frame, Instant};

/// From an overrun to the next frames of all states. A receiver that is too slow has many overruns: they are sent once for all.
const AFTER_OVERRUN: Duration = Duration::from_millis(1_000);

impl<D: Device, E: Extension<D>> SlaveCore<D, E> {
    /// Handles an SDO request. Returns the object that it wrote.
    #[inline(always)] // row `instructions.sdo_upload`: 28 more without it
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

    /// Counts the event, follows the error state, and passes the ends of transmissions to the SDO servers.
    /// `is_active`: the node uses this bus.
    pub fn on_bus_event(
        &mut self,
        bus: Bus,
        is_active: bool,
        event: &LinkEvent,
        turn: &mut Turn<'_, E::SlaveEvent>,
    ) {
        match self.services.on_link(bus, event, turn.now) {
            Some(BusNews::Health(health)) => self.on_health(bus, health, turn),
            Some(BusNews::Failed(health)) => {
                self.on_health(bus, health, turn);
                turn.out.event(E::SlaveEvent::bus_failed(bus));
            }
            Some(BusNews::Stalled) => turn.out.event(E::SlaveEvent::bus_stalled(bus)),
            None => {}
        }
        if let LinkEvent::Transmitted { frame, .. } = event
            && self.control.no_sooner().on_sent(frame)
        {
            self.services.emcy_mut();
        }
        match event {
            LinkEvent::Transmitted { frame, .. } => {
                self.on_sent(frame, turn.now);
                if is_active {
                    self.services.on_frame_end(frame, true, turn.now);
                }
            }
            LinkEvent::Failed { frame, cause } => {
                self.on_sent(frame, turn.now);
                // What is over the budget is reported as such.
                if *cause != FailCause::OverBudget && self.services.tpdos().is_event(frame.id()) {
                    turn.out.event(E::SlaveEvent::not_sent(bus, frame.id(), frame.padded()));
                } else if is_active {
                    self.services.on_frame_end(frame, false, turn.now);
                }
            }
            LinkEvent::Overrun { .. } => {
                if is_active {
                    // It may have been the boot-up message of the master.
                    self.services.send_states(turn.now + AFTER_OVERRUN);
                }
                self.services.occurred(ErrorCode::CAN_OVERRUN, bus);
            }
            LinkEvent::Unsent { frames } => {
                // Some may have been segments that an SDO server waits for.
                self.services.on_sdo_unsent(*frames);
                self.services.occurred(ErrorCode::CAN_OVERRUN, bus);
            }
            LinkEvent::Counters(_) => self.services.refresh_health(),
            _ => {}
        }
    }

    fn on_sent(&mut self, frame: &Frame, now: Instant) {
        if frame.id() == CobId::sdo_response(self.control.id()) {
            self.services.on_sdo_sent();
        } else if self.services.is_second_sdo_answer(frame.id()) {
            self.services.on_second_sdo_sent();
        } else if E::IS_GUARDED && frame.id() == CobId::heartbeat(self.control.id()) {
            self.check_cob_ids(now);
        }
    }

    fn on_health(&mut self, bus: Bus, health: Health, turn: &mut Turn<'_, E::SlaveEvent>) {
        self.services.on_health(bus, &health);
        self.services.refresh_health();
        turn.out.event(E::SlaveEvent::health(bus, health));
    }
}
