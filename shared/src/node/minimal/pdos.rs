//! The PDOs of a minimal slave, hard-coded (ECSS 9.4.2 to 9.4.5).

use crate::pdo::CobIdOf;
use crate::types::{CobId, NodeId};

/// Number of PDOs in each direction (ECSS Table 9-1).
pub const PDOS: usize = 4;

/// Payload of a PDO, at most 8 bytes.
pub type Payload = heapless::Vec<u8, 8>;

/// Receive PDO of a minimal slave: commands, requests for telemetry, or both. Its transmission type is 254.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MinimalRpdo {
    /// COB-ID of the PDO.
    pub cob_id: CobIdOf,
    /// Least number of bytes, 0 to 8. A frame with fewer is a protocol error and is dropped (ECSS 9.4.8a).
    pub least: u8,
}

/// Transmit PDO of a minimal slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MinimalTpdo {
    /// COB-ID of the PDO.
    pub cob_id: CobIdOf,
    /// Event that makes the slave send the PDO.
    pub trigger: Trigger,
}

/// Event that makes a minimal slave send a transmit PDO. There is no other one (ECSS 9.4.3b).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Trigger {
    /// A request for telemetry: transmission type 254.
    Request,
    /// Every n-th SYNC, 1 to 240. The number is the transmission type.
    Sync(u8),
}

impl Trigger {
    /// Returns the transmission type.
    pub const fn transmission_type(self) -> u8 {
        match self {
            Trigger::Request => 254,
            Trigger::Sync(every) => every,
        }
    }
}

/// PDOs of a minimal slave. The first of a list is PDO 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MinimalPdos {
    /// Receive PDOs. `None`: not in use.
    pub receive: [Option<MinimalRpdo>; PDOS],
    /// Transmit PDOs. `None`: not in use.
    pub transmit: [Option<MinimalTpdo>; PDOS],
}

/// COB-IDs at power-on, by the pre-defined connection set.
const RECEIVE: [u16; PDOS] = [0x200, 0x300, 0x400, 0x500];
const TRANSMIT: [u16; PDOS] = [0x180, 0x280, 0x380, 0x480];

impl MinimalPdos {
    /// All eight PDOs with the COB-IDs of Tables 9-4 and 9-6: receive PDOs of any length, telemetry on request.
    pub const DEFAULT: MinimalPdos = MinimalPdos::by_tables();

    const fn by_tables() -> MinimalPdos {
        let mut pdos = MinimalPdos { receive: [None; PDOS], transmit: [None; PDOS] };
        let mut nth = 0;
        while nth < PDOS {
            pdos.receive[nth] = Some(MinimalRpdo { cob_id: CobIdOf::node(RECEIVE[nth]), least: 0 });
            let cob_id = CobIdOf::node(TRANSMIT[nth]);
            pdos.transmit[nth] = Some(MinimalTpdo { cob_id, trigger: Trigger::Request });
            nth += 1;
        }
        pdos
    }

    /// Stops the build if two PDOs of one direction have the same COB-ID in some node, or if a number is out of
    /// range.
    ///
    /// # Panics
    /// When called at run time, for the same reasons.
    #[track_caller]
    pub const fn assert_possible(&self) {
        let (mut received, mut sent) = ([None; PDOS], [None; PDOS]);
        let mut nth = 0;
        while nth < PDOS {
            if let Some(pdo) = &self.receive[nth] {
                assert!(pdo.least <= 8, "a PDO has 8 bytes at most");
                received[nth] = Some(pdo.cob_id);
            }
            if let Some(pdo) = &self.transmit[nth] {
                if let Trigger::Sync(every) = pdo.trigger {
                    assert!(every >= 1 && every <= 240, "every 1 to 240 SYNCs");
                }
                sent[nth] = Some(pdo.cob_id);
            }
            nth += 1;
        }
        assert_distinct(&received);
        assert_distinct(&sent);
    }

    /// Returns the receive PDO with this COB-ID in `node`, and its number: 0 is the first.
    pub(super) fn received(&self, id: CobId, node: NodeId) -> Option<(usize, &MinimalRpdo)> {
        let pdos = self.receive.iter().enumerate().filter_map(|(nth, pdo)| Some((nth, pdo.as_ref()?)));
        pdos.into_iter().find(|(_, pdo)| pdo.cob_id.of(node) == id)
    }

    /// Returns whether SYNC makes any of them go out.
    pub(super) fn follows_sync(&self) -> bool {
        self.transmit.iter().flatten().any(|pdo| matches!(pdo.trigger, Trigger::Sync(_)))
    }
}

#[track_caller]
const fn assert_distinct(ids: &[Option<CobIdOf>; PDOS]) {
    let mut nth = 0;
    while nth < PDOS {
        let mut other = 0;
        while other < nth {
            if let (Some(one), Some(another)) = (ids[nth], ids[other]) {
                assert!(!one.may_equal(another), "two PDOs have one COB-ID");
            }
            other += 1;
        }
        nth += 1;
    }
}
