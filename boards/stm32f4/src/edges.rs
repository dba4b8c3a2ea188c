//! Inputs of TIM5 that capture edges: a pin, its channel and the DMA stream of that channel.

use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH1, DMA1_CH2, DMA1_CH4, TIM5};
use embassy_stm32::timer::{Ch1, Ch2, Ch3, Ch4, TimerChannel, TimerPin};
use embassy_stm32::{Peri, PeripheralType};

use crate::alternate::AlternatePin;

/// A channel of TIM5 whose captures DMA1 moves.
pub trait CaptureChannel: TimerChannel {
    /// Number of the channel, from 0.
    const NUMBER: usize;
}

/// A stream of DMA1 that serves a channel of TIM5 (RM0090 table 42: stream channel 6).
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not move what channel `{C}` of TIM5 captures",
    label = "not the stream of this pin",
    note = "list the stream of the pin: PA0 has DMA1_CH2, PA1 has DMA1_CH4, PA2 has DMA1_CH0, PA3 has DMA1_CH1",
    note = "in `board!`, `nominal_stream` belongs to `nominal_edges`, `redundant_stream` to `redundant_edges`"
)]
pub trait CaptureStream<C: CaptureChannel>: PeripheralType {
    /// Number of the stream in DMA1.
    const NUMBER: usize;
}

impl CaptureChannel for Ch1 {
    const NUMBER: usize = 0;
}

impl CaptureStream<Ch1> for DMA1_CH2 {
    const NUMBER: usize = 2;
}

impl CaptureChannel for Ch2 {
    const NUMBER: usize = 1;
}

impl CaptureStream<Ch2> for DMA1_CH4 {
    const NUMBER: usize = 4;
}

impl CaptureChannel for Ch3 {
    const NUMBER: usize = 2;
}

impl CaptureStream<Ch3> for DMA1_CH0 {
    const NUMBER: usize = 0;
}

impl CaptureChannel for Ch4 {
    const NUMBER: usize = 3;
}

impl CaptureStream<Ch4> for DMA1_CH1 {
    const NUMBER: usize = 1;
}

/// An input that captures edges.
#[cfg_attr(not(feature = "full"), allow(dead_code, reason = "a minimal board has it, but captures nothing"))]
pub struct EdgeInput {
    pub(crate) pin: AlternatePin,
    /// Channel of TIM5, from 0.
    pub(crate) channel: usize,
    pub(crate) stream: usize,
}

impl EdgeInput {
    /// Takes a pin of TIM5 and the stream of its channel. Other pins and streams do not compile.
    pub fn new<C: CaptureChannel, S: CaptureStream<C>>(
        pin: Peri<'static, impl TimerPin<TIM5, C>>,
        _stream: Peri<'static, S>,
    ) -> EdgeInput {
        EdgeInput { pin: AlternatePin(pin.af_num(), pin.into()), channel: C::NUMBER, stream: S::NUMBER }
    }
}
