//! The dictionary as the SDO server sees it: declared checks, rules of the objects, and a note of what was written.

use super::stored::Stored;
use super::{note, rules, show};
use crate::emcy;
use crate::nmt::NodeId;
use crate::node::NodeObjects;
use crate::od::checked::Found;
use crate::od::communication::Mapping;
use crate::od::{AbortCode, Address, Entry, ObjectAccess, Objects, Place, Transfer};
use crate::pdo::{Direction, Rpdos, Tpdos, rules as pdo};
use crate::store::{LOAD, SAVE};
use crate::time::Instant;

/// Store parameters.
const STORE: u16 = 0x1010;
/// Restore default parameters.
const RESTORE: u16 = 0x1011;
/// Pre-defined error field.
const ERRORS: u16 = 0x1003;

/// Access to a dictionary.
pub struct View<'a, A: Objects + Default, const R: usize, const T: usize, M: Mapping> {
    pub objects: &'a mut NodeObjects<A, R, T, M>,
    pub rpdos: &'a mut Rpdos<R>,
    pub tpdos: &'a mut Tpdos<T>,
    pub emcy: &'a mut emcy::Producer,
    pub stored: &'a mut Stored,
    pub written: &'a mut Option<Address>,
    pub found: &'a mut Option<(Address, Place, &'static Entry)>,
    pub id: NodeId,
    pub now: Instant,
}

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> View<'_, A, R, T, M> {
    /// Finds a value. A transfer asks for the same one again and again.
    fn find(&mut self, at: Address) -> Result<Found<'_>, AbortCode> {
        let (place, entry) = match *self.found {
            Some((found, place, entry)) if found == at => (place, entry),
            _ => {
                let (place, entry) = NodeObjects::<A, R, T, M>::find(at)?;
                *self.found = Some((at, place, entry));
                (place, entry)
            }
        };
        Found::at(self.objects, place, entry)
    }

    /// A write to the parameters of a PDO: the service takes them over, or refuses them.
    fn configure_pdo(&mut self, at: Address, value: u32) -> Result<(), AbortCode> {
        let number = usize::from(at.index & 0x1FF);
        let objects = &mut self.objects.communication;
        let rpdo = objects.rpdos.get(number).zip(objects.rpdo_mappings.get_mut(number));
        let tpdo = objects.tpdos.get(number).zip(objects.tpdo_mappings.get_mut(number));
        match (at.index, rpdo, tpdo) {
            (0x1400..=0x15FF, Some((present, mapping)), _) => {
                let new = pdo::rpdo(present, at.sub, value)?;
                let (emcy, mapping) = (&mut *self.emcy, mapping.objects());
                let mut tell = |number, event| note(emcy, number, event);
                self.rpdos.configure::<NodeObjects<A, R, T, M>>(number, &new, mapping, &mut tell)?;
                show(self.emcy, objects);
                Ok(())
            }
            (0x1600..=0x17FF, Some((present, mapping)), _) => {
                let direction = Direction::Receive;
                pdo::mapping::<NodeObjects<A, R, T, M>>(direction, present.cob_id, mapping, at.sub, value)
            }
            (0x1800..=0x19FF, _, Some((present, mapping))) => {
                let new = pdo::tpdo(present, at.sub, value)?;
                let mapping = mapping.objects();
                self.tpdos.configure::<NodeObjects<A, R, T, M>>(number, &new, mapping, self.now)
            }
            (0x1A00..=0x1BFF, _, Some((present, mapping))) => {
                let direction = Direction::Transmit;
                pdo::mapping::<NodeObjects<A, R, T, M>>(direction, present.cob_id, mapping, at.sub, value)
            }
            _ => Err(AbortCode::NoObject),
        }
    }
}

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> ObjectAccess for View<'_, A, R, T, M> {
    fn upload(&mut self, at: Address) -> Result<Transfer, AbortCode> {
        if at.index == ERRORS && at.sub > self.objects.communication.errors.count {
            self.find(at)?;
            return Err(AbortCode::NoData);
        }
        self.find(at)?.upload()
    }

    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> Result<usize, AbortCode> {
        Ok(self.find(at)?.read(offset, into))
    }

    fn download(&mut self, at: Address, size: Option<usize>) -> Result<Transfer, AbortCode> {
        self.find(at)?.download(size)
    }

    fn write(&mut self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        let number = value.iter().take(4).rev().fold(0, |bits, byte| bits << 8 | u32::from(*byte));
        match at.index {
            // The signature is no value: what is read back is what the device can do.
            STORE if number != SAVE => return Err(AbortCode::CannotTransfer),
            RESTORE if number != LOAD => return Err(AbortCode::CannotTransfer),
            STORE => return self.stored.save(self.id, at.sub, self.objects),
            RESTORE => return self.stored.restore(self.id, at.sub),
            index => {
                if index <= rules::LAST {
                    self.find(at)?.download(Some(value.len()))?;
                    match index {
                        0x1400..=0x1BFF => self.configure_pdo(at, number)?,
                        _ => rules::check(self.id, &self.objects.communication, at, number)?,
                    }
                }
                self.find(at)?.write(value)?;
            }
        }
        *self.written = Some(at);
        Ok(())
    }

    fn write_part(&mut self, at: Address, offset: usize, part: &[u8]) -> Result<(), AbortCode> {
        let variable = self.find(at)?.variable.ok_or(AbortCode::ReadOnly)?;
        variable.write_part(offset, part)
    }

    fn finish(&mut self, at: Address, size: usize) -> Result<(), AbortCode> {
        self.find(at)?.variable.ok_or(AbortCode::ReadOnly)?.finish(size)?;
        *self.written = Some(at);
        Ok(())
    }

    fn cancel(&mut self, at: Address) {
        if let Ok(found) = self.find(at)
            && let Some(variable) = found.variable
        {
            variable.cancel();
        }
    }
}
