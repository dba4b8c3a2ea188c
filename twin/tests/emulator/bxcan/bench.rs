//! Both controllers of a chip on one wire, next to plain stations.

use std::fmt::Debug;

use can_twin::bxcan::{Activity, BxcanPair, IrqLines, PclkTick, Side, Stats};
use can_twin::wire::bus::{Wire, WireConfig};
use can_twin::wire::controller::{Controller, Controllers, NodeIndex};
use can_twin::wire::fault::{Effect, Fault, Flip, Nodes, Place};
use can_twin::wire::field::Field;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::station::Station;
use can_twin::wire::time::Time;

pub const MCR: u32 = 0x000;
pub const MSR: u32 = 0x004;
pub const TSR: u32 = 0x008;
pub const RF0R: u32 = 0x00C;
pub const RF1R: u32 = 0x010;
pub const IER: u32 = 0x014;
pub const ESR: u32 = 0x018;
pub const BTR: u32 = 0x01C;
pub const TIR0: u32 = 0x180;
pub const RIR0: u32 = 0x1B0;
pub const RIR1: u32 = 0x1C0;
pub const FMR: u32 = 0x200;
pub const FM1R: u32 = 0x204;
pub const FS1R: u32 = 0x20C;
pub const FFA1R: u32 = 0x214;
pub const FA1R: u32 = 0x21C;
pub const BANKS: u32 = 0x240;
/// Registers of CAN2.
pub const BASE2: u32 = 0x400;

pub const INRQ: u32 = 1 << 0;
pub const SLEEP: u32 = 1 << 1;
pub const TXFP: u32 = 1 << 2;
pub const RFLM: u32 = 1 << 3;
pub const NART: u32 = 1 << 4;
pub const AWUM: u32 = 1 << 5;
pub const ABOM: u32 = 1 << 6;
pub const TTCM: u32 = 1 << 7;

pub const INAK: u32 = 1 << 0;
pub const SLAK: u32 = 1 << 1;
pub const ERRI: u32 = 1 << 2;
pub const WKUI: u32 = 1 << 3;
pub const TXM: u32 = 1 << 8;

/// Bits of mailbox 0; those of the others are 8 and 16 higher.
pub const RQCP: u32 = 1 << 0;
pub const TXOK: u32 = 1 << 1;
pub const ALST: u32 = 1 << 2;
pub const TERR: u32 = 1 << 3;
pub const STATUS: u32 = RQCP | TXOK | ALST | TERR;
pub const ABRQ: u32 = 1 << 7;
pub const TME0: u32 = 1 << 26;

pub const BOFF: u32 = 1 << 2;

/// Bits of RF0R and RF1R.
pub const RFOM: u32 = 1 << 5;

pub const LBKM: u32 = 1 << 30;
pub const SILM: u32 = 1 << 31;

/// 42 MHz PCLK1, prescaler 2, 21 time quanta: 1 Mbit/s.
pub const BTR_1M: u32 = 3 << 20 | 15 << 16 | 1;
/// One bit at 1 Mbit/s.
pub const BIT: u64 = 336;

/// Indices of the controllers and the stations on the wire.
pub const CAN1: NodeIndex = 0;
pub const CAN2: NodeIndex = 1;
pub const PEER: NodeIndex = 2;
pub const OTHER: NodeIndex = 3;

/// SOF to the last bit of EOF of a frame with identifier 080h and no data; with intermission it is 51 bits.
pub const EMPTY_BITS: u64 = 48;
/// Limit of waiting, longer than any frame.
const PATIENCE: Time = Time::from_ms(50);

/// PCLK1 of exactly 42 MHz.
pub fn pclk() -> PclkTick {
    PclkTick::new(8, 1)
}

pub fn bits(count: u64) -> Time {
    Time(count * BIT)
}

/// A standard data frame without data.
pub fn frame(id: u16) -> WireFrame {
    WireFrame::standard(id, &[])
}

pub fn empty() -> WireFrame {
    frame(0x080)
}

/// The controllers and the stations, in the order of the wire.
struct OnWire {
    pair: BxcanPair,
    stations: Vec<Station>,
}

impl Controllers for OnWire {
    fn visit(&mut self, node: NodeIndex, visit: &mut dyn FnMut(&mut dyn Controller)) {
        match node {
            CAN1 => visit(&mut self.pair.line(Side::Can1)),
            CAN2 => visit(&mut self.pair.line(Side::Can2)),
            _ => visit(&mut self.stations[node - PEER]),
        }
    }
}

/// A chip on its wire; `now` is the present of both.
pub struct Bench {
    nodes: OnWire,
    pub wire: Wire,
    pub now: Time,
}

impl Bench {
    /// After reset: asleep.
    pub fn asleep(stations: Vec<Station>) -> Self {
        let mut wire = Wire::new(WireConfig::default());
        (0..PEER + stations.len()).for_each(|_| {
            wire.attach(0.0);
        });
        Bench { nodes: OnWire { pair: BxcanPair::new(pclk()), stations }, wire, now: Time::ZERO }
    }

    /// CAN1 in initialisation, BTR set to 1 Mbit/s and `btr_bits`; every identifier will go to FIFO 0.
    pub fn initialising(stations: Vec<Station>, btr_bits: u32) -> Self {
        let mut bench = Bench::asleep(stations);
        bench.write(MCR, INRQ);
        bench.write(BTR, BTR_1M | btr_bits);
        bench.write(FMR, 1 | 14 << 8);
        bench.write(FS1R, 1);
        bench.write(FA1R, 1);
        bench.write(FMR, 14 << 8);
        bench
    }

    /// CAN1 asleep after initialisation, with these bits in MCR beside SLEEP; wake-up interrupts enabled.
    pub fn sent_to_sleep(mcr: u32) -> Self {
        let mut bench = Bench::initialising(vec![Station::default(), Station::default()], 0);
        bench.write(IER, 1 << 16);
        bench.write(MCR, SLEEP | mcr);
        bench.pass(bits(20));
        assert_eq!(bench.mode(), SLAK);
        bench
    }

    /// CAN1 in normal mode with these bits in MCR.
    pub fn with(stations: Vec<Station>, mcr: u32, btr_bits: u32) -> Self {
        let mut bench = Bench::initialising(stations, btr_bits);
        bench.write(MCR, mcr);
        bench.pass(bits(11));
        assert_eq!(bench.mode(), 0, "normal mode");
        bench
    }

    /// With two stations, PEER and OTHER.
    pub fn normal_with(mcr: u32, btr_bits: u32) -> Self {
        Bench::with(vec![Station::default(), Station::default()], mcr, btr_bits)
    }

    pub fn normal() -> Self {
        Bench::normal_with(0, 0)
    }

    /// Brings CAN2 to normal mode at 1 Mbit/s.
    pub fn start_can2(&mut self) {
        self.write(BASE2 + MCR, INRQ);
        self.write(BASE2 + BTR, BTR_1M);
        self.write(BASE2 + MCR, 0);
        self.pass(bits(11));
        assert_eq!(self.read(BASE2 + MSR) & (INAK | SLAK), 0, "normal mode");
    }

    pub fn pair(&mut self) -> &mut BxcanPair {
        &mut self.nodes.pair
    }

    pub fn read(&self, offset: u32) -> u32 {
        self.nodes.pair.read(offset).expect("a register")
    }

    pub fn write(&mut self, offset: u32, value: u32) {
        self.write_at(self.now, offset, value);
    }

    /// Writes at `at`, to which the CPU has run ahead of the wire.
    pub fn write_at(&mut self, at: Time, offset: u32, value: u32) {
        self.nodes.pair.write(offset, value, at).expect("a register");
    }

    /// Every identifier goes to this FIFO from now on.
    pub fn assign_to_fifo(&mut self, fifo: u32) {
        self.write(FMR, 1 | 14 << 8);
        self.write(FFA1R, fifo);
        self.write(FMR, 14 << 8);
    }

    /// Interrupt lines of CAN1.
    pub fn irq(&self) -> IrqLines {
        self.nodes.pair.irq(Side::Can1)
    }

    /// Statistics of CAN1.
    pub fn stats(&self) -> Stats {
        self.nodes.pair.stats(Side::Can1)
    }

    pub fn station(&mut self, node: NodeIndex) -> &mut Station {
        &mut self.nodes.stations[node - PEER]
    }

    /// Frames that a station has received.
    pub fn received_by(&self, node: NodeIndex) -> Vec<WireFrame> {
        self.nodes.stations[node - PEER].received().map(|(_, frame)| frame).collect()
    }

    /// Runs for `span`.
    pub fn pass(&mut self, span: Time) {
        let until = self.now + span;
        while self.now < until {
            self.step(until);
        }
    }

    /// Runs until `condition` holds.
    pub fn until(&mut self, what: &str, condition: impl Fn(&Bench) -> bool) {
        let limit = self.now + PATIENCE;
        while !condition(self) {
            assert!(self.now < limit, "waited in vain for {what}");
            self.step(self.now + bits(1));
        }
    }

    /// One quantum, as a board does it.
    fn step(&mut self, until: Time) {
        let requests = self.nodes.stations.iter().filter_map(Controller::request_at);
        let own = self.nodes.pair.next_event();
        let known = requests.chain(self.wire.next_event()).chain(own).filter(|&at| at > self.now).min();
        self.now = until.min(self.now + Time::from_us(20)).min(known.unwrap_or(until));
        self.wire.advance(self.now, &mut self.nodes);
        let pair = &mut self.nodes.pair;
        for (side, node) in [(Side::Can1, CAN1), (Side::Can2, CAN2)] {
            pair.hear(side, if self.wire.is_idle(node) { Activity::Idle } else { Activity::Busy });
        }
        pair.poll(self.now);
    }

    /// Runs for `span` and checks that `value` changes from `before` to `after` in its last tick.
    #[track_caller]
    pub fn changes_after<T: PartialEq + Debug>(
        &mut self,
        span: Time,
        value: impl Fn(&Bench) -> T,
        before: T,
        after: T,
    ) {
        self.pass(Time(span.0 - 1));
        assert_eq!(value(self), before, "a tick before the change");
        self.pass(Time(1));
        assert_eq!(value(self), after, "at the change");
    }

    /// Fills mailbox `n` with a standard data frame without data and requests it.
    pub fn request(&mut self, n: u32, id: u32) {
        self.request_at(self.now, n, id);
    }

    /// Fills mailbox `n` with TIR, TDTR, TDLR and TDHR, TIR last.
    pub fn fill(&mut self, n: u32, [tir, tdtr, low, high]: [u32; 4]) {
        for (word, value) in [(4, tdtr), (8, low), (12, high), (0, tir)] {
            self.write(TIR0 + 16 * n + word, value);
        }
    }

    pub fn request_at(&mut self, at: Time, n: u32, id: u32) {
        self.write_at(at, TIR0 + 16 * n + 4, 0);
        self.write_at(at, TIR0 + 16 * n, id << 21 | 1);
    }

    /// Status bits of mailbox `n`, as those of mailbox 0.
    pub fn status(&self, n: u32) -> u32 {
        self.read(TSR) >> (8 * n) & (STATUS | ABRQ)
    }

    /// Runs until the request in mailbox `n` has completed.
    pub fn complete(&mut self, n: u32) {
        self.until("RQCP", |bench| bench.status(n) & RQCP != 0);
    }

    /// Sends a standard data frame without data from mailbox 0.
    pub fn transmit(&mut self, id: u32) {
        self.request(0, id);
        self.complete(0);
    }

    /// Hands PEER a frame, to be sent as soon as the bus is free.
    pub fn send(&mut self, frame: WireFrame) {
        let now = self.now;
        self.station(PEER).queue.push_back((now, frame));
    }

    /// PEER sends a frame; returns at its end.
    pub fn deliver(&mut self, frame: WireFrame) {
        self.send(frame);
        self.until("the end of a frame", |bench| bench.nodes.stations[0].queue.is_empty());
    }

    /// Holds the bus with a frame of PEER, so that what is requested now contends at its end.
    pub fn occupy(&mut self) {
        self.send(empty());
        self.pass(bits(1));
    }

    /// Identifiers in FIFO 0, taken out one by one.
    pub fn drain(&mut self) -> Vec<u32> {
        let mut ids = Vec::new();
        while self.read(RF0R) & 0b11 != 0 {
            ids.push(self.read(RIR0) >> 21);
            self.write(RF0R, RFOM);
        }
        ids
    }

    /// Runs until error frames and intermission have ended.
    pub fn calm(&mut self) {
        self.until("a quiet bus", |bench| {
            (0..PEER + bench.nodes.stations.len()).all(|node| bench.wire.is_idle(node))
        });
        self.pass(bits(20));
    }

    pub fn fault(&mut self, fault: Fault) {
        self.wire.schedule(self.now, fault).expect("a possible fault");
    }

    /// Inverts the next bit that `node` sees in `field`.
    pub fn flip(&mut self, node: NodeIndex, field: Field) {
        self.fault(Fault::Flip(Flip::new(Place::Field(field), Nodes::of(&[node]))));
    }

    /// Gives CAN1 a dominant pulse of `count` bits.
    pub fn dominant_pulse(&mut self, count: u64) {
        let (nodes, duration) = (Nodes::of(&[CAN1]), bits(count));
        self.fault(Fault::Glitch { nodes, duration, effect: Effect::Dominant });
    }

    /// Shorts the bus to one level from now on.
    pub fn short(&mut self, level: bool) {
        self.fault(Fault::Short { position_m: 0.0, level });
    }

    /// Makes CAN1 bus-off at this instant with 100h in mailbox 0, by a bus that stays recessive.
    pub fn enter_bus_off(&mut self) {
        self.short(true);
        self.request(0, 0x100);
        self.until("bus-off", |bench| bench.flags() & BOFF != 0);
    }

    /// Restarts a station, with error counters of zero.
    pub fn renew(&mut self, node: NodeIndex) {
        let attachment = self.station(node).attachment.as_mut().expect("takes part");
        attachment.power_cycle += 1;
        self.pass(bits(12));
    }

    /// INAK and SLAK.
    pub fn mode(&self) -> u32 {
        self.read(MSR) & (INAK | SLAK)
    }

    pub fn tec(&self) -> u32 {
        self.read(ESR) >> 16 & 0xFF
    }

    pub fn rec(&self) -> u32 {
        self.read(ESR) >> 24
    }

    pub fn lec(&self) -> u32 {
        self.read(ESR) >> 4 & 0b111
    }

    /// BOFF, EPVF, EWGF.
    pub fn flags(&self) -> u32 {
        self.read(ESR) & 0b111
    }

    /// Makes the present or next attempt of CAN1 fail: it reads a dominant bit as recessive.
    pub fn fail_attempt(&mut self) {
        let before = self.tec();
        self.flip(CAN1, Field::Dlc(0));
        self.until("a transmit error", |bench| bench.tec() != before);
    }

    /// Makes a frame of PEER fail at PEER: all others see its error flag.
    pub fn fail_reception(&mut self) {
        self.renew(PEER);
        let before = self.rec();
        self.flip(PEER, Field::Dlc(0));
        self.station(PEER).single_shot = true;
        self.deliver(frame(0x123));
        self.calm();
        assert_ne!(self.rec(), before.min(254), "a receive error");
    }
}
