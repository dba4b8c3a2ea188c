//! Nodes of the demonstration mission in a world of the host.

use std::rc::Rc;

use ecss_can::boot::{AssignedSlave, Expected, Setting};
use ecss_can::profile::Profile;
use ecss_can::redundancy::Strap;
use ecss_can::types::{Address, NodeId};
use ecss_can_worlds::judge::Bounds;
use ecss_can_worlds::{NodeKey, Time, World};
use mission::application::slave;

use crate::campaign::application::{self, Errors};
use crate::campaign::notes::Notes;
use crate::campaign::rule::Rule;
use crate::campaign::script::{SELECTIVE, Script};

/// Slaves that the master configures in a script with `assigned`.
const ASSIGNED: [NodeId; 3] = [NodeId::of::<2>(), NodeId::of::<3>(), NodeId::of::<4>()];
/// Error behaviour (1029h), and the value that the master writes there.
const SETTING: Address = Address::new(0x1029, 1);
const SET: u8 = 1;

/// All slaves have parallel access.
const PARALLEL: Profile = mission::STANDARD;
const MIXED: Profile = Profile { selective: &[SELECTIVE], ..PARALLEL };
/// As [`PARALLEL`], with slaves 2 to 4 assigned and configured by the master.
const PARALLEL_ASSIGNED: Profile = assigned(PARALLEL);
const MIXED_ASSIGNED: Profile = assigned(MIXED);
/// All these profiles with two master boards.
static PAIRS: [Profile; 4] = [pair(PARALLEL), pair(MIXED), pair(PARALLEL_ASSIGNED), pair(MIXED_ASSIGNED)];

const _: Profile = pair(PARALLEL).checked();

const fn pair(profile: Profile) -> Profile {
    Profile { standby: Some(Profile::PAIR), ..profile }
}

const fn assigned(profile: Profile) -> Profile {
    const fn slave(node: NodeId) -> AssignedSlave {
        let expected = Expected { device_type: 0, identity: [0, 0x5015, 0, 0], stamp: [12_321, 43_200_000] };
        AssignedSlave { node, mandatory: false, expected }
    }
    const fn setting(node: NodeId) -> Setting {
        Setting { node, at: SETTING, value: &[SET] }
    }
    Profile {
        slaves: const { &[slave(ASSIGNED[0]), slave(ASSIGNED[1]), slave(ASSIGNED[2])] },
        settings: const { &[setting(ASSIGNED[0]), setting(ASSIGNED[1]), setting(ASSIGNED[2])] },
        ..profile
    }
}

/// Time that a command may wait in its bus task in addition to the lifetime of the profile.
const SLACK: Time = Time::from_ms(5);

/// Time from the last change of an error to the end of a run, in which all reports of a node arrive.
const LAST_ERROR: Time = Time::from_ms(5_000);

/// Returns the profile of a script.
pub fn profile(script: &Script) -> &'static Profile {
    let one = match (script.selective, script.assigned) {
        (false, false) => &PARALLEL,
        (true, false) => &MIXED,
        (false, true) => &PARALLEL_ASSIGNED,
        (true, true) => &MIXED_ASSIGNED,
    };
    let nth = usize::from(script.selective) + 2 * usize::from(script.assigned);
    if script.masters == 1 { one } else { &PAIRS[nth] }
}

/// Returns how long rules may be violated after the last fault of a script.
pub fn bounds(script: &Script) -> Bounds {
    let profile = profile(script);
    Bounds::new(&profile.redundancy(), profile.dwell, &profile.standby.unwrap_or(Profile::PAIR))
}

/// Returns how long after its creation a command may be executed.
pub fn lifetime(script: &Script) -> Time {
    Time::from_us(profile(script).event.as_micros()) + SLACK
}

/// Returns whether the master of a script configures this slave.
pub fn is_assigned(script: &Script, node: NodeId) -> bool {
    script.assigned && ASSIGNED.contains(&node)
}

/// Returns whether a slave has the value that the master writes.
pub fn is_configured(slave: &slave::Node) -> bool {
    slave.objects().communication.nmt.error_behaviour == [SET]
}

/// Makes a world with one or two masters, each of which commands all slaves in each period while it is active, and the
/// slaves. `broken`: a rule that is broken.
pub fn world(script: &Script, broken: Option<Rule>) -> (World, Rc<Notes>) {
    let (notes, profile) = (Rc::<Notes>::default(), profile(script));
    let profile = broken.map_or(*profile, |rule| rule.profile(profile));
    let ids: Vec<NodeId> = script.nodes().collect();
    let mut builder = if script.masters == 1 {
        let (all, theirs) = (ids.clone(), notes.clone());
        World::builder().master(
            move |_| mission::master(&profile).build(),
            move |master, events| {
                application::master(master, events, NodeKey::MASTER, all.clone(), theirs.clone())
            },
        )
    } else {
        let [first, second] = [NodeKey::MASTER, NodeKey::SECOND_MASTER].map(|key| {
            let (all, theirs) = (ids.clone(), notes.clone());
            move |master, events| application::master(master, events, key, all.clone(), theirs.clone())
        });
        let of_two = move |strap| mission::master(&profile).one_of_two(strap).build();
        let both = World::builder().master(move |_| of_two(Strap::Prime), first);
        both.board(NodeKey::SECOND_MASTER, move |_| of_two(Strap::Second), second)
    };
    let errors = Errors { seed: script.seed, until: Time::from_us(script.length).since(LAST_ERROR) };
    for id in ids {
        let theirs = notes.clone();
        builder = builder.slave(
            id,
            move |board| {
                let slave = mission::slave(board.node_id, &profile, Default::default());
                slave.hardware(board.hardware).late_heartbeats(0).build()
            },
            move |slave, events| {
                application::slave(slave, events, id, theirs.clone(), broken == Some(Rule::Repeats), errors)
            },
        );
    }
    if let Some(rule) = broken {
        builder = rule.world(builder, script, &notes);
    }
    (builder.seed(script.seed).build(), notes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given a fault late in a run of any profile. Then the run continues for the longest recovery time.
    #[test]
    fn a_run_leaves_time_for_every_recovery() {
        for masters in [1, 2] {
            for options in ["", " selective=1", " assigned=1"] {
                let text = format!("run masters={masters} slaves=3{options}\ncut at=50000000 place=3\n");
                let script: Script = text.parse().unwrap();
                let left = script.shortest_length() - 50_000_000;
                assert!(left > bounds(&script).service.as_micros(), "{text}{left} us");
            }
        }
    }
}
