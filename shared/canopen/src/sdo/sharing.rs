//! Objects that two SDO servers would transfer at once.
//!
//! Both servers use one dictionary. A *long* object moves in parts between the client and its place in the dictionary: a
//! DOMAIN, and a string of more than 256 bytes that a client reads. While one server moves it, the other one refuses each
//! request that would mix two values:
//!
//! | one server | the other one refuses (0800 0022h) |
//! | --- | --- |
//! | writes a long object | to read and to write the same object |
//! | reads a long object | to write the same object |
//! | writes any object in more than one frame | to save and to restore parameters |

use crate::od::Transfer;
use crate::types::{AbortCode, Address};

/// Transfer of an object.
#[derive(Clone, Copy, Debug)]
pub struct Begun {
    at: Address,
    is_download: bool,
    /// `true`: the value moves in parts.
    is_long: bool,
}

/// Transfers that the dictionary knows during a call of one of two servers.
#[derive(Debug, Default)]
pub struct Shared {
    /// Running transfer of the other server.
    other: Option<Begun>,
    /// Transfer that begins in this call.
    begun: Option<Begun>,
}

impl Shared {
    /// Begins a call, with the running transfer of the other server.
    pub const fn of(other: Option<Begun>) -> Self {
        Shared { other, begun: None }
    }

    /// Returns the transfer that began in this call.
    pub const fn begun(self) -> Option<Begun> {
        self.begun
    }
}

/// Begins a transfer by `transfer`, the way in which the value moves. `shared` is empty without a second server.
///
/// # Errors
/// [`AbortCode::DeviceState`] if the other server moves the same value in parts, and one of both writes it.
#[inline] // rows `instructions.sdo_upload`, `instructions.sdo_download`
pub fn begin(
    shared: &mut [Shared],
    at: Address,
    transfer: Result<Transfer, AbortCode>,
    is_download: bool,
) -> Result<Transfer, AbortCode> {
    let Some(shared) = shared.first_mut() else { return transfer };
    let transfer = transfer?;
    let is_mixed = |other: Begun| other.is_long && other.at == at && (is_download || other.is_download);
    if shared.other.is_some_and(is_mixed) {
        return Err(AbortCode::DeviceState);
    }
    let is_long = matches!(transfer, Transfer::Stream(_));
    shared.begun = Some(Begun { at, is_download, is_long });
    Ok(transfer)
}

/// Checks that a save or a restore may begin. `shared` is empty without a second server.
///
/// # Errors
/// [`AbortCode::DeviceState`] while the other server writes: what a save stores does not change meanwhile.
pub fn may_save(shared: &[Shared]) -> Result<(), AbortCode> {
    let is_written = shared.iter().filter_map(|shared| shared.other).any(|other| other.is_download);
    if is_written { Err(AbortCode::DeviceState) } else { Ok(()) }
}
