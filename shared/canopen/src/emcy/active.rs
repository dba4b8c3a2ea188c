//! Errors of other nodes that are active, as a master knows them.

use super::{Emergency, ErrorCode, ErrorRegister};
use crate::od::Objects;
use crate::types::NodeId;

/// Errors that a consumer of emergencies keeps.
const PLACES: usize = 64;

/// An active error of another node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ActiveError {
    /// Node that reported the error.
    pub node: NodeId,
    /// Error code.
    pub code: ErrorCode,
    /// First byte of the manufacturer-specific field. Two errors with one code and two sources are different.
    pub source: u8,
}

impl ActiveError {
    /// Makes the value of an entry of object 2048h.
    const fn raw(self) -> u32 {
        (self.node.get() as u32) << 24 | (self.source as u32) << 16 | self.code.get() as u32
    }

    const fn from_raw(raw: u32) -> Option<ActiveError> {
        let Some(node) = NodeId::new((raw >> 24) as u8) else { return None };
        Some(ActiveError { node, code: ErrorCode::new(raw as u16), source: (raw >> 16) as u8 })
    }
}

/// Active errors of the other nodes, from their emergencies and from their objects 1001h and 1003h.
///
/// ```
/// use async_canopen::emcy::machine::{ActiveErrors, Config, Producer};
/// use async_canopen::emcy::{Emergency, ErrorCode};
/// use async_canopen::types::{Instant, NmtState};
///
/// let mut producer = Producer::new(Config::new(0x083, 0));
/// producer.raise(ErrorCode::TEMPERATURE_DEVICE, [1, 0, 0, 0, 0]);
/// let frame = producer.poll(Instant::ZERO, NmtState::Operational).unwrap();
///
/// let mut errors = ActiveErrors::default();
/// let (node, emergency) = Emergency::decode(&frame).unwrap();
/// errors.on_emergency(node, &emergency);
/// let error = errors.iter().next().unwrap();
/// assert_eq!((error.node, error.code, error.source), (node, ErrorCode::TEMPERATURE_DEVICE, 1));
/// ```
#[doc(alias("EMCY consumer", "2048h", "2049h"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Objects)]
pub struct ActiveErrors {
    /// Active errors of slaves
    ///
    /// Node-ID in bits 24 to 30, source in bits 16 to 23, error code in bits 0 to 15. Zero: no error.
    #[object(0x2048, array, ro)]
    errors: [u32; PLACES],
    /// Active errors not kept
    ///
    /// Errors of slaves for which 2048h had no room.
    #[object(0x2049, ro)]
    lost: u16,
}

impl ActiveErrors {
    /// Takes an emergency of a node. Returns `false` if there was no room for its error.
    ///
    /// Each message has the error register of its node. Errors whose class is not in it are over, also if their own end
    /// was not heard.
    pub fn on_emergency(&mut self, node: NodeId, emergency: &Emergency) -> bool {
        let [source, ..] = emergency.info;
        let reported = ActiveError { node, code: emergency.code, source };
        if let Some((code, source)) = emergency.ended() {
            self.remove(|error| *error == ActiveError { node, code, source });
        }
        let register = emergency.register;
        self.remove(|error| *error != reported && error.node == node && !is_possible(error.code, register));
        emergency.code == ErrorCode::NO_ERROR || self.add(reported)
    }

    /// Takes the error register of a node (1001h). Errors whose class is not in it are over. Returns whether the others
    /// explain it.
    pub fn on_register(&mut self, node: NodeId, register: ErrorRegister) -> bool {
        self.remove(|error| error.node == node && !is_possible(error.code, register));
        self.explain(node, register)
    }

    /// Returns whether the known errors of a node explain its error register.
    pub fn explain(&self, node: NodeId, register: ErrorRegister) -> bool {
        self.missing(node, register) == 0
    }

    /// Takes an entry of the history of a node (1003h) whose register is not explained, the newest first. The entry counts
    /// as active if it explains more of the register. Returns whether all of it is explained.
    pub fn on_history(&mut self, node: NodeId, register: ErrorRegister, entry: u32) -> bool {
        let (code, source) = (ErrorCode::new(entry as u16), (entry >> 16) as u8);
        let explains = ErrorRegister::of(code).bits() & self.missing(node, register) != 0;
        if explains && is_possible(code, register) {
            self.add(ActiveError { node, code, source });
        }
        self.explain(node, register)
    }

    /// Forgets the errors of a node.
    pub fn forget(&mut self, node: NodeId) {
        self.remove(|error| error.node == node);
    }

    /// Returns the active errors.
    pub fn iter(&self) -> impl Iterator<Item = ActiveError> {
        self.errors.iter().filter_map(|raw| ActiveError::from_raw(*raw))
    }

    /// Returns the number of active errors of a node.
    pub fn of(&self, node: NodeId) -> u8 {
        self.iter().filter(|error| error.node == node).count() as u8
    }

    /// Returns the number of errors for which there was no room.
    pub const fn lost(&self) -> u16 {
        self.lost
    }

    /// Returns the bits of a register that no known error of the node sets. The generic one counts only if there is no
    /// error at all: nodes of other makes set it by other rules.
    fn missing(&self, node: NodeId, register: ErrorRegister) -> u8 {
        let own = self.iter().filter(|error| error.node == node);
        let known = own.map(|error| ErrorRegister::of(error.code).and(ErrorRegister::GENERIC));
        register.bits() & !known.fold(ErrorRegister::default(), ErrorRegister::and).bits()
    }

    fn add(&mut self, error: ActiveError) -> bool {
        let raw = error.raw();
        if self.errors.contains(&raw) {
            return true;
        }
        let free = self.errors.iter_mut().find(|place| **place == 0);
        let is_kept = free.map(|place| *place = raw).is_some();
        self.lost = self.lost.saturating_add(u16::from(!is_kept));
        is_kept
    }

    fn remove(&mut self, is_over: impl Fn(&ActiveError) -> bool) {
        for place in &mut self.errors {
            if ActiveError::from_raw(*place).is_some_and(|error| is_over(&error)) {
                *place = 0;
            }
        }
    }
}

/// Returns whether an error may be active with this register: its class is in it.
fn is_possible(code: ErrorCode, register: ErrorRegister) -> bool {
    let class = ErrorRegister::of(code).bits() & !ErrorRegister::GENERIC.bits();
    register != ErrorRegister::default() && register.contains(ErrorRegister::from_bits(class))
}
