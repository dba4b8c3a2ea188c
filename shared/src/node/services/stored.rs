//! Parameters that outlive a reset: objects 1010h and 1011h (CiA 301 7.5.2.13, 7.5.2.14).

use crate::od::checked::find;
use crate::od::{Object, Objects, checked, number};
use crate::store;
use crate::store::{Content, Group, Loaded, Loss, ParameterStore, SaveLimit, StoreError};
use crate::types::{AbortCode, Address, Bus, Instant, NodeId};

/// Where parameters are kept.
pub trait Storage: core::fmt::Debug {
    /// With the store of the board, if there is one.
    fn new(store: Option<&'static mut (dyn ParameterStore + Send)>) -> Self;

    /// Whether there is one.
    fn is_there(&self) -> bool;

    /// Checks the stored set. Returns the loss since the last save, if there is one.
    fn check(&mut self) -> Option<Loss>;

    /// Applies what is stored of a group, numbers by the `rules` of their objects. `Ok(None)` without a store.
    ///
    /// # Errors
    /// [`StoreError::Hardware`]; what was applied before stays.
    fn load<D: Objects>(
        &mut self,
        id: NodeId,
        group: Group,
        objects: &mut D,
        rules: impl Fn(&D, Address, u32) -> Result<(), AbortCode>,
    ) -> Result<Option<Loaded>, StoreError>;

    /// Saves a group, as sub-index `sub` of 1010h names it.
    ///
    /// # Errors
    /// The abort code to answer; what was stored before holds.
    fn save<D: Objects>(
        &mut self,
        id: NodeId,
        sub: u8,
        objects: &mut D,
        now: Instant,
    ) -> Result<(), AbortCode>;

    /// Restores the defaults of a group, as sub-index `sub` of 1011h names it, at the next reset.
    ///
    /// # Errors
    /// The abort code to answer; what was stored before holds.
    fn restore(&mut self, id: NodeId, sub: u8, now: Instant) -> Result<(), AbortCode>;

    /// Stores a Node-ID, or none, in maintenance mode (ECSS 6.10g): Node-ID or 0, its complement, 49h, 44h from the lowest byte
    /// on. Returns what is stored now.
    ///
    /// # Errors
    /// [`AbortCode::DeviceState`] outside of maintenance mode, [`AbortCode::CannotTransfer`] for other bytes,
    /// [`AbortCode::ValueRange`] for the master's Node-ID and above 127, or that of the store.
    fn store_node_id(&mut self, value: &[u8]) -> Result<u32, AbortCode>;
}

/// A device that keeps none.
#[derive(Debug)]
pub struct NoStore;

impl Storage for NoStore {
    fn new(_store: Option<&'static mut (dyn ParameterStore + Send)>) -> Self {
        NoStore
    }

    fn is_there(&self) -> bool {
        false
    }

    fn check(&mut self) -> Option<Loss> {
        None
    }

    fn load<D: Objects>(
        &mut self,
        _: NodeId,
        _: Group,
        _: &mut D,
        _: impl Fn(&D, Address, u32) -> Result<(), AbortCode>,
    ) -> Result<Option<Loaded>, StoreError> {
        Ok(None)
    }

    fn save<D: Objects>(&mut self, _: NodeId, _: u8, _: &mut D, _: Instant) -> Result<(), AbortCode> {
        Err(AbortCode::NoObject)
    }

    fn restore(&mut self, _: NodeId, _: u8, _: Instant) -> Result<(), AbortCode> {
        Err(AbortCode::NoObject)
    }

    fn store_node_id(&mut self, _: &[u8]) -> Result<u32, AbortCode> {
        Err(AbortCode::NoObject)
    }
}

/// A parameter store, if the device has one.
pub struct Stored {
    pub store: Option<&'static mut (dyn ParameterStore + Send)>,
    /// The store in maintenance mode, in which it has no parameters.
    pub maintained: Option<&'static mut (dyn ParameterStore + Send)>,
    limit: SaveLimit,
}

impl core::fmt::Debug for Stored {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(if self.store.is_some() { "store" } else { "no store" })
    }
}

impl Storage for Stored {
    fn new(store: Option<&'static mut (dyn ParameterStore + Send)>) -> Self {
        Stored { store, maintained: None, limit: SaveLimit::default() }
    }

    fn is_there(&self) -> bool {
        self.store.is_some()
    }

    fn check(&mut self) -> Option<Loss> {
        self.store.as_mut()?.check()
    }

    fn load<D: Objects>(
        &mut self,
        id: NodeId,
        group: Group,
        objects: &mut D,
        rules: impl Fn(&D, Address, u32) -> Result<(), AbortCode>,
    ) -> Result<Option<Loaded>, StoreError> {
        let Some(store) = self.store.as_mut() else { return Ok(None) };
        let apply = &mut |at: Address, content: Content<'_>| {
            if !group.contains(at.index) {
                return Ok(());
            }
            let (_, entry) = D::find(at)?;
            if !entry.is_kept() {
                return Err(AbortCode::NoObject);
            }
            if let Content::Whole(value) = content {
                rules(objects, at, number(value) as u32)?;
            }
            apply(objects, at, content)
        };
        store::load(&mut **store, id, apply).map(Some)
    }

    fn save<D: Objects>(
        &mut self,
        id: NodeId,
        sub: u8,
        objects: &mut D,
        now: Instant,
    ) -> Result<(), AbortCode> {
        let (store, group) = self.open(sub, now)?;
        let values = &mut |visit: &mut dyn FnMut(Address, &mut dyn store::Value)| {
            D::each_object(&mut |object| {
                each_parameter(object, &mut |at| {
                    if let Ok(mut found) = find(objects, at) {
                        visit(at, &mut found);
                    }
                });
            });
        };
        store::save(store, id, group, values).map_err(StoreError::abort_code)
    }

    fn restore(&mut self, id: NodeId, sub: u8, now: Instant) -> Result<(), AbortCode> {
        let (store, group) = self.open(sub, now)?;
        store::restore_defaults(store, id, group).map_err(StoreError::abort_code)
    }

    #[inline(never)] // a write to another object need not pay for it
    fn store_node_id(&mut self, value: &[u8]) -> Result<u32, AbortCode> {
        let store = self.maintained.as_mut().ok_or(AbortCode::DeviceState)?;
        let id = match *value {
            [id, complement, b'I', b'D'] if id == !complement => id,
            _ => return Err(AbortCode::CannotTransfer),
        };
        if id == NodeId::MASTER.get() || id > 127 {
            return Err(AbortCode::ValueRange);
        }
        store.store_node_id(NodeId::new(id)).map_err(StoreError::abort_code)?;
        Ok(id.into())
    }
}

impl Stored {
    /// Notes Bdefault. `None` without a store.
    pub fn note_bdefault(&mut self, id: NodeId, bus: Bus) -> Option<Result<(), StoreError>> {
        Some(store::note_bdefault(&mut **self.store.as_mut()?, id, bus))
    }

    /// The store and the group to write to it, counted as a save.
    fn open(
        &mut self,
        sub: u8,
        now: Instant,
    ) -> Result<(&mut (dyn ParameterStore + Send), Group), AbortCode> {
        let store = self.store.as_mut().ok_or(AbortCode::CannotTransfer)?;
        let group = Group::from_sub(sub).ok_or(AbortCode::NoSubIndex)?;
        if !self.limit.allows(now) {
            return Err(AbortCode::DeviceState);
        }
        self.limit.on_save(now);
        Ok((&mut **store, group))
    }
}

/// Takes a stored value into the dictionary. A long one comes in parts, of which its owner's check is not asked: only the
/// application itself makes strings of more than 256 bytes.
fn apply<D: Objects>(objects: &mut D, at: Address, content: Content<'_>) -> Result<(), AbortCode> {
    if let Content::Whole(value) = content {
        return checked::write(objects, at, value);
    }
    let mut found = find(objects, at)?;
    if let Content::Begin(len) = content {
        return found.download(Some(len)).map(drop);
    }
    let value = found.bytes().ok_or(AbortCode::UnsupportedAccess)?;
    let taken = match content {
        Content::Part(offset, bytes) => value.write_part(offset, bytes),
        Content::End(len) => value.finish(len),
        Content::Whole(_) | Content::Begin(_) => Ok(()),
    };
    if taken.is_err() {
        value.cancel();
    }
    taken
}

fn each_parameter(object: &'static Object, visit: &mut dyn FnMut(Address)) {
    for index in (0..object.count).map(|nth| object.index.wrapping_add(nth)) {
        for entry in object.entries.iter().filter(|entry| entry.is_kept()) {
            for sub in (entry.sub..).take(usize::from(entry.count)) {
                visit(Address::new(index, sub));
            }
        }
    }
}
