//! A run: executes the script in a world and judges the result.

use std::panic::{AssertUnwindSafe, catch_unwind};

use can_twin::wire::fault::{Effect, Fault as WireFault, Flip, Nodes, Place};
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;

use crate::campaign::judge::Judge;
use crate::campaign::kind::Kind;
use crate::campaign::outcome::{Effects, Outcome};
use crate::campaign::scene::{Scene, Seen};
use crate::campaign::script::{EOF, Fault, Script};

/// Interval at which nodes are checked.
const LOOK: Time = Time::from_ms(100);
/// Poll interval of a fault that waits for a frame, and longest wait.
const GLANCE: Time = Time::from_us(20);
const PATIENCE: Time = Time::from_ms(200);

/// Time after which the effect of a disturbance on a frame is known: the end of its error frame.
const ERROR_FRAME: Time = Time::from_ms(1);

/// Runs a script in the world that `scene` makes. A panic is a violation.
pub fn fly<S: Scene>(script: &Script, scene: impl FnOnce() -> S) -> Outcome {
    let flown = catch_unwind(AssertUnwindSafe(|| attempt(script, &mut scene())));
    flown.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        Outcome { violations: vec![format!("panic: {text}")], ..Outcome::default() }
    })
}

/// An action on the world.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Act {
    Begin,
    /// A frame of a foreign node.
    Send,
    End,
}

/// Planned actions, the next one last.
struct Plan(Vec<(Time, Act, usize)>);

impl Plan {
    fn new(script: &Script) -> Plan {
        let faults = script.faults.iter().enumerate();
        let mut plan =
            Plan(faults.map(|(index, fault)| (Time::from_us(fault.at), Act::Begin, index)).collect());
        plan.sort();
        plan
    }

    fn sort(&mut self) {
        self.0.sort_by_key(|(at, ..)| std::cmp::Reverse(*at));
    }

    fn next(&self) -> Time {
        self.0.last().map_or(Time::NEVER, |(at, ..)| *at)
    }

    fn take(&mut self, until: Time) -> Option<(Act, usize)> {
        self.0.pop_if(|(at, ..)| *at <= until).map(|(_, act, index)| (act, index))
    }

    /// Plans the further actions of a fault that begins now.
    fn begun(&mut self, now: Time, index: usize, fault: &Fault) {
        // Actions at the same instant are taken from the end.
        let mut rest = Vec::new();
        let to_look = if fault.kind == Kind::Glitch { ERROR_FRAME } else { Time::ZERO };
        rest.extend(fault.span().map(|span| (now + Time::from_us(span) + to_look, Act::End, index)));
        let frames = if fault.kind.is_foreign() { fault.times } else { 0 };
        let at = |nth: u32| now + Time::from_us(fault.every * u64::from(nth));
        rest.extend((0..frames).rev().map(|nth| (at(nth), Act::Send, index)));
        rest.append(&mut self.0);
        self.0 = rest;
        self.sort();
    }
}

fn attempt(script: &Script, scene: &mut impl Scene) -> Outcome {
    let mut seen = Seen::default();
    let mut judge = Judge::new(script);
    let mut effects = Effects::new(script);
    let mut plan = Plan::new(script);
    let mut lasting = Lasting::default();
    let end = Time::from_us(script.length);
    while scene.now() < end {
        let look = Time((scene.now().0 / LOOK.0 + 1) * LOOK.0);
        let next = plan.next().min(look).min(end).max(scene.now());
        scene.run_until(next);
        seen.read(scene);
        judge.look(scene, &seen);
        while let Some((act, index)) = plan.take(next) {
            let fault = &script.faults[index];
            if act == Act::Begin {
                wait_for_frame(scene, fault, end);
                seen.read(scene);
                let_pass(scene, &mut seen, fault, end);
                effects.begin(index, scene, &seen);
                plan.begun(scene.now(), index, fault);
            }
            perform(scene, fault, act, script.seed);
            match act {
                Act::Begin => lasting.begin(fault),
                Act::Send => {}
                Act::End => {
                    lasting.end(scene, fault, script.seed);
                    effects.end(index, scene, &seen);
                }
            }
        }
    }
    seen.read(scene);
    let effective = effects.finish(scene, &seen);
    judge.finish(scene, &seen, effective)
}

/// Active faults that last.
#[derive(Default)]
struct Lasting(Vec<Fault>);

impl Lasting {
    fn begin(&mut self, fault: &Fault) {
        if fault.kind.lasts() {
            self.0.push(*fault);
        }
    }

    /// Ends a fault. On the wire this ends all similar ones, so those that still last begin again.
    fn end(&mut self, scene: &mut impl Scene, ended: &Fault, seed: u64) {
        let Some(index) = self.0.iter().position(|fault| fault == ended) else { return };
        self.0.remove(index);
        for fault in self.0.iter().filter(|fault| fault.is_ended_with(ended)) {
            perform(scene, fault, Act::Begin, seed);
        }
    }
}

/// Waits for a frame, so that a fault of a wire begins in the middle of it.
fn wait_for_frame(scene: &mut impl Scene, fault: &Fault, end: Time) {
    let latest = (scene.now() + PATIENCE).min(end);
    while fault.in_frame && scene.now() < latest && !scene.is_busy(fault.bus) {
        let next = scene.now() + GLANCE;
        scene.run_until(next);
    }
}

/// Waits for the frames that a flip lets pass.
fn let_pass(scene: &mut impl Scene, seen: &mut Seen, fault: &Fault, end: Time) {
    let latest = (scene.now() + PATIENCE).min(end);
    let frames = seen.frames[fault.bus].len() + fault.times as usize;
    while fault.kind == Kind::Flip && scene.now() < latest && seen.frames[fault.bus].len() < frames {
        let next = scene.now() + GLANCE;
        scene.run_until(next);
        seen.read(scene);
    }
}

/// Begins a fault of a script now.
pub fn begin(scene: &mut impl Scene, script: &Script, index: usize) {
    perform(scene, &script.faults[index], Act::Begin, script.seed);
}

fn perform(scene: &mut impl Scene, fault: &Fault, act: Act, seed: u64) {
    let key = fault.key();
    match (act, fault.kind, key) {
        (Act::Send, ..) => scene.inject(fault.bus, foreign(fault)),
        (Act::Begin, Kind::ResetMaster | Kind::ResetSlave, Some(key)) if scene.is_powered(key) => {
            scene.reset(key)
        }
        (Act::Begin, Kind::PowerMaster | Kind::PowerSlave, Some(key)) => scene.power(key, false),
        (Act::End, Kind::PowerMaster | Kind::PowerSlave, Some(key)) => scene.power(key, true),
        _ => {
            let of_node = key.filter(|_| !fault.kind.is_foreign()).map(|key| scene.index(key));
            let [begin, end] = on_wire(fault, of_node, seed, scene.nodes());
            let wanted = if act == Act::Begin { begin } else { end };
            wanted.into_iter().for_each(|wanted| scene.strike(fault.bus, wanted));
        }
    }
}

/// Bytes that a babbling node sends with any COB-ID.
pub const BABBLED: [u8; 8] = [0x55; 8];

/// Returns a frame of a foreign node.
fn foreign(fault: &Fault) -> WireFrame {
    let id = 0x700 + u16::from(fault.node);
    match fault.kind {
        Kind::ForeignNmt => WireFrame::standard(0, &[fault.value as u8, fault.node]),
        Kind::ForeignLoad => WireFrame::standard(fault.value as u16 & 0x7FF, &[0x55; 8]),
        _ => WireFrame::standard(id, &[fault.value as u8]),
    }
}

/// Returns the wire's fault that begins a fault, and the one that ends it.
fn on_wire(fault: &Fault, node: Option<usize>, seed: u64, count: usize) -> [Option<WireFault>; 2] {
    let position_m = f64::from(fault.place);
    // Without the foreign node: it may never join, and a flip of its bit would stay pending.
    let all: Vec<usize> = (0..count).collect();
    let nodes = Nodes::of(node.as_ref().map_or(&all[..], std::slice::from_ref));
    let of = |fault: fn(usize) -> WireFault| node.map(fault);
    match fault.kind {
        Kind::Cut => [Some(WireFault::Cut { position_m }), Some(WireFault::Restore { position_m })],
        Kind::Short => [Some(WireFault::Short { position_m, level: true }), Some(WireFault::ClearShorts)],
        Kind::Dominant => [Some(WireFault::Short { position_m, level: false }), Some(WireFault::ClearShorts)],
        Kind::Disconnect => [of(WireFault::Disconnect), of(WireFault::Reconnect)],
        Kind::Noise => {
            let rate = 10_f64.powi(-(fault.value.clamp(3, 9) as i32));
            [Some(WireFault::BitErrors { rate, seed }), Some(WireFault::BitErrors { rate: 0.0, seed })]
        }
        Kind::Stuck => [of(WireFault::StuckDominant), of(WireFault::ReleaseDriver)],
        Kind::Babble => {
            let frame = WireFrame::standard(fault.value as u16 & 0x7FF, &BABBLED);
            [node.map(|node| WireFault::Babble(node, frame)), of(WireFault::StopBabbling)]
        }
        Kind::Drift => {
            let ppb = i32::try_from(u64::from(fault.value) * 1_000).unwrap_or(i32::MAX);
            [node.map(|node| WireFault::Drift(node, ppb)), node.map(|node| WireFault::Drift(node, 0))]
        }
        Kind::Glitch => {
            let effect = [Effect::Invert, Effect::Dominant, Effect::Recessive][fault.value as usize % 3];
            let duration = Time::from_us(fault.lasts.unwrap_or(1).max(1));
            [Some(WireFault::Glitch { nodes, duration, effect }), None]
        }
        Kind::Flip => {
            let place = match fault.value.checked_sub(EOF) {
                Some(bit) => Place::Field(Field::Eof(bit as u8 % 7)),
                None => Place::Bit(fault.value as usize),
            };
            [Some(WireFault::Flip(Flip::new(place, nodes))), None]
        }
        _ => [None, None],
    }
}
