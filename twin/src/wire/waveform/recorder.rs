//! Records the waveform of a wire while it runs.

use super::{Bit, Lane, Waveform};
use crate::wire::controller::NodeIndex;
use crate::wire::field::Field;
use crate::wire::fine::Fine;
use crate::wire::mac::{DOMINANT, RECESSIVE};
use crate::wire::node::Node;
use crate::wire::time::Time;

impl Waveform {
    /// Begins the record at `from` with the present state of `nodes`.
    pub(in crate::wire) fn begin(from: Time, to: Time, nodes: &[Node]) -> Self {
        let lane = |(index, node): (NodeIndex, &Node)| Lane {
            node: index,
            position_m: node.position_m,
            bit_time: node.mac.timing().bit_time(),
            counters: node.mac.counters,
            bits: Vec::new(),
            driver: vec![(from, if node.driving { DOMINANT } else { RECESSIVE })],
            line: vec![(from, node.level)],
            events: Vec::new(),
        };
        Waveform { from, to, lanes: nodes.iter().enumerate().map(lane).collect() }
    }

    /// Records the bit that ends at `node`.
    pub(in crate::wire) fn bit(
        &mut self,
        index: NodeIndex,
        node: &Node,
        field: Field,
        sampled: bool,
        flipped: bool,
    ) {
        let clock = &node.mac.clock;
        let stretch = i128::from((clock.end - clock.start).0) - i128::from(clock.bit.0);
        self.lanes[index].bits.push(Bit {
            start: clock.start.floor(),
            sample: clock.sample.floor(),
            end: clock.end.floor(),
            field,
            sampled,
            driven: if node.driving { DOMINANT } else { RECESSIVE },
            flipped,
            resynchronised: (stretch / i128::from(Fine::from_time(Time(1)).0)) as i64,
        });
    }

    /// Returns the waveform.
    pub(in crate::wire) fn finish(mut self) -> Waveform {
        // A node that joins an arbitration gets its start event a bit late.
        self.lanes.iter_mut().for_each(|lane| lane.events.sort_by_key(|&(at, _)| at));
        self
    }
}
