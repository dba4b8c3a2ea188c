//! Parts of a node of a spacecraft beyond CANopen, as its services call them.

use async_canopen::node::extend::{Extension, NodeEvent};

use super::index::{IDENTITY, REDUNDANCY, REQUEST_NMT, SCET_SET, SELF_TEST_START, UTC_SET};
use super::services::{LiveServices, MappedTime, Services, State, TimeServices, check_submilliseconds};
use super::stored::Stored;
use super::{
    BusHealth, Counters, NetworkObjects, NodeObjects, SlaveEvent, Spacecraft, SpacecraftDevice,
    SpacecraftEvent, Turn,
};
use crate::emcy::EmcyConsumers;
use crate::link::Stamp;
use crate::link::port::Health;
use crate::od::Objects;
use crate::pdo::machine::rules::is_synchronous;
use crate::pdo::{Mapping, PdoSlots};
use crate::redundancy::{Redundancy, RedundancyObjects};
use crate::types::{AbortCode, Address, Bus, Duration, Frame, Instant, NodeId, PerBus};

impl<D: SpacecraftDevice> Extension<D> for Spacecraft {
    type Storage = Stored;
    type State = State<D::Pdos, D::Sdo>;
    type Event = SpacecraftEvent;
    type SlaveEvent = SlaveEvent;

    /// ECSS 6.10d, k.
    const IS_GUARDED: bool = true;
    const HAS_TWO_BUSES: bool = true;
    const LAST_RULED: u16 = REDUNDANCY;
    const PARAMETERS: u16 = REDUNDANCY;
    /// A receiver's clock is late by what a frame with the time waits.
    const SHORT_LIFETIME: Duration = Duration::from_millis(5);

    fn is_special(mapping: &impl Mapping) -> bool {
        MappedTime::of(mapping) != MappedTime::None
    }

    fn is_special_rpdo(state: &State<D::Pdos, D::Sdo>, number: usize) -> bool {
        state.mapped_time(number) != MappedTime::None
    }

    fn on_rpdo<V: NodeEvent<Extension = SpacecraftEvent>>(
        services: &mut Services<D>,
        number: usize,
        bus: Bus,
        stamp: &Stamp,
        turn: &mut Turn<'_, V>,
    ) {
        let kind = services.state().mapped_time(number);
        // 7.2.2d, 7.2.3c: the type of the PDO says what its value is.
        let pdo = services.objects().pdos.rpdos().0.get(number);
        let by_sync = pdo.is_some_and(|pdo| is_synchronous(pdo.transmission));
        if !services.follow_time(kind, by_sync, stamp, turn) {
            services.buses_mut().count_malformed(bus);
        }
    }

    fn is_short_lived(state: &State<D::Pdos, D::Sdo>, number: usize) -> bool {
        state.carries_time(number)
    }

    fn note_mappings(services: &mut Services<D>) {
        let is_master = services.id() == NodeId::MASTER;
        let (objects, state) = services.objects_and_state();
        state.note_mappings(&objects.pdos, is_master);
        let notes_syncs = state.notes_syncs();
        services.watch_syncs(notes_syncs);
    }

    /// A PDO that carries the time must not be taken for that of the next SYNC.
    fn synchronous_lifetime(services: &Services<D>, whole: Duration) -> Duration {
        let carries_time = services.time_pdos().any(|(_, pdo)| is_synchronous(pdo.transmission));
        if carries_time { Duration::from_micros(whole.as_micros() / 2) } else { whole }
    }

    fn on_sync(services: &mut Services<D>, bus: Bus, stamp: &Stamp) {
        if services.state().notes_syncs() {
            services.time_mut().on_sync(bus, stamp);
            // Its PDOs are sampled at its end (ECSS 7.2.3k).
            if services.state().carries_live_value()
                && let Some(at) = services.last_sync()
            {
                services.refresh_time(at);
                services.refresh_carried(at.instant());
            }
        }
    }

    fn sample_events(services: &mut Services<D>, until: Instant) {
        if services.state().carries_live_value()
            && services.tpdos().deadline().is_some_and(|due| due <= until)
        {
            services.refresh_time_of_events(until);
            services.refresh_carried(until);
        }
    }

    #[inline] // row `instructions.sdo_upload`
    fn sample_for(services: &mut Services<D>, request: &Frame, now: Instant) {
        services.refresh_for(request, now);
    }

    fn on_pdos_stopped(state: &mut State<D::Pdos, D::Sdo>) {
        state.time_mut().stop();
    }

    fn may_write(id: NodeId, at: Address, value: u32) -> Result<(), AbortCode> {
        RedundancyObjects::may_write(at, value)?;
        // A slave does not carry the rules of objects that it has not.
        if const { has_object::<D>(REQUEST_NMT) } {
            NetworkObjects::may_write(at, value)?;
            EmcyConsumers::may_write(id, at, value)?;
        }
        Ok(())
    }

    fn check_value(at: Address, value: u32) -> Result<(), AbortCode> {
        check_submilliseconds::<D>(at, value)
    }

    fn takes(index: u16) -> bool {
        index == IDENTITY
    }

    fn take(&mut self, stored: &mut Stored, _: Address, value: &[u8]) -> Result<(), AbortCode> {
        self.identity.stored = stored.store_node_id(value)?;
        Ok(())
    }

    fn is_command(index: u16) -> bool {
        matches!(index, REQUEST_NMT | SCET_SET | UTC_SET | SELF_TEST_START)
    }

    fn on_written<V: NodeEvent<Extension = SpacecraftEvent>>(
        services: &mut Services<D>,
        at: Address,
        turn: &mut Turn<'_, V>,
    ) {
        if at.index == SELF_TEST_START {
            services.objects_mut().extension.start_self_test();
            turn.out.event(V::extension(SpacecraftEvent::SelfTest));
        }
        services.on_time_written(at, turn);
    }

    fn show_health(&mut self, health: &PerBus<Health>, counters: &PerBus<Counters>) {
        let of = |bus| BusHealth::new(&health[bus], &counters[bus]);
        (self.health_nominal, self.health_redundant) = (of(Bus::Nominal), of(Bus::Redundant));
    }

    fn show_store(&mut self, is_there: bool) {
        self.storage.show(is_there);
    }

    fn parameters(&self) -> u32 {
        let Redundancy { ttoggle, ntoggle, .. } = self.redundancy.parameters;
        u32::from_le_bytes([ttoggle, ntoggle, 0, 0])
    }

    fn restore_parameters(&mut self, parameters: u32) {
        let all = &mut self.redundancy.parameters;
        [all.ttoggle, all.ntoggle, ..] = parameters.to_le_bytes();
    }

    fn count_mended(&mut self) -> u16 {
        let mended = &mut self.identity.mended;
        *mended = mended.saturating_add(1);
        *mended
    }
}

/// Returns whether the node has the record or the array with this index.
const fn has_object<D: SpacecraftDevice>(index: u16) -> bool {
    NodeObjects::<D>::DECLARED.find(Address::new(index, 1)).is_some()
}
