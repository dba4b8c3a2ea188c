//! Scripts: the faults of a run, from a seed or from a file.

use std::ops::{Range, RangeInclusive};

use clap::ValueEnum;
use ecss_can::types::{Bus, NodeId};
use ecss_can_worlds::NodeKey;
use fastrand::Rng;

use crate::campaign::kind::Kind;

mod text;

const SECOND: u64 = 1_000_000;
/// Earliest begin of a fault: all nodes are operational. Microseconds.
const FIRST_US: u64 = 3 * SECOND;
/// Latest begin of the first fault, microseconds.
const LAST_US: u64 = 20 * SECOND;
/// Longest duration of a fault that ends, microseconds.
const LONGEST_US: u64 = 8 * SECOND;
/// Longest duration of a fault during which the wire computes every bit, microseconds.
const LONGEST_SLOW_US: u64 = SECOND;
/// Time for recovery after the last fault, microseconds: two dwells of a master that hears no slave, and a search.
const RECOVERY_US: u64 = 30 * SECOND;
/// Longest time between two related faults, microseconds.
const RELATED_US: u64 = SECOND;
/// Shortest run, microseconds.
const SHORTEST_US: u64 = 60 * SECOND;
/// A Node-ID that few scripts have among their slaves.
pub const UNUSED_NODE: u8 = 127;
/// The second one of two master boards in a script. It is no Node-ID: both boards are node 1.
pub const SECOND_BOARD: u8 = 128;
/// The slave that has selective access in some scripts.
pub const SELECTIVE: NodeId = NodeId::of::<4>();
/// Distance between neighbours on the cable, metres: node n is at n times this.
pub const SPACING: u32 = 2;
/// Greatest distance between a node and a fault beside it, metres.
const BESIDE: u32 = SPACING / 2;
/// Value of a flip from which on it inverts a bit of EOF; lower values are bits of the frame.
pub const EOF: u32 = 60;
const LAST_BIT_OF_EOF: u32 = EOF + 6;

/// One fault. Fields that its kind does not use are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Begin, microseconds from power-on.
    pub at: u64,
    /// Duration, microseconds; `None`: for ever, or no duration if its kind does not last.
    pub lasts: Option<u64>,
    /// Kind of the fault.
    pub kind: Kind,
    /// Bus of the fault.
    pub bus: Bus,
    /// Affected node; 0 is all nodes, [`SECOND_BOARD`] is the second master board.
    pub node: u8,
    /// Metres from the left end of the cable; see [`Script::place`].
    pub place: u32,
    /// A number with a meaning of its kind: COB-ID, NMT command, state, ppm, bit, effect, exponent of a rate.
    pub value: u32,
    /// Number of frames that a foreign node sends, or that pass on the bus before a flip takes effect.
    pub times: u32,
    /// Microseconds between two frames.
    pub every: u64,
    /// The fault waits up to 200 ms for a frame at the master and begins in the middle of it.
    pub in_frame: bool,
}

/// A run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Script {
    /// Seed of clocks, power-on times and random bit errors.
    pub seed: u64,
    /// Number of master boards: one, or two of which one is the standby.
    pub masters: u8,
    /// Number of slaves: nodes 2, 3, and so on.
    pub slaves: u8,
    /// [`SELECTIVE`] has selective access; all others have parallel access.
    pub selective: bool,
    /// The master configures slaves 2 to 4; otherwise it starts all slaves without configuration.
    pub assigned: bool,
    /// Length in microseconds.
    pub length: u64,
    /// Faults in the order of their begin.
    pub faults: Vec<Fault>,
}

impl Script {
    /// Returns a script of run `number` of a campaign: one fault, or two in every second run. In every fourth run the
    /// two are related ([`Script::is_related`]). `attempt`: from 0; each attempt gives another script.
    pub fn random(campaign: u64, number: u64, attempt: u64) -> Script {
        let seed = campaign.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number);
        let mut rng = Rng::with_seed(seed.wrapping_add(attempt.wrapping_mul(0xD1B5_4A32_D192_ED03)));
        let slaves = match rng.u8(0..32) {
            0 => 14,
            _ => rng.u8(2..=6),
        };
        Script::of(&mut rng, slaves, number)
    }

    /// Returns script `number` with faults of these kinds.
    pub fn of_kinds(campaign: u64, number: u64, first: Kind, second: Option<Kind>) -> Script {
        let seed = campaign.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number);
        let mut rng = Rng::with_seed(seed);
        let slaves = rng.u8(2..=6);
        Script::with(&mut rng, slaves, first, second.is_some(), |_| second)
    }

    /// As [`Script::random`], for a spacecraft of two slaves with parallel access that are not configured.
    pub fn small(campaign: u64, number: u64, attempt: u64) -> Script {
        let seed = campaign.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number);
        let mut rng = Rng::with_seed(seed.wrapping_add(attempt.wrapping_mul(0xD1B5_4A32_D192_ED03)));
        Script { selective: false, assigned: false, ..Script::of(&mut rng, 2, number) }
    }

    fn of(rng: &mut Rng, slaves: u8, number: u64) -> Script {
        if number % 4 == 3 {
            let faults = related(rng, slaves, number as usize / 4);
            return Script::with_faults(rng, slaves, faults.into());
        }
        let kinds = Kind::value_variants();
        let first = kinds[number as usize / 2 % kinds.len()];
        Script::with(rng, slaves, first, number % 2 == 1, |rng| Some(kinds[rng.usize(..kinds.len())]))
    }

    fn with(
        rng: &mut Rng,
        slaves: u8,
        first: Kind,
        is_double: bool,
        second: impl Fn(&mut Rng) -> Option<Kind>,
    ) -> Script {
        let anywhere = 1..=slaves + 1;
        let mut faults = vec![fault(rng, first, slaves, anywhere.clone(), FIRST_US..LAST_US)];
        let second = if is_double { second(rng) } else { None };
        if let Some(second) = second {
            let from = faults[0].at;
            let span = if rng.bool() { SECOND / 5 } else { 12 * SECOND };
            faults.push(fault(rng, second, slaves, anywhere, from..from + span));
        }
        let mut script = Script::with_faults(rng, slaves, faults);
        if let [Fault { lasts: None, .. }, _] = script.faults[..]
            && rng.bool()
        {
            script.foreign_node_on_a_dead_bus(rng);
        }
        script
    }

    fn with_faults(rng: &mut Rng, slaves: u8, faults: Vec<Fault>) -> Script {
        let (seed, selective, assigned) = (rng.u64(..), rng.bool(), rng.u8(0..4) == 0);
        let mut script = Script { seed, masters: 1, slaves, selective, assigned, length: 0, faults };
        script.length = script.shortest_length();
        script
    }

    /// Makes the first fault separate the master from all slaves for ever, and a foreign node there reset these slaves,
    /// or send the heartbeat of the master, until the end.
    fn foreign_node_on_a_dead_bus(&mut self, rng: &mut Rng) {
        let [first, second] = &mut self.faults[..] else { return };
        let separates = matches!(first.kind, Kind::Cut | Kind::Short | Kind::Disconnect);
        if separates && matches!(second.kind, Kind::ForeignNmt | Kind::ForeignMaster) {
            match first.kind {
                Kind::Disconnect => first.node = 1,
                Kind::Cut => first.place = 3,
                _ => first.place = 2,
            }
            second.bus = first.bus;
            if second.kind == Kind::ForeignNmt {
                (second.node, second.value) = (0, [0x81, 0x82][rng.usize(..2)]);
            }
            second.every = rng.u64(20_000..200_000);
            second.times = (self.length.saturating_sub(second.at) / second.every) as u32;
        }
    }

    /// Returns the same script with a second master board at the other end of the cable. Half of the faults of the
    /// first board move to the second one, some faults of the cable move beside it, and a master may lose its power for
    /// ever. Related faults remain related.
    #[must_use]
    pub fn with_standby(mut self) -> Script {
        let mut rng = Rng::with_seed(!self.seed);
        let is_related = self.is_related();
        self.masters = 2;
        if is_related {
            self.move_to_standby(&mut rng);
        } else {
            self.spread_to_standby(&mut rng);
        }
        for fault in self.faults.iter_mut().filter(|fault| fault.kind == Kind::PowerMaster) {
            if rng.u8(0..3) == 0 {
                fault.lasts = None;
            }
        }
        self.length = self.length.max(self.shortest_length());
        self
    }

    fn spread_to_standby(&mut self, rng: &mut Rng) {
        let end = self.slaves + 2;
        let place = self.place(SECOND_BOARD);
        for fault in &mut self.faults {
            let is_masters = fault.node == 1 && !fault.kind.is_foreign();
            if is_masters && rng.bool() {
                fault.node = SECOND_BOARD;
            }
            match fault.kind {
                Kind::Cut if rng.u8(1..end) == 1 => fault.place = place - 1,
                Kind::Short | Kind::Dominant if rng.u8(1..=end) == 1 => fault.place = place,
                _ => {}
            }
        }
    }

    /// In half of the cases, moves both faults from the first master board to the second one.
    fn move_to_standby(&mut self, rng: &mut Rng) {
        let (first, second) = (self.place(1), self.place(SECOND_BOARD));
        let is_beside = |fault: &Fault| self.spot(fault).is_some_and(|spot| spot.abs_diff(first) <= BESIDE);
        if !self.faults.iter().all(is_beside) || rng.bool() {
            return;
        }
        for fault in &mut self.faults {
            if fault.kind.has_place() {
                // The cable behind the first board corresponds to that before the second one.
                fault.place = first + second - fault.place;
            } else {
                fault.node = SECOND_BOARD;
            }
        }
    }

    /// Returns whether both faults may have one cause: they affect the same node, its stub or the cable beside it,
    /// within a second.
    pub fn is_related(&self) -> bool {
        let [first, second] = &self.faults[..] else { return false };
        let (Some(one), Some(other)) = (self.spot(first), self.spot(second)) else { return false };
        first.at.abs_diff(second.at) <= RELATED_US && one.abs_diff(other) <= BESIDE
    }

    /// Returns the position of a fault, metres from the left end of the cable; `None`: a whole bus, or frames of a
    /// foreign node.
    fn spot(&self, fault: &Fault) -> Option<u32> {
        if fault.kind.has_place() {
            return Some(fault.place);
        }
        let strikes_node = !fault.kind.is_foreign() && fault.node > 0;
        strikes_node.then(|| self.place(fault.node))
    }

    /// Returns the position of a node, metres from the left end of the cable. The second master board is behind the
    /// last slave.
    pub fn place(&self, node: u8) -> u32 {
        SPACING * u32::from(if node == SECOND_BOARD { self.slaves + 2 } else { node })
    }

    /// Checks that each fault has an effect.
    ///
    /// # Errors
    /// The first fault without effect: the reason, and the allowed values.
    pub fn check(&self) -> Result<(), String> {
        let wrong = self.faults.iter().find_map(|fault| Some((fault, self.why_idle(fault)?)));
        wrong.map_or(Ok(()), |(fault, why)| Err(format!("`{fault}` does nothing: {why}")))
    }

    /// Returns the reason why a fault has no effect, if so.
    fn why_idle(&self, fault: &Fault) -> Option<String> {
        let (first, last) =
            (self.place(1), self.place(if self.masters == 2 { SECOND_BOARD } else { self.slaves + 1 }));
        if fault.at >= self.length {
            return Some(format!("the run ends at {}; give an earlier at or a longer length", self.length));
        }
        match fault.kind {
            Kind::Cut if fault.place <= first || fault.place > last => {
                Some(format!("no node is on one side of the cut; allowed are places {} to {last}", first + 1))
            }
            Kind::Drift if fault.value == 0 => Some("value is the drift in ppm, at least 1".into()),
            kind if kind.is_foreign() && fault.times == 0 => {
                Some("times is the number of frames, at least 1".into())
            }
            kind if kind.lasts() && fault.lasts == Some(0) => {
                Some("lasts is a time in microseconds, at least 1".into())
            }
            _ => None,
        }
    }

    /// Node-IDs of the slaves, ascending.
    pub fn nodes(&self) -> impl Iterator<Item = NodeId> {
        (2..=self.slaves + 1).filter_map(NodeId::new)
    }

    /// Returns the length that leaves time for recovery. A foreign node that sends for more than 16 s continues to the
    /// end.
    pub fn shortest_length(&self) -> u64 {
        let ends = self.faults.iter().map(|fault| fault.end().unwrap_or(fault.at));
        let endings = ends.zip(&self.faults).filter(|(_, fault)| !fault.is_endless()).map(|(end, _)| end);
        SHORTEST_US.max(endings.max().unwrap_or(0) + RECOVERY_US)
    }
}

impl Fault {
    /// Returns the affected board; `None` is all boards.
    pub fn key(&self) -> Option<NodeKey> {
        match self.node {
            SECOND_BOARD => Some(NodeKey::SECOND_MASTER),
            node => NodeId::new(node).map(NodeKey::from),
        }
    }

    /// Returns the microseconds from its begin to its end; `None`: for ever.
    pub fn span(&self) -> Option<u64> {
        if self.kind.lasts() { self.lasts } else { Some(self.every * u64::from(self.times)) }
    }

    /// Returns its end; `None`: never.
    pub fn end(&self) -> Option<u64> {
        self.span().map(|span| self.at + span)
    }

    /// Returns whether the end of another fault ends this one as well: both are on the same bus, or of the same node.
    pub fn is_ended_with(&self, other: &Fault) -> bool {
        let class = |kind: Kind| match kind {
            Kind::Dominant => Kind::Short,
            kind => kind,
        };
        let is_alike = class(self.kind) == class(other.kind) && self.kind != Kind::Glitch;
        is_alike && if self.kind.is_of_node() { self.node == other.node } else { self.bus == other.bus }
    }

    /// Returns whether it is a foreign node that sends to the end of the run.
    fn is_endless(&self) -> bool {
        self.kind.is_foreign() && self.span().is_some_and(|span| span > 2 * LONGEST_US)
    }
}

/// Returns two faults with one cause, such as a jolt of a connector: see [`Script::is_related`]. `number` counts such
/// scripts.
fn related(rng: &mut Rng, slaves: u8, number: usize) -> [Fault; 2] {
    let local = Kind::local();
    let first = local[number % local.len()];
    let node = match first {
        Kind::ResetMaster | Kind::PowerMaster => 1,
        Kind::ResetSlave | Kind::PowerSlave => rng.u8(2..=slaves + 1),
        _ => rng.u8(1..=slaves + 1),
    };
    let other =
        if node == 1 { [Kind::ResetSlave, Kind::PowerSlave] } else { [Kind::ResetMaster, Kind::PowerMaster] };
    // In half of the cases one fault of the wires and one of the node.
    let is_mixed = rng.bool();
    let may_follow =
        |kind: &Kind| !other.contains(kind) && (!is_mixed || kind.is_of_node() != first.is_of_node());
    let seconds: Vec<Kind> = local.into_iter().filter(may_follow).collect();
    let second = seconds[rng.usize(..seconds.len())];
    // At the same time, within 200 ms, or within a second: each in a third of the cases.
    let span = [1, RELATED_US / 5, RELATED_US][rng.usize(..3)];
    let mut strike = |kind, at| {
        let mut fault = fault(rng, kind, slaves, node..=node, at);
        if matches!(kind, Kind::Glitch | Kind::Flip) {
            fault.node = node;
        }
        fault
    };
    let first = strike(first, FIRST_US..LAST_US);
    [first, strike(second, first.at..first.at + span)]
}

/// Returns a fault of this kind. A fault of a node or of the cable affects one of `nodes`, or the cable beside it.
fn fault(rng: &mut Rng, kind: Kind, slaves: u8, nodes: RangeInclusive<u8>, at: Range<u64>) -> Fault {
    // Mostly on the bus that is in use.
    let bus = if rng.u8(0..5) == 0 && !kind.is_of_node() { Bus::Redundant } else { Bus::Nominal };
    let (from, to) = nodes.into_inner();
    let slave = rng.u8(from.max(2)..=to.max(2));
    let any = rng.u8(from..=to);
    // From a millisecond to the longest, with a logarithmic distribution.
    let longest = if kind.is_slow() { LONGEST_SLOW_US } else { LONGEST_US };
    let lasts = (1_000.0 * (longest as f64 / 1_000.0).powf(rng.f64())) as u64;
    let stays = kind.may_stay() && rng.u8(0..3) == 0;
    let mut fault = Fault {
        at: rng.u64(at),
        lasts: (kind.lasts() && !stays).then_some(lasts),
        kind,
        bus,
        node: 0,
        place: 0,
        value: 0,
        times: 0,
        every: 0,
        in_frame: !kind.is_foreign() && !kind.is_of_node() && kind != Kind::Flip && rng.u8(0..3) > 0,
    };
    match kind {
        Kind::Cut => {
            let left = rng.u8((from - 1).max(1)..=to.min(slaves));
            fault.place = SPACING * u32::from(left) + BESIDE;
        }
        Kind::Short | Kind::Dominant => fault.place = SPACING * u32::from(any),
        Kind::Disconnect | Kind::Stuck => fault.node = any,
        // Bit error rates of 1e-4 and 1e-5.
        Kind::Noise => fault.value = rng.u32(4..=5),
        Kind::Babble => (fault.node, fault.value) = (any, babbled(rng, any)),
        Kind::Drift => (fault.node, fault.value) = (any, rng.u32(20_000..200_000)),
        Kind::Glitch => {
            fault.node = if rng.bool() { 0 } else { any };
            fault.value = rng.u32(0..3);
            fault.lasts = Some(rng.u64(10..20_000));
        }
        Kind::Flip => {
            (fault.node, fault.value) = (if rng.bool() { 0 } else { any }, rng.u32(0..EOF));
            // In EOF, so that the sender repeats a frame that receivers have accepted.
            if rng.u8(0..3) == 0 {
                (fault.node, fault.value) = (if rng.bool() { 1 } else { any }, LAST_BIT_OF_EOF);
                // The first frame of a burst is SYNC; commands follow.
                fault.times = rng.u32(0..8);
            }
        }
        Kind::ForeignNmt => {
            fault.node = if rng.bool() { 0 } else { slave };
            fault.value = [0x01, 0x80, 0x81, 0x82][rng.usize(..4)];
        }
        Kind::ForeignMaster => fault.node = 1,
        Kind::UnknownNode => (fault.node, fault.value) = (UNUSED_NODE, [0x05, 0x7F][rng.usize(..2)]),
        Kind::Clash => (fault.node, fault.value) = (slave, 0x05),
        Kind::ForeignLoad => (fault.value, fault.times) = (rng.u32(1..0x7FF), rng.u32(10..5_000)),
        Kind::ResetMaster | Kind::PowerMaster => fault.node = 1,
        Kind::ResetSlave | Kind::PowerSlave => fault.node = slave,
    }
    if kind.is_foreign() && kind != Kind::ForeignLoad {
        fault.times = rng.u32(1..=40);
        fault.every = rng.u64(1_000..250_000);
    }
    if kind == Kind::ForeignMaster {
        fault.value = 0x05;
    }
    fault
}

/// Returns the COB-ID that a node babbles: the highest or lowest priority, or one that the node or another one uses.
fn babbled(rng: &mut Rng, node: u8) -> u32 {
    let own = u32::from(node);
    let of_slave = [0x010, 0x080 + own, 0x180 + own, 0x380 + own, 0x700 + own, 0x080, 0x181, 0x7F0];
    of_slave[rng.usize(..of_slave.len())]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn script_is_read_as_it_was_written() {
        for number in 0..200 {
            let script = Script::random(7, number, 0);
            assert_eq!(script.to_string().parse(), Ok(script.clone()), "{script}");
            assert_eq!(script, Script::random(7, number, 0));
            assert_ne!(script, Script::random(7, number, 1));
            assert!(script.length >= 60_000_000);
            assert_eq!(script.faults.len(), 1 + number as usize % 2);
            assert!(number % 4 < 3 || script.is_related(), "{script}");
            let pair = script.clone().with_standby();
            assert_eq!(pair.to_string().parse(), Ok(pair.clone()), "{pair}");
            assert_eq!(pair.masters, 2);
            // Only faults that moved to the second board differ.
            for (one, two) in script.faults.iter().zip(&pair.faults) {
                let (node, place, lasts) = (one.node, one.place, one.lasts);
                assert_eq!(*one, Fault { node, place, lasts, ..*two });
            }
            assert!(number % 4 < 3 || pair.is_related(), "{pair}");
        }
    }

    /// Given 20,000 runs, then each pair of kinds that may affect one node occurs, in both orders, on the twin too.
    #[test]
    fn related_faults_come_in_every_pair_and_order() {
        type Draw = fn(u64, u64, u64) -> Script;
        for draw in [Script::random as Draw, Script::small as Draw] {
            let related = (0..20_000).map(|number| draw(5, number, 0)).filter(Script::is_related);
            let pairs: BTreeSet<_> = related.map(|script| [0, 1].map(|at| script.faults[at].kind)).collect();
            let local = Kind::local();
            let of_master = |kind| matches!(kind, Kind::ResetMaster | Kind::PowerMaster);
            let of_slave = |kind| matches!(kind, Kind::ResetSlave | Kind::PowerSlave);
            for (first, second) in local.iter().flat_map(|one| local.iter().map(|two| (*one, *two))) {
                let is_possible =
                    !(of_master(first) && of_slave(second) || of_slave(first) && of_master(second));
                assert_eq!(pairs.contains(&[first, second]), is_possible, "{first:?} {second:?}");
            }
        }
    }

    /// Given random scripts, then in some a slave loses its stub of the bus in use for ever, and is reset or loses its
    /// power: at the same time, and up to a second before and after, with one master and with two.
    #[test]
    fn related_faults_are_a_jolt_at_any_distance() {
        for standby in [false, true] {
            let script = |number| {
                let script = Script::random(5, number, 0);
                if standby { script.with_standby() } else { script }
            };
            let jolts = (0..40_000).map(script).filter_map(|script| {
                let stub = script.faults.iter().find(|fault| fault.kind == Kind::Disconnect)?;
                let restart = script
                    .faults
                    .iter()
                    .find(|fault| matches!(fault.kind, Kind::ResetSlave | Kind::PowerSlave))?;
                let is_jolt = script.is_related() && stub.lasts.is_none() && stub.bus == Bus::Nominal;
                is_jolt.then(|| (restart.at as i64 - stub.at as i64) / 1_000)
            });
            let jolts: BTreeSet<i64> = jolts.collect();
            for around in [-900, -500, -100, 0, 100, 500, 900] {
                let near = around - 100..=around + 100;
                assert!(jolts.range(near).next().is_some(), "{around} ms: {jolts:?}");
            }
            assert!(jolts.contains(&0));
        }
    }

    /// Node n is at 2 n metres.
    #[test]
    fn faults_are_related_within_a_second_and_a_metre() {
        let is_related = |faults: &str| {
            let script: Script = format!("run masters=2 slaves=3\n{faults}").parse().unwrap();
            script.is_related()
        };
        assert!(is_related("disconnect at=5000000 node=4\nreset-slave at=5000000 node=4"));
        assert!(is_related("reset-slave at=5000000 node=4\ndisconnect at=6000000 bus=redundant node=4"));
        assert!(!is_related("reset-slave at=5000000 node=4\ndisconnect at=6000001 node=4"));
        assert!(!is_related("disconnect at=5000000 node=3\nreset-slave at=5000000 node=4"));
        assert!(!is_related("disconnect at=5000000 node=4"));
        assert!(is_related("cut at=5000000 place=7\npower-slave at=5000000 node=4"));
        assert!(is_related("short at=5000000 place=10\nreset-master at=5000000 node=128"));
        assert!(!is_related("cut at=5000000 place=5\npower-slave at=5000000 node=4"));
        // They affect a whole bus.
        assert!(!is_related("noise at=5000000 value=4\nreset-slave at=5000000 node=4"));
        assert!(!is_related("glitch at=5000000 lasts=9 node=0\ncut at=5000000 place=1"));
        // It is not a fault of the node itself.
        assert!(!is_related("foreign-nmt at=5000000 node=4 value=129\nreset-slave at=5000000 node=4"));
    }

    /// Given one slave and one master at 4 m and 2 m, or two masters at 2 m and 6 m, then a script with a fault without effect is refused.
    #[test]
    fn fault_that_does_nothing_is_refused() {
        let said = |masters: u8, fault: &str| {
            let text = format!("run masters={masters} slaves=1 length=60000000\n{fault}\n");
            text.parse::<Script>().unwrap().check().err().unwrap_or_default()
        };
        for (masters, wrong, part) in [
            (1, "cut at=1 place=0", "no node is on one side of the cut; allowed are places 3 to 4"),
            (1, "cut at=1 place=2", "places 3 to 4"),
            (1, "cut at=1 place=5", "places 3 to 4"),
            (2, "cut at=1 place=7", "places 3 to 6"),
            (1, "short at=60000000", "the run ends at 60000000"),
            (1, "cut at=1 place=3 lasts=0", "lasts is a time in microseconds, at least 1"),
            (1, "power-slave at=1 node=2 lasts=0", "lasts is a time"),
            (1, "drift at=1 node=1", "value is the drift in ppm"),
            (1, "foreign-nmt at=1 value=1", "times is the number of frames, at least 1"),
        ] {
            assert!(said(masters, wrong).contains(part), "{wrong}: {}", said(masters, wrong));
        }
        for (masters, right) in [
            (1, "cut at=1 place=3"),
            (1, "cut at=1 place=4"),
            (2, "cut at=1 place=6"),
            (1, "reset-slave at=1 node=2"),
        ] {
            assert_eq!(said(masters, right), "", "{right}");
        }
        for number in 0..500 {
            let script = Script::random(7, number, 0);
            assert_eq!(script.check(), Ok(()));
            assert_eq!(script.with_standby().check(), Ok(()));
        }
    }
}
