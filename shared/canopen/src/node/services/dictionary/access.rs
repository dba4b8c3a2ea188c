//! Access of the SDO servers to the dictionary: checks, and rules of the objects.

use super::Dictionary;
use crate::node::Device;
use crate::node::index::{LAST_TPDO_MAPPING, PRE_DEFINED_ERRORS, RPDO};
use crate::node::services::extension::Extension;
use crate::node::services::objects::NodeObjects;
use crate::node::services::rules;
use crate::od::{ObjectAccess, Objects, Transfer, number};
use crate::sdo::sharing;
use crate::store::StoreRequest;
use crate::store::storage::Storage;
use crate::types::{AbortCode, Address};

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

    #[inline(always)] // row `instructions.sdo_upload`: 30 more without it
    fn fetch(&mut self, at: Address) -> Result<Option<([u8; 4], u8)>, AbortCode> {
        let (place, entry) = self.place(at)?;
        if !entry.is_fetched() || at.index == PRE_DEFINED_ERRORS {
            return Ok(None);
        }
        let value = self.objects.variable(place).map(|variable| variable.bits() as u32);
        Ok(value.map(|value| (value.to_le_bytes(), entry.size as u8)))
    }

    #[inline(always)] // row `instructions.sdo_download`: 30 more without it
    fn store(&mut self, at: Address, bytes: [u8; 4], count: Option<u8>) -> Result<bool, AbortCode> {
        if at.index <= E::LAST_RULED || E::takes(at.index) || self.is_saving() {
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
        if self.is_saving() {
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
