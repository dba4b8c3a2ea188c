//! Services as parts of a node: when each of them is due at the earliest.

use super::buses::Buses;
use super::turn::Part;
use crate::boot::Boot;
use crate::emcy::{self, ErrorReader};
use crate::heartbeat::{ConsumerSlots, Monitor, NodeControl};
use crate::link::budget::Budget;
use crate::pdo::{PdoSlots, Rpdos, Tpdos};
use crate::sdo::Server;
use crate::sync;
use crate::types::{Instant, NmtState};

impl Part for Boot {
    fn earliest(&self) -> Option<Instant> {
        if self.is_due() { Some(Instant::ZERO) } else { self.deadline() }
    }
}

impl Part for ErrorReader {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

impl Part for sync::Producer {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

impl Part for Budget {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

impl Part for NodeControl {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

impl<S: ConsumerSlots> Part for Monitor<S> {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

impl<S: PdoSlots> Part for Rpdos<S> {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

impl<S: PdoSlots> Part for Tpdos<S> {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

/// The NMT state may forbid what it sends, for a time.
impl Part for emcy::Producer {
    fn earliest(&self) -> Option<Instant> {
        self.deadline(NmtState::Operational)
    }
}

impl Part for Server {
    #[inline] // row `instructions.sdo_upload`
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}

impl Part for Buses {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}
