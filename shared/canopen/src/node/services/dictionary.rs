//! Dictionary access: checks, rules of the objects, and notification of the services.

use super::rules;
use super::sharing::{self, Shared};
use crate::emcy;
use crate::emcy::ErrorCode;
use crate::node::device::has_states;
use crate::node::index::{LAST_TPDO_MAPPING, PRE_DEFINED_ERRORS, RPDO, STORE};
use crate::node::services::extension::Extension;
use crate::node::services::objects::NodeObjects;
use crate::node::storage::{SaveEnd, Storage};
use crate::node::turn::{Timed, Wakes};
use crate::node::{Communication, Device};
use crate::od::checked::Found;
use crate::od::{Entry, ObjectAccess, Objects, Place, Transfer, number};
use crate::pdo::{PdoSet, Rpdos, Tpdos};
use crate::sdo::SdoServers;
use crate::store::{Group, Loaded, StoreError, StoreRequest};
use crate::types::{AbortCode, Address, CobId, Duration, Instant, NodeId};

/// Sub-index of all parameters.
const ALL: u8 = 1;

/// Objects, and the services that a write changes at once.
#[derive(Debug)]
pub struct Dictionary<D: Device, E: Extension<D>> {
    /// Objects of the node.
    pub objects: NodeObjects<D, E>,
    /// Receive PDOs.
    pub rpdos: Timed<Rpdos<D::Pdos>>,
    /// Transmit PDOs.
    pub tpdos: Timed<Tpdos<D::Pdos>>,
    /// Producer of emergencies.
    pub emcy: Timed<emcy::Producer>,
    /// Parameter store.
    pub stored: E::Storage,
    /// Object that a client wrote last and the node did not yet handle.
    pub written: Option<Address>,
    /// Place of the value that was last requested over the bus.
    found: Option<(Address, Place, &'static Entry)>,
    pub(super) id: NodeId,
    /// Instant of the last call of the SDO server.
    pub now: Instant,
    /// Transfer of the other SDO server during a call of one of two.
    pub(crate) shared: <D::Sdo as SdoServers>::Second<Shared>,
    /// Whether that call made something due.
    pub(crate) wakes: Wakes,
}

impl<D: Device, E: Extension<D>> Dictionary<D, E> {
    /// Makes the dictionary. `objects` makes the objects in their place.
    #[inline(never)] // made in its place
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
            wakes: Wakes::never(),
            // Last: then the compiler makes it in its place.
            objects: objects(),
        }
    }

    /// Applies the stored parameters of a group. Returns `Ok(None)` without a store.
    ///
    /// # Errors
    /// [`StoreError::Hardware`]. Parameters that were applied before stay.
    pub fn load(&mut self, group: Group) -> Result<Option<Loaded>, StoreError> {
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

    /// Continues a running save if that is due. Returns its end.
    pub(crate) fn advance_save(&mut self, now: Instant, wakes: &mut Wakes) -> Option<SaveEnd> {
        let end = self.stored.advance(&mut self.objects, now)?;
        if end.result.is_ok() && (end.at.index == STORE || end.at.sub == ALL) {
            self.clear(ErrorCode::DATA_SET, 0, wakes);
        }
        Some(end)
    }

    /// Notes that an error is gone. Returns whether it was there.
    pub fn clear(&mut self, code: ErrorCode, source: u8, wakes: &mut Wakes) -> bool {
        let is_news = self.emcy.step(wakes, |emcy| emcy.clear(code, source));
        if is_news {
            self.show_errors();
        }
        is_news
    }

    /// Register and history of errors in the objects follow.
    pub(crate) fn show_errors(&mut self) {
        self.emcy.show(&mut self.objects.communication.emcy);
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

    #[inline(never)]
    fn look_up(&mut self, at: Address) -> Result<(Place, &'static Entry), AbortCode> {
        let (place, entry) = NodeObjects::<D, E>::find(at)?;
        self.found = Some((at, place, entry));
        Ok((place, entry))
    }

    /// Notes that a client changed a value: an event for all TPDOs that carry it.
    pub fn on_changed(&mut self, at: Address, now: Instant, wakes: &mut Wakes) {
        if self.tpdos.has_events()
            && let Ok((place, _)) = self.place(at)
        {
            self.tpdos.step(wakes, |tpdos| tpdos.on_changed(place, now));
        }
    }
}

impl<D: Device, E: Extension<D>> ObjectAccess for Dictionary<D, E> {
    const TAKES_PARTS: bool = NodeObjects::<D, E>::DECLARED.has_domains();

    fn upload(&mut self, at: Address) -> Result<Transfer, AbortCode> {
        if !self.objects.communication.emcy.has_data(at) {
            self.find(at)?;
            return Err(AbortCode::NoData);
        }
        let transfer = self.find(at)?.upload();
        sharing::begin(self.shared.as_mut(), at, transfer, false)
    }

    #[inline(always)] // called from one place
    fn fetch(&mut self, at: Address) -> Result<Option<([u8; 4], u8)>, AbortCode> {
        let (place, entry) = self.place(at)?;
        if !entry.is_fetched() || at.index == PRE_DEFINED_ERRORS {
            return Ok(None);
        }
        let value = self.objects.variable(place).map(|variable| variable.bits() as u32);
        Ok(value.map(|value| (value.to_le_bytes(), entry.size as u8)))
    }

    #[inline(always)] // called from one place
    fn store(&mut self, at: Address, bytes: [u8; 4], count: Option<u8>) -> Result<bool, AbortCode> {
        if at.index <= E::LAST_RULED || E::takes(at.index) || self.stored.deadline().is_some() {
            return Ok(false);
        }
        let (place, entry) = self.place(at)?;
        let is_whole = count.is_none_or(|count| u16::from(count) == entry.size);
        if !entry.is_stored() || !is_whole {
            return Ok(false);
        }
        let bits = u64::from(u32::from_le_bytes(bytes));
        if let Some(limits) = entry.limits {
            limits.check(entry.data_type, bits)?;
        }
        E::check_value(at, bits as u32)?;
        self.objects.check(at, bytes.get(..usize::from(entry.size)).unwrap_or(&bytes))?;
        let Some(variable) = self.objects.variable(place) else { return Ok(false) };
        variable.set_bits(bits);
        self.written = Some(at);
        Ok(true)
    }

    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> Result<usize, AbortCode> {
        Ok(self.find(at)?.read(offset, into))
    }

    fn download(&mut self, at: Address, size: Option<usize>) -> Result<Transfer, AbortCode> {
        // What a save stores does not change meanwhile, and it is the only one.
        if self.stored.deadline().is_some() {
            return Err(AbortCode::DeviceState);
        }
        let transfer = self.find(at)?.download(size);
        sharing::begin(self.shared.as_mut(), at, transfer, true)
    }

    fn write(&mut self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        if E::takes(at.index) {
            self.objects.extension.take(&mut self.stored, at, value)?;
            self.written = Some(at);
            return Ok(());
        }
        let number = number(value) as u32;
        if E::Storage::HAS_OBJECTS
            && let Some(request) = StoreRequest::of(at.index)
        {
            request.check(number)?;
            sharing::may_save(self.shared.as_ref())?;
            // Obeyed when the save has ended.
            return self.stored.begin(self.id, at, self.now);
        }
        if at.index <= E::LAST_RULED {
            self.find(at)?.download(Some(value.len()))?;
            match at.index {
                RPDO..=LAST_TPDO_MAPPING => {
                    // Before the service takes it.
                    self.objects.check(at, value)?;
                    self.configure_pdo(at, number)?;
                }
                _ => rules::check(self.id, &self.objects, at, number)?,
            }
        }
        self.find(at)?.accepts(value)?;
        E::check_value(at, number)?;
        self.objects.check(at, value)?;
        self.find(at)?.take(value)?;
        self.written = Some(at);
        Ok(())
    }

    fn write_part(&mut self, at: Address, offset: usize, part: &[u8]) -> Result<(), AbortCode> {
        self.find(at)?.bytes().ok_or(AbortCode::UnsupportedAccess)?.write_part(offset, part)
    }

    fn finish(&mut self, at: Address, size: usize) -> Result<(), AbortCode> {
        self.find(at)?.bytes().ok_or(AbortCode::UnsupportedAccess)?.finish(size)?;
        self.written = Some(at);
        Ok(())
    }

    fn hold(&mut self, answer: &[u8; 8]) -> bool {
        self.stored.hold(answer)
    }

    fn cancel(&mut self, at: Address) {
        if let Ok(mut found) = self.find(at)
            && let Some(bytes) = found.bytes()
        {
            bytes.cancel();
        }
    }
}
