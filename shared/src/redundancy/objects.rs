//! Object 2000h, and what may be written to it.

use super::Parameters;
use crate::od::{Objects, Record};
use crate::types::{AbortCode, Address, Bus, Duration};

/// The object of redundancy.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct RedundancyObjects {
    /// Redundancy
    #[object(0x2000, record)]
    pub parameters: Redundancy,
}

/// Redundancy parameters (2000h, ECSS 8.3.1).
///
/// Written by SDO only, which the redundancy hears of; a PDO would change no more than the value here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct Redundancy {
    /// Bdefault
    ///
    /// 0 nominal, 1 redundant.
    #[sub(1, rwr, pdo)]
    pub bdefault: u8,
    /// Ttoggle
    ///
    /// Consumer times.
    #[sub(2, rw)]
    pub ttoggle: u8,
    /// Ntoggle
    #[sub(3, rw)]
    pub ntoggle: u8,
    /// Ctoggle
    ///
    /// Begins at zero (ECSS 8.3.2a).
    #[sub(4, rwr, pdo, volatile)]
    pub ctoggle: u8,
}

const BDEFAULT: Address = RedundancyObjects::PARAMETERS.field(Redundancy::BDEFAULT).address();

impl RedundancyObjects {
    /// Whether a client may write `value` there. Other objects are not refused.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for a Bdefault that is no bus.
    pub fn may_write(at: Address, value: u32) -> Result<(), AbortCode> {
        let is_no_bus = at == BDEFAULT && Bus::from_bdefault(value as u8).is_none();
        if is_no_bus { Err(AbortCode::ValueRange) } else { Ok(()) }
    }
}

impl Redundancy {
    /// The parameters of a node, with its consumer and its producer heartbeat time.
    pub fn parameters(&self, consumer: Duration, producer: Duration) -> Parameters {
        Parameters {
            consumer,
            producer,
            bdefault: Bus::from_bdefault(self.bdefault).unwrap_or(Bus::Nominal),
            ttoggle: self.ttoggle,
            ntoggle: self.ntoggle,
            ctoggle: self.ctoggle,
        }
    }
}

impl From<&Parameters> for Redundancy {
    fn from(parameters: &Parameters) -> Redundancy {
        Redundancy {
            bdefault: parameters.bdefault.bdefault(),
            ttoggle: parameters.ttoggle,
            ntoggle: parameters.ntoggle,
            ctoggle: parameters.ctoggle,
        }
    }
}
