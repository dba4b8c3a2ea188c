//! The task of a bus whose memory has a flipped bit.

extern crate alloc;

use alloc::boxed::Box;

use super::*;
use crate::link::port::{Busy, Filter};
use crate::node::probe::Probe;
use crate::node::{CanopenSlave, Settings};
use crate::runner::Diagnostics;
use crate::types::NodeId;

/// A controller without frames.
struct Silent;

impl CanPort for Silent {
    type PerMailbox<T: Default> = [T; 1];

    const FILTERS: usize = 1;

    fn set_filters(&mut self, _: &[Filter]) {}

    fn set_filter(&mut self, _: u8, _: Filter) {}

    fn join(&mut self) {}

    fn listen(&mut self) {}

    fn leave(&mut self) {}

    fn send(&mut self, _: &Frame) -> Result<Mailbox, Busy> {
        Err(Busy)
    }

    fn abort(&mut self, _: Mailbox) {}

    fn health(&self) -> Health {
        Health::default()
    }

    fn recover(&mut self) {}

    fn poll_event(&mut self, _: &mut Context<'_>) -> Poll<PortEvent> {
        Poll::Pending
    }
}

/// Given the task of a bus, when its bus or a copy of it flips, then it works for its bus after the next poll.
#[test]
fn flipped_bus_is_corrected_with_the_next_poll() {
    static DIAGNOSTICS: Diagnostics = Diagnostics::new();
    let flips: [fn(&mut BusState<Silent>); 3] = [
        |state| state.bus = state.bus.other(),
        |state| state.copies[0] = !state.copies[0],
        |state| state.copies[1] = !state.copies[1],
    ];
    for (bus, flip) in Bus::ALL.into_iter().flat_map(|bus| flips.map(|flip| (bus, flip))) {
        let slave = CanopenSlave::new(NodeId::of::<5>(), &Settings::DEFAULT, Probe::default());
        let mut shared = Shared::new(Box::leak(Box::new(slave)), &DIAGNOSTICS);
        let mut state = BusState::new(bus, Silent);
        state.poll_from(Instant::ZERO);
        flip(&mut state);
        state.on_time(&mut shared, Instant::ZERO + POLL);
        assert_eq!(state.bus, bus);
    }
}
