//! Object 2000h, and the rules for writing it.

use super::Parameters;
use crate::od::{Objects, Record};
use crate::types::{AbortCode, Address, Bus, Duration};

/// Objects of the redundancy (2000h).
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct RedundancyObjects {
    /// Redundancy
    #[object(0x2000, record)]
    pub parameters: Redundancy,
}

/// Redundancy parameters (2000h, ECSS 8.3.1).
///
/// Clients write them by SDO, and the redundancy follows. A PDO would change the value here and nothing else.
#[doc(alias("2000h", "Bdefault", "Ttoggle", "Ntoggle", "Ctoggle"))]
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
const CTOGGLE: Address = RedundancyObjects::PARAMETERS.field(Redundancy::CTOGGLE).address();

impl RedundancyObjects {
    /// Checks a `value` that a client writes. Accepts every value for objects of other services.
    ///
    /// # Errors
    /// [`AbortCode::ValueRange`] for a Bdefault that is no bus.
    pub(crate) fn may_write(at: Address, value: u32) -> Result<(), AbortCode> {
        let is_no_bus = at == BDEFAULT && Bus::from_bdefault(value as u8).is_none();
        if is_no_bus { Err(AbortCode::ValueRange) } else { Ok(()) }
    }
}

impl Redundancy {
    /// Returns the addresses of Bdefault and Ctoggle, as far as they differ from `before`.
    pub(crate) fn changes(&self, before: &Self) -> impl Iterator<Item = Address> + use<> {
        let bdefault = (self.bdefault != before.bdefault).then_some(BDEFAULT);
        let ctoggle = (self.ctoggle != before.ctoggle).then_some(CTOGGLE);
        [bdefault, ctoggle].into_iter().flatten()
    }

    /// Returns the parameters of a node with this consumer and this producer heartbeat time.
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
