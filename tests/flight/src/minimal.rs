//! Minimal slaves (ECSS 9) and the shipped master.

use std::collections::BTreeSet;
use std::sync::{Arc, LazyLock};

use can_twin::board::BoardConfig;
use can_twin::image::Image;
use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;

use crate::*;

pub const MINIMAL: u8 = 5;
/// Slave of profile `librecube` that takes part in one bus at a time.
pub const SELECTIVE: u8 = 6;

/// Bits of the longest frame.
const LONGEST: u64 = 135;
/// Time from the end of a request to the end of its telemetry, at 1 Mbit/s on a free bus.
pub const TELEMETRY_DELAY: Time = telemetry_delay(1_000);
/// Duration of commands, requests and replies of another slave that may be sent first.
pub const QUEUEING: Time = Time::from_us(3 * LONGEST);

/// The delay that docs/decisions/minimal-set.md states for a bit rate: 200 us for the processor of the slave, the longest frame on
/// its way, and the telemetry itself.
pub const fn telemetry_delay(kbit: u64) -> Time {
    Time::from_us(200 + 2 * LONGEST * 1_000 / kbit)
}

static STANDARD_PYBOARD: LazyLock<Arc<Image>> = LazyLock::new(|| minimal_image(PYBOARD_V11, "standard"));

/// The image of the minimal slave for a board and a profile, with its bit rate.
pub fn minimal_image(board: &str, profile: &str) -> Arc<Image> {
    parsed(&ecss_can_cli::images::build_minimal(board, profile, ecss_can_cli::images::LOG).unwrap())
}

pub const MASTER_SETUP: BoardSetup = MASTER_AND_THREE[0];
/// A minimal slave.
pub const SETUP: BoardSetup = BoardSetup { node: MINIMAL, ..MASTER_AND_THREE[2] };

/// A master and a minimal slave, profile `standard`.
pub const PAIR: [BoardSetup; 2] = [MASTER_SETUP, SETUP];

/// Pyboards, profile `standard`. Nodes from [`MINIMAL`] on have the image of the minimal slave.
pub fn standard(setups: &[BoardSetup]) -> Flight {
    Flight::of(setups, |setup| minimal(setup, setup.with(&STANDARD), &STANDARD_PYBOARD))
}

/// Nodes from [`MINIMAL`] on have the image of the minimal slave.
pub fn minimal(setup: BoardSetup, config: BoardConfig, image: &Arc<Image>) -> BoardConfig {
    if setup.node < MINIMAL { config } else { BoardConfig { image: image.clone(), ..config } }
}

/// As [`standard`], profile `librecube`, on any board.
pub fn librecube(setups: &[BoardSetup]) -> Flight {
    Flight::of(setups, |setup| minimal(setup, setup.config(), &minimal_image(setup.board, "librecube")))
}

/// COB-IDs that `node` has sent.
pub fn ids_of(flight: &Recording, node: u8) -> Vec<u16> {
    let ids: BTreeSet<u16> = flight.of(node).map(|seen| seen.id().unwrap()).collect();
    ids.into_iter().collect()
}

/// Time at which the nominal bus breaks next to the master in [`mixed`].
pub const MIXED_CUT: Time = ms(2_013);

/// A master, two full slaves, and two minimal ones: one on both buses, one with this board on one bus at a time (Figure A-6).
pub fn mixed(selective: &'static str) -> Recording {
    let flight = librecube(&[
        MASTER_SETUP,
        MASTER_AND_THREE[1],
        MASTER_AND_THREE[2],
        BoardSetup { node: MINIMAL, position_m: 15.0, power_on_ms: 170, ..MASTER_AND_THREE[2] },
        BoardSetup { node: SELECTIVE, board: selective, ..MASTER_AND_THREE[3] },
    ]);
    flight.cut_next_to_master(MIXED_CUT, 15_500)
}

/// Asserts that the slaves followed: those on both buses at the first message of the master on the other bus, the
/// selective one after Ttoggle consumer times of 2.5 s.
pub fn assert_slaves_followed(mixed: &Recording) {
    let moved = mixed.on(Bus::Redundant).find(|seen| seen.sender == 0).unwrap().end;
    assert!(moved < MIXED_CUT + ms(255), "{} us", moved.as_us());
    for node in [2, 3, MINIMAL] {
        let (followed, state) = mixed.heartbeats(node, Bus::Redundant)[0];
        assert!(followed > moved && followed < moved + ms(1), "node {node}: {} us", followed.as_us());
        assert_eq!(state, OPERATIONAL);
    }
    let last = mixed.heartbeats(MASTER, Bus::Nominal).last().unwrap().0;
    let (found, _) = mixed.heartbeats(SELECTIVE, Bus::Redundant)[0];
    let taken = found.since(last);
    assert!(about(ms(12_500), ms(625)).contains(&taken), "{} us", taken.as_us());
    mixed.assert_operational([MASTER, 2, 3, MINIMAL, SELECTIVE], Bus::Redundant);
}
