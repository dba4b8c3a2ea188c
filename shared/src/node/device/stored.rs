//! Parameters that outlive a reset: objects 1010h and 1011h (CiA 301 7.5.2.13, 7.5.2.14).

use crate::nmt::NodeId;
use crate::od::checked::{self, find};
use crate::od::{AbortCode, Access, Address, Entry, Object, Objects};
use crate::store::{self, Group, Loaded, MAX_VALUE, ParameterStore, StoreError};

/// Ctoggle, which begins at zero (ECSS 8.3.2a).
const CTOGGLE: Address = Address::new(0x2000, 4);

/// A parameter store, if the device has one.
pub struct Stored(pub Option<&'static mut (dyn ParameterStore + Send)>);

impl core::fmt::Debug for Stored {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(if self.0.is_some() { "store" } else { "no store" })
    }
}

impl Stored {
    /// Applies what is stored of a group. `Ok(None)` without a store.
    ///
    /// # Errors
    /// [`StoreError::Hardware`]; what was applied before stays.
    pub fn load<D: Objects>(
        &mut self,
        id: NodeId,
        group: Group,
        objects: &mut D,
    ) -> Result<Option<Loaded>, StoreError> {
        let Some(store) = self.0.as_mut() else { return Ok(None) };
        let apply = &mut |at: Address, value: &[u8]| {
            if !group.contains(at.index) {
                return Ok(());
            }
            let (_, entry) = D::find(at)?;
            if is_parameter(at, entry) {
                checked::write(objects, at, value)
            } else {
                Err(AbortCode::NoObject)
            }
        };
        store::load(&mut **store, id, apply).map(Some)
    }

    /// Saves a group, as sub-index `sub` of 1010h names it.
    ///
    /// # Errors
    /// The abort code to answer; what was stored before holds.
    pub fn save<D: Objects>(&mut self, id: NodeId, sub: u8, objects: &mut D) -> Result<(), AbortCode> {
        let (store, group) = self.open(sub)?;
        let mut value = [0; MAX_VALUE];
        let values = &mut |visit: &mut dyn FnMut(Address, &[u8])| {
            D::each_object(&mut |object| {
                each_parameter(object, &mut |at| {
                    let len = find(objects, at).map_or(0, |found| found.read(0, &mut value));
                    visit(at, value.get(..len).unwrap_or(&[]));
                });
            });
        };
        store::save(store, id, group, values).map_err(StoreError::abort_code)
    }

    /// Restores the defaults of a group, as sub-index `sub` of 1011h names it, at the next reset.
    ///
    /// # Errors
    /// The abort code to answer; what was stored before holds.
    pub fn restore(&mut self, id: NodeId, sub: u8) -> Result<(), AbortCode> {
        let (store, group) = self.open(sub)?;
        store::restore_defaults(store, id, group).map_err(StoreError::abort_code)
    }

    fn open(&mut self, sub: u8) -> Result<(&mut (dyn ParameterStore + Send), Group), AbortCode> {
        let store = self.0.as_mut().ok_or(AbortCode::CannotTransfer)?;
        Ok((&mut **store, Group::from_sub(sub).ok_or(AbortCode::NoSubIndex)?))
    }
}

/// Whether a value is kept: what a client may write, and what neither PDOs nor the device itself move.
fn is_parameter(at: Address, entry: &Entry) -> bool {
    let by_nature =
        matches!(entry.access, Access::Rw | Access::Rwr) && (1..=MAX_VALUE as u16).contains(&entry.size);
    by_nature && at != CTOGGLE && !matches!(at.index, 0x1003 | 0x1010 | 0x1011)
}

fn each_parameter(object: &'static Object, visit: &mut dyn FnMut(Address)) {
    for index in (0..object.count).map(|nth| object.index.wrapping_add(nth)) {
        for entry in object.entries {
            for sub in (entry.sub..).take(usize::from(entry.count)) {
                let at = Address::new(index, sub);
                if is_parameter(at, entry) {
                    visit(at);
                }
            }
        }
    }
}
