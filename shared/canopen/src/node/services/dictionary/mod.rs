//! Object dictionary of a node, and the services that a write changes at once: PDOs, emergencies and the parameter store.

mod access;
mod pdos;

use super::rules;
use crate::emcy;
use crate::emcy::ErrorCode;
use crate::heartbeat::Monitor;
use crate::node::device::has_states;
use crate::node::index::{CONFIGURATION, PRE_DEFINED_ERRORS, RESTORE, STORE};
use crate::node::services::extension::Extension;
use crate::node::services::objects::NodeObjects;
use crate::node::turn::{Timed, Wakes};
use crate::node::{Communication, Device};
use crate::od::checked::Found;
use crate::od::{Entry, ObjectAccess, Objects, Place, Transfer};
use crate::pdo::{PdoSet, Rpdos, Tpdos};
use crate::sdo::SdoServers;
use crate::sdo::sharing::Shared;
use crate::store::storage::{SaveEnd, Storage};
use crate::store::{Group, Loaded, StoreError};
use crate::types::{AbortCode, Address, CobId, Duration, Instant, NmtState, NodeId};

/// Sub-index of all parameters.
const ALL: u8 = 1;

/// Objects, and the services that a write changes at once.
#[derive(Debug)]
pub struct Dictionary<D: Device, E: Extension<D>> {
    objects: NodeObjects<D, E>,
    rpdos: Timed<Rpdos<D::Pdos>>,
    tpdos: Timed<Tpdos<D::Pdos>>,
    emcy: Timed<emcy::Producer>,
    stored: E::Storage,
    /// Object that a client wrote last and the node did not yet handle.
    written: Option<Address>,
    /// Place of the value that was last requested over the bus.
    found: Option<(Address, Place, &'static Entry)>,
    id: NodeId,
    /// Instant of the last call of the SDO server.
    now: Instant,
    /// Transfer of the other SDO server during a call of one of two.
    shared: <D::Sdo as SdoServers>::Second<Shared>,
    /// Instant before which nothing is due in the node.
    wakes: Wakes,
}

impl<D: Device, E: Extension<D>> Dictionary<D, E> {
    /// Makes the dictionary. `objects` makes the objects in their place.
    pub fn new(id: NodeId, objects: impl FnOnce() -> NodeObjects<D, E>, stored: E::Storage) -> Self {
        // What is found at power-on waits for boot-up, when the objects say how it is sent.
        let emcy = emcy::Config { id: Some(CobId::emcy(id)), inhibit: Duration::ZERO };
        Dictionary {
            rpdos: Timed::new(Rpdos::new()),
            tpdos: Timed::new(Tpdos::new(if const { has_states::<D>() } { &D::PDOS } else { &PdoSet::NONE })),
            emcy: Timed::new(emcy::Producer::new(emcy)),
            stored,
            written: None,
            found: None,
            id,
            now: Instant::ZERO,
            shared: D::Sdo::second(Shared::default),
            wakes: Wakes::at_once(),
            // Last: then the compiler makes it in its place.
            objects: objects(),
        }
    }

    pub fn objects(&self) -> &NodeObjects<D, E> {
        &self.objects
    }

    pub fn objects_mut(&mut self) -> &mut NodeObjects<D, E> {
        &mut self.objects
    }

    pub fn into_objects(self) -> NodeObjects<D, E> {
        self.objects
    }

    pub fn emcy(&self) -> &emcy::Producer {
        &self.emcy
    }

    /// Lends the producer of emergencies for a change. The node runs at the end of its step.
    pub fn emcy_mut(&mut self) -> &mut emcy::Producer {
        self.emcy.change(&mut self.wakes)
    }

    pub fn storage(&self) -> &E::Storage {
        &self.stored
    }

    pub fn storage_mut(&mut self) -> &mut E::Storage {
        &mut self.stored
    }

    pub fn wakes(&self) -> &Wakes {
        &self.wakes
    }

    pub fn wakes_mut(&mut self) -> &mut Wakes {
        &mut self.wakes
    }

    pub fn id_mut(&mut self) -> &mut NodeId {
        &mut self.id
    }

    /// Returns what the dictionary knows of the transfer of another SDO server. `None`: there is one server.
    pub fn shared_mut(&mut self) -> Option<&mut Shared> {
        self.shared.as_mut().first_mut()
    }

    /// Takes the instant at which an SDO server is called.
    pub fn set_now(&mut self, now: Instant) {
        self.now = now;
    }

    /// Takes the parameters of its services and those of `monitor` from the objects.
    pub fn configure(&mut self, monitor: &mut Timed<Monitor<D::Consumers>>, now: Instant) {
        self.written = None;
        self.stop_pdos();
        self.configure_emcy();
        let Self { objects, emcy, wakes, .. } = self;
        let emcy = emcy.change(wakes);
        let clear = &mut |missed: NodeId| _ = emcy.clear(ErrorCode::HEARTBEAT, missed.get());
        monitor.change(wakes).configure(&objects.consumers, clear);
        self.set_pdos(now);
        self.emcy_mut().restart();
        self.show_errors();
    }

    /// Takes COB-ID and inhibit time of the emergencies from the objects.
    pub fn configure_emcy(&mut self) {
        let config = self.objects.communication.emcy.config();
        self.emcy_mut().configure(config);
    }

    /// Lets the producer of emergencies follow a write to one of its objects.
    pub fn follow_emcy(&mut self, at: Address) {
        self.emcy.change(&mut self.wakes).follow(at, &mut self.objects.communication.emcy);
    }

    /// Notes when to poll next, after a run of the node.
    pub fn settle(&mut self, state: NmtState) {
        let Self { emcy, rpdos, tpdos, wakes, .. } = self;
        wakes.set(emcy.deadline(state));
        rpdos.settle(wakes);
        tpdos.settle(wakes);
    }

    /// Applies the stored parameters of a group. If nothing was applied, the defaults hold, and an emergency reports
    /// this until parameters are saved again. Its second byte is the [`Loss`](crate::store::Loss) of the store: 1 if
    /// the last save did not end, 2 if a set is damaged, 0 if the set does not fit this node.
    pub fn load(&mut self, group: Group) {
        self.objects.extension.show_store(self.stored.is_there());
        let cause = self.stored.check().map_or(0, |loss| loss as u8);
        let loaded = self.apply_stored(group);
        let is_applied = matches!(loaded, Ok(None | Some(Loaded::Nothing | Loaded::Set { skipped: 0, .. })));
        if cause != 0 || !is_applied {
            self.raise(ErrorCode::DATA_SET, [0, cause, 0, 0, 0]);
        }
    }

    fn apply_stored(&mut self, group: Group) -> Result<Option<Loaded>, StoreError> {
        let (id, Communication { sync, emcy, .. }) = (self.id, &self.objects.communication);
        let before = (sync.cob_id, emcy.cob_id);
        let rules = |objects: &NodeObjects<D, E>, at: Address, value| match at.index {
            index if index <= E::LAST_RULED => rules::check_stored(id, objects, at, value),
            _ => Ok(()),
        };
        let loaded = self.stored.load(id, group, &mut self.objects, rules)?;
        if loaded.is_some() && !rules::are_possible(id, &self.objects.communication) {
            let Communication { sync, emcy, .. } = &mut self.objects.communication;
            (sync.cob_id, emcy.cob_id) = before;
            return Ok(Some(Loaded::Set { applied: 0, skipped: 2 }));
        }
        Ok(loaded)
    }

    /// Returns whether a save is running.
    pub fn is_saving(&self) -> bool {
        self.stored.deadline().is_some()
    }

    /// Continues a running save if that is due. Returns its end.
    pub fn advance_save(&mut self, now: Instant) -> Option<SaveEnd> {
        let end = self.stored.advance(&mut self.objects, now)?;
        if end.result.is_ok() && (end.at.index == STORE || end.at.sub == ALL) {
            self.clear(ErrorCode::DATA_SET, 0);
        }
        Some(end)
    }

    /// Takes an error that appeared: history and register in the objects follow. Returns `false` if the error is
    /// active already.
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) -> bool {
        self.step_emcy(|emcy| emcy.raise(code, info))
    }

    /// Notes that an error is gone. Returns whether it was there.
    pub fn clear(&mut self, code: ErrorCode, source: u8) -> bool {
        self.step_emcy(|emcy| emcy.clear(code, source))
    }

    /// Reports an error that has already ended.
    pub fn report_past(&mut self, code: ErrorCode, info: [u8; 5]) {
        self.step_emcy(|emcy| emcy.report(code, info));
    }

    fn step_emcy(&mut self, step: impl FnOnce(&mut emcy::Producer) -> bool) -> bool {
        let is_news = self.emcy.step(&mut self.wakes, step);
        if is_news {
            self.show_errors();
        }
        is_news
    }

    /// Notes that another node received the emergencies that were sent.
    pub fn confirm_emergencies(&mut self) {
        self.emcy.no_sooner().confirm();
    }

    /// Shows register and history of errors in the objects.
    fn show_errors(&mut self) {
        self.emcy.show(&mut self.objects.communication.emcy);
    }

    /// Writes an object for the application, with all checks of a write by SDO.
    ///
    /// # Errors
    /// The abort code that a client would receive.
    pub fn write_whole(&mut self, at: Address, value: &[u8], now: Instant) -> Result<(), AbortCode> {
        self.now = now;
        match self.download(at, Some(value.len()))? {
            Transfer::Whole(_) => {
                self.write(at, value)?;
                self.stored.drop_answer();
                Ok(())
            }
            Transfer::Stream(_) => {
                self.write_part(at, 0, value)?;
                self.finish(at, value.len())
            }
        }
    }

    /// Returns the object that a client wrote last, once. A written parameter clears 1020h: the configuration is
    /// no longer the verified one (CiA 301 7.5.2.23).
    #[inline] // row `instructions.sdo_download`
    pub fn take_written(&mut self) -> Option<Address> {
        let at = self.written.take()?;
        // History, signatures, the stamp itself, commands and the time are no parameters.
        let is_command = matches!(at.index, PRE_DEFINED_ERRORS | STORE | RESTORE | CONFIGURATION);
        if !(is_command || E::is_command(at.index)) {
            self.objects.communication.configuration = [0; 2];
        }
        Some(at)
    }

    /// Finds a value.
    fn find(&mut self, at: Address) -> Result<Found<'_>, AbortCode> {
        let (place, entry) = self.place(at)?;
        Found::at(&mut self.objects, place, entry)
    }

    /// Returns the place of a value. A transfer asks for the same one repeatedly.
    #[inline] // row `instructions.sdo_download`
    fn place(&mut self, at: Address) -> Result<(Place, &'static Entry), AbortCode> {
        match self.found {
            Some((found, place, entry)) if found == at => Ok((place, entry)),
            _ => self.look_up(at),
        }
    }

    #[inline(never)] // row `instructions.sdo_download`: 5 more without it
    fn look_up(&mut self, at: Address) -> Result<(Place, &'static Entry), AbortCode> {
        let (place, entry) = NodeObjects::<D, E>::find(at)?;
        self.found = Some((at, place, entry));
        Ok((place, entry))
    }
}
