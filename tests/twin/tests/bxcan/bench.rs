//! A pair of controllers and the hand that plays the wire.

use std::sync::Arc;

use can_wire::controller::{Controller, ErrorKind, Trace, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::bxcan::{BxcanPair, PclkTick, Side};

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

/// 42 MHz PCLK1, prescaler 2, 21 time quanta: 1 Mbit/s.
pub const BTR_1M: u32 = 3 << 20 | 15 << 16 | 1;
/// One bit at 1 Mbit/s.
pub const BIT: u64 = 336;
/// PCLK1 of exactly 42 MHz.
pub fn pclk() -> PclkTick {
    PclkTick::new(8, 1)
}

/// CAN1 of a pair, with the shorthands of the tests.
pub struct Bench {
    pub pair: BxcanPair,
    pub now: Time,
}

impl Bench {
    /// After reset: asleep.
    pub fn asleep() -> Self {
        Bench { pair: BxcanPair::new(pclk()), now: Time::ZERO }
    }

    /// In initialisation, BTR set to 1 Mbit/s and `btr_bits`.
    pub fn initialising(btr_bits: u32) -> Self {
        let mut bench = Bench::asleep();
        bench.write(MCR, 1);
        bench.write(BTR, BTR_1M | btr_bits);
        bench
    }

    /// In normal mode with these bits in MCR; every identifier goes to FIFO 0.
    pub fn normal_with(mcr: u32, btr_bits: u32) -> Self {
        let mut bench = Bench::initialising(btr_bits);
        bench.write(FMR, 1 | 14 << 8);
        bench.write(FS1R, 1);
        bench.write(FA1R, 1);
        bench.write(FMR, 14 << 8);
        bench.write(MCR, mcr);
        bench.pass(Time(11 * BIT));
        assert_eq!(bench.read(MSR) & 0b11, 0, "normal mode");
        bench
    }

    pub fn normal() -> Self {
        Bench::normal_with(0, 0)
    }

    pub fn read(&self, offset: u32) -> u32 {
        self.pair.read(offset).expect("a register")
    }

    pub fn write(&mut self, offset: u32, value: u32) {
        self.pair.write(offset, value, self.now).expect("a register");
    }

    /// Lets time pass on an undisturbed line.
    pub fn pass(&mut self, span: Time) {
        self.now += span;
        self.pair.poll(self.now);
    }

    pub fn event(&mut self, event: WireEvent) {
        self.pair.line(Side::Can1).on_wire(self.now, &event);
    }

    pub fn started(&mut self) {
        self.event(WireEvent::Started);
    }

    pub fn transmitted(&mut self) {
        self.event(WireEvent::Transmitted(trace(WireFrame::standard(0, &[]))));
    }

    pub fn transmit_error(&mut self, kind: ErrorKind) {
        self.event(WireEvent::TransmitError(kind));
    }

    pub fn received(&mut self, frame: WireFrame) {
        self.event(WireEvent::Received(trace(frame)));
    }

    /// Fills mailbox `n` with a standard data frame without data and requests it.
    pub fn request(&mut self, n: u32, id: u32) {
        self.write(TIR0 + 16 * n + 4, 0);
        self.write(TIR0 + 16 * n, id << 21 | 1);
    }

    /// Identifier that would enter an arbitration now.
    pub fn contends(&mut self) -> Option<WireFrame> {
        self.pair.line(Side::Can1).contend(self.now)
    }
}

/// A trace of which only the frame matters to a controller.
pub fn trace(frame: WireFrame) -> Arc<Trace> {
    let edges = Vec::new();
    let (start, end) = (Time::ZERO, Time::ZERO);
    Arc::new(Trace { frame, transmitter: 9, start, end, bit_time: Time(BIT), edges })
}
