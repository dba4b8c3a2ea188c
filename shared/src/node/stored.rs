//! Parameters that outlive a reset: objects 1010h and 1011h (CiA 301 7.5.2.13, 7.5.2.14).

use async_canopen::store::machine::{SaveEnd, Storage};

use crate::od::checked::find;
use crate::od::{Entry, Objects, checked, number};
use crate::store;
use crate::store::RunningSave;
use crate::store::identity::is_slave;
use crate::store::{Content, Group, Loaded, Loss, ParameterStore, Parameters, Row, SaveLimit, StoreError};
use crate::types::{AbortCode, Address, Bus, Instant, NodeId};

/// Storage of a device that may have a parameter store.
#[derive(Default)]
pub struct Stored {
    store: Option<&'static mut (dyn ParameterStore + Send)>,
    /// Store in maintenance mode, in which it has no parameters.
    maintained: Option<&'static mut (dyn ParameterStore + Send)>,
    limit: SaveLimit,
    running: Option<RunningSave>,
}

impl core::fmt::Debug for Stored {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(if self.store.is_some() { "store" } else { "no store" })
    }
}

impl Storage for Stored {
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

    fn begin(&mut self, id: NodeId, at: Address, now: Instant) -> Result<(), AbortCode> {
        let store = self.store.as_mut().ok_or(AbortCode::CannotTransfer)?;
        if !self.limit.allows(now) {
            return Err(AbortCode::DeviceState);
        }
        self.limit.on_save(now);
        self.running = Some(RunningSave::begin(&mut **store, id, at, now)?);
        Ok(())
    }

    fn hold(&mut self, answer: &[u8; 8]) -> bool {
        self.running.as_mut().is_some_and(|save| save.hold(answer))
    }

    fn drop_answer(&mut self) {
        if let Some(save) = &mut self.running {
            save.drop_answer();
        }
    }

    fn deadline(&self) -> Option<Instant> {
        self.running.as_ref().map(RunningSave::deadline)
    }

    fn advance<D: Objects>(&mut self, objects: &mut D, now: Instant) -> Option<SaveEnd> {
        let running = self.running.as_mut().filter(|running| running.deadline() <= now)?;
        let end = running.advance(&mut **self.store.as_mut()?, &mut Present(objects), now)?;
        self.running = None;
        Some(end)
    }

    fn give_up(&mut self) {
        self.running = None;
    }
}

impl Stored {
    /// Takes the store of the board, if there is one.
    pub fn new(store: Option<&'static mut (dyn ParameterStore + Send)>) -> Self {
        Stored { store, ..Stored::default() }
    }

    /// Takes the store in maintenance mode: it keeps the Node-ID alone.
    pub fn maintain(&mut self, store: &'static mut (dyn ParameterStore + Send)) {
        self.maintained = Some(store);
    }

    /// Stores a Node-ID, or none, in maintenance mode (ECSS 6.10g). The bytes from the lowest one on are: Node-ID
    /// or 0, its complement, 49h, 44h. Returns the Node-ID that is stored now.
    ///
    /// # Errors
    /// [`AbortCode::DeviceState`] outside of maintenance mode, [`AbortCode::CannotTransfer`] for other bytes,
    /// [`AbortCode::ValueRange`] for the master's Node-ID and above 127, or an error of the store.
    pub fn store_node_id(&mut self, value: &[u8]) -> Result<u32, AbortCode> {
        let store = self.maintained.as_mut().ok_or(AbortCode::DeviceState)?;
        let id = match *value {
            [id, complement, b'I', b'D'] if id == !complement => id,
            _ => return Err(AbortCode::CannotTransfer),
        };
        let node = NodeId::new(id);
        // Zero: none.
        if id != 0 && !node.is_some_and(is_slave) {
            return Err(AbortCode::ValueRange);
        }
        store.store_node_id(node).map_err(StoreError::abort_code)?;
        Ok(id.into())
    }

    /// Writes Bdefault as a note. Returns `None` without a store.
    pub fn note_bdefault(&mut self, id: NodeId, bus: Bus) -> Option<Result<(), StoreError>> {
        Some(store::note_bdefault(&mut **self.store.as_mut()?, id, bus))
    }
}

/// Takes a stored value into the dictionary. A long one comes in parts, of which its owner's check is not asked:
/// only the application itself makes strings of more than 256 bytes.
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

/// The parameters of a dictionary.
struct Present<'a, D>(&'a mut D);

impl<D: Objects> Parameters for Present<'_, D> {
    fn find(&mut self, from: Address) -> Option<Row> {
        let mut from = from;
        loop {
            let object = D::object_from(from.index)?;
            if object.index > from.index {
                from = Address::new(object.index, 0);
            }
            let kept = |entry: &&Entry| entry.is_kept() && entry.sub.saturating_add(entry.count) > from.sub;
            let Some(entry) = object.entries.iter().find(kept) else {
                // All of several in a row are alike.
                let behind = if from.sub == 0 { object.count } else { 1 };
                from = Address::new(from.index.checked_add(behind)?, 0);
                continue;
            };
            let at = Address::new(from.index, from.sub.max(entry.sub));
            from.sub = at.sub.saturating_add(1);
            if let Ok(mut found) = find(self.0, at) {
                let rest = entry.count.saturating_sub(at.sub.saturating_sub(entry.sub));
                let count = if entry.data_type.size().is_some() { rest } else { 1 };
                return Some(Row { at, count, len: found.upload_len() });
            }
        }
    }

    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> usize {
        find(self.0, at).map_or(0, |mut found| found.read(offset, into))
    }
}
