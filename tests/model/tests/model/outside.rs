//! Inputs of the redundancy from outside: the boot process and the controllers.

use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, NmtState};
use model::profile::{PARAMETERS, TICK};
use model::station::Station;
use model::watch::Watched;
use model::world::{Crew, Fault};

fn operational(state: &Watched) -> [bool; 2] {
    state.world.slaves.each_ref().map(|slave| slave.state() == NmtState::Operational)
}

/// Given a master whose controller goes bus-off too often on the active bus, then it changes the bus for that reason,
/// and the slaves follow.
///
/// Verifies: ECSS 8.3.3b
#[test]
fn a_failed_bus_is_left() {
    let mut state = Watched::new(Crew::OneMasterInUse, 1, None);
    while operational(&state) != [true; 2] {
        state.tick();
    }
    state.suffer(Fault::BusOff(Bus::Nominal));
    assert_eq!(state.world.masters[0].switched, Some(SwitchCause::BusOff));
    assert_eq!(state.world.masters[0].active(), Bus::Redundant);
    (0..40).for_each(|_| state.tick());
    assert_eq!(operational(&state), [true; 2]);
    assert!(state.world.slaves.iter().all(|slave| slave.active() == Bus::Redundant));
}

/// Given a master without a boot process, which starts slaves by their boot-up message, and one with it, then the
/// second one asks each slave at its first heartbeat, and starts it at its second one.
#[test]
fn a_slave_is_checked_before_it_is_started() {
    let [without, with] = [Crew::OneMaster, Crew::OneMasterInUse].map(|crew| {
        let mut state = Watched::new(crew, 0, None);
        let mut ticks = 0;
        while operational(&state) != [true; 2] {
            ticks += state.ticks();
            state.tick();
        }
        ticks
    });
    assert_eq!(TICK.times(with - without), PARAMETERS.producer.times(2));
}
