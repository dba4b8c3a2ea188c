//! The bit path: simulates every node by its own clock and every level change with its delay.

use crate::wire::arrivals::{Arrival, Arrivals, Change, Next};
use crate::wire::calendar::Calendar;
use crate::wire::controller::NodeIndex;
use crate::wire::fine::Fine;
use crate::wire::mac::{DOMINANT, RECESSIVE, State, Transmission};
use crate::wire::segment::{Mode, Segment};
use crate::wire::stage::Stage;

impl Segment {
    /// Runs bit by bit. Returns `true` if nothing more happens up to `until`.
    pub(in crate::wire) fn run_bits(&mut self, until: Fine, stage: &mut Stage) -> bool {
        loop {
            if self.try_settle(stage) || self.try_take_off(stage) {
                return false;
            }
            if self.calendar.is_empty() {
                self.calendar = Calendar::of(self.members.iter().map(|&node| self.plans(node, stage)));
            }
            let (arrival, what) = self.arrivals().next();
            let (own, member) = self.calendar.own.first;
            self.next = own.min(arrival);
            if self.next > until || self.next == Fine::NEVER {
                let news = self.calendar.news();
                self.next = if news == Fine::NEVER { arrival } else { news };
                return true;
            }
            self.cursor = self.cursor.max(self.next);
            let member = if own <= arrival {
                self.bit_boundary(self.members[member], stage);
                member
            } else {
                let Some(node) = self.arrive(what, stage) else { continue };
                self.places[node]
            };
            let (own, news) = self.plans(self.members[member], stage);
            self.calendar.set(member, own, news);
        }
    }

    /// Returns the changes that propagate to the nodes.
    pub(in crate::wire) fn arrivals(&mut self) -> &mut Arrivals {
        match &mut self.mode {
            Mode::Bits(arrivals) => arrivals,
            _ => unreachable!("only called bit by bit"),
        }
    }

    /// Returns the instant of the next own action of `node`, and the earliest instant of an event for it. An unexpected
    /// error is reported some bits late.
    fn plans(&self, node: NodeIndex, stage: &mut Stage) -> (Fine, Fine) {
        let mac = &stage.nodes[node].mac;
        if mac.is_running() {
            return (mac.clock.end, mac.clock.end + mac.clock.bit.times(mac.uneventful_bits() - 1));
        }
        let start = if mac.state == State::Idle { self.start_of(node, stage) } else { None };
        let own = start.unwrap_or(Fine::NEVER);
        (own, own)
    }

    /// Handles the end of a bit of `node`, or the start of its own frame.
    fn bit_boundary(&mut self, node: NodeIndex, stage: &mut Stage) {
        if stage.nodes[node].mac.is_running() {
            self.step(node, self.cursor, stage);
        }
        // A frame that waits starts with the bit that begins idle.
        if stage.nodes[node].mac.state == State::Idle && self.start_of(node, stage) == Some(self.cursor) {
            match stage.contend(node, self.cursor) {
                Some(own) => self.begin(node, own, stage),
                None => self.withdrawn |= 1 << node,
            }
        }
        self.drive(node, stage);
    }

    /// Starts a frame of `node` now.
    pub(in crate::wire) fn begin(&mut self, node: NodeIndex, own: Transmission, stage: &mut Stage) {
        let at = own.start;
        stage.nodes[node].mac.start(own);
        let bit = stage.nodes[node].mac.clock.bit;
        self.ledger.start(at, bit, stage.observed);
        stage.started(&mut self.ledger, at, at, node);
    }

    /// Propagates the present level of the driver of `node` to all nodes of the segment.
    pub(in crate::wire) fn drive(&mut self, node: NodeIndex, stage: &mut Stage) {
        let this = &mut stage.nodes[node];
        let drives = this.wants_to_drive();
        let drives_others = drives && (!this.mac.is_silent() || this.condition.stuck_dominant);
        let itself = std::mem::replace(&mut this.driving, drives) != drives;
        let others = std::mem::replace(&mut this.driving_others, drives_others) != drives_others;
        if !itself && !others {
            return;
        }
        let again = std::mem::replace(&mut this.drove_at, self.cursor) == self.cursor;
        if itself && let Some(recorder) = &mut stage.recorder {
            let level = if drives { DOMINANT } else { RECESSIVE };
            recorder.lanes[node].driver.push((self.cursor.floor(), level));
        }
        for n in 0..self.members.len() {
            let member = self.members[n];
            let (changes, dominant) = if member == node { (itself, drives) } else { (others, drives_others) };
            if !changes {
                continue;
            }
            let at = self.cursor + stage.nodes[node].path_to(&stage.nodes[member]);
            let arrival = |level| Arrival { at, node: member, change: Change::Driver(level, node) };
            let seen = &mut stage.nodes[member].seen;
            let (level, cursor) = (if dominant { DOMINANT } else { RECESSIVE }, self.cursor);
            // A change back at the same instant cancels the first one.
            if !again || !self.arrivals().withdraw(arrival(!level), *seen) {
                self.arrivals().push(arrival(level), cursor, seen);
            }
        }
    }

    /// Handles an arrival now. Returns the node whose line it may change.
    fn arrive(&mut self, what: Next, stage: &mut Stage) -> Option<NodeIndex> {
        let at = self.cursor;
        let node = match what {
            Next::Turn(node) => node,
            Next::Glitch => {
                let Arrival { node, change, .. } = self.arrivals().take_glitch()?;
                let glitch = &mut stage.nodes[node].glitch;
                match change {
                    Change::GlitchBegins(effect) => *glitch.of(effect) += 1,
                    Change::GlitchEnds(effect) => *glitch.of(effect) -= 1,
                    Change::Driver(..) => {}
                }
                node
            }
            Next::Last => {
                let arrivals = self.arrivals();
                for node in arrivals.awaiting() {
                    arrivals.take_in(node, at, &mut stage.nodes[node].seen);
                }
                arrivals.end();
                return None;
            }
        };
        self.relevel(node, at, stage);
        Some(node)
    }

    /// Updates the line of `node` after a change at `at`.
    pub(in crate::wire) fn relevel(&mut self, node: NodeIndex, at: Fine, stage: &mut Stage) {
        let this = &mut stage.nodes[node];
        self.arrivals().take_in(node, at, &mut this.seen);
        let level = this.line();
        if std::mem::replace(&mut this.level, level) == level {
            return;
        }
        if let Some(recorder) = &mut stage.recorder {
            recorder.lanes[node].line.push((at.floor(), level));
        }
        if self.ledger.is_news(at) {
            this.record_change(at, level);
        }
        if level == DOMINANT {
            this.mac.dominant_edge(at);
        } else {
            this.mac.clock.recessive_edge(at);
        }
    }

    /// Changes to [`Mode::Still`] if nothing is in progress.
    fn try_settle(&mut self, stage: &mut Stage) -> bool {
        if !self.arrivals().is_empty() || !self.is_settled(stage) {
            return false;
        }
        self.ledger.calm(self.calm_at(stage), stage.observed);
        let counts = |&node: &NodeIndex| stage.nodes[node].mac.is_running();
        if (!stage.flips.is_empty() || stage.recorder.is_some()) && self.members.iter().any(counts) {
            // A flip may invert one of the bits; a recording needs each bit at its time.
            return false;
        }
        self.mode = Mode::Still;
        self.grounded = false;
        true
    }

    /// Returns the end of the intermission after the frame that has just ended.
    fn calm_at(&self, stage: &Stage) -> Fine {
        let ends = self.members.iter().filter_map(|&node| {
            let mac = &stage.nodes[node].mac;
            match mac.state {
                State::Intermission(bit) => Some(mac.clock.end + mac.clock.bit.times(u64::from(2 - bit))),
                _ => None,
            }
        });
        ends.max().unwrap_or(self.cursor)
    }
}
