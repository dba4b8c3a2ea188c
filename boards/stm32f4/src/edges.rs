//! Inputs of TIM5 that capture edges: a pin, its channel and the DMA stream of that channel.

use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH1, DMA1_CH2, DMA1_CH4, TIM5};
use embassy_stm32::timer::{Ch1, Ch2, Ch3, Ch4, TimerChannel, TimerPin};
use embassy_stm32::{Peri, PeripheralType};

use crate::alternate::AlternatePin;

/// A channel of TIM5 whose captures DMA1 moves (RM0090 table 42: stream channel 6).
pub trait CaptureChannel: TimerChannel {
    /// The stream that serves it.
    type Stream: PeripheralType;
    /// Its number, from 0.
    const NUMBER: usize;
    /// Number of that stream.
    const STREAM: usize;
}

impl CaptureChannel for Ch1 {
    type Stream = DMA1_CH2;
    const NUMBER: usize = 0;
    const STREAM: usize = 2;
}

impl CaptureChannel for Ch2 {
    type Stream = DMA1_CH4;
    const NUMBER: usize = 1;
    const STREAM: usize = 4;
}

impl CaptureChannel for Ch3 {
    type Stream = DMA1_CH0;
    const NUMBER: usize = 2;
    const STREAM: usize = 0;
}

impl CaptureChannel for Ch4 {
    type Stream = DMA1_CH1;
    const NUMBER: usize = 3;
    const STREAM: usize = 1;
}

/// An input that captures edges.
#[cfg_attr(not(feature = "full"), allow(dead_code, reason = "a minimal board has it, but captures nothing"))]
pub struct EdgeInput {
    pub(crate) pin: AlternatePin,
    /// From 0.
    pub(crate) channel: usize,
    pub(crate) stream: usize,
}

impl EdgeInput {
    /// Takes a pin of TIM5 and the stream of its channel. Others do not compile.
    pub fn new<C: CaptureChannel>(
        pin: Peri<'static, impl TimerPin<TIM5, C>>,
        _stream: Peri<'static, C::Stream>,
    ) -> EdgeInput {
        EdgeInput { pin: AlternatePin(pin.af_num(), pin.into()), channel: C::NUMBER, stream: C::STREAM }
    }
}
