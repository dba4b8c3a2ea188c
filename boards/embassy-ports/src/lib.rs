//! Ports over the CAN drivers of embassy-stm32, for chips that have no driver of this project.
//!
//! The feature `bxcan` or `fdcan` names the controller of the chip. A slave on one bus:
//!
//! ```ignore
//! static NODE: Single<Board<Fdcan>, CanopenSlave<Heater>> = Single::new();
//!
//! let mut can = CanConfigurator::new(p.FDCAN1, p.PA11, p.PA12, Irqs);
//! can.set_bitrate(250_000);
//! let port = Adapter::new(Fdcan::new(can));
//! let (slave, mut events, runners) = NODE.start(|| device, Connection { ports: port, clock: Uptime }, &DIAGNOSTICS);
//! ```
//!
//! # What these drivers lack
//!
//! The table of [`adapter`](async_canopen::link::adapter) says how a node behaves without each of these.
//!
//! | | `Bxcan` | `Fdcan` |
//! | --- | --- | --- |
//! | results of transmissions | yes, for each mailbox | no: `Transmitted` when the controller accepts a frame |
//! | abort | yes; it waits up to a frame with interrupts off | no |
//! | order of frames in the controller | by priority | in the order in which they were handed over |
//! | stamps | when the task reads the frame | when the task reads the frame |
//! | error state and counters | no, the cause of the last error only | yes, read when the task runs |
//! | recovery from bus-off | by itself, after 128 times 11 recessive bits | by itself, as `Bxcan` |
//! | leaving the bus | yes | no: it still acknowledges |
//! | listen-only mode | yes | no: it acknowledges |
//! | off the bus until the node joins | yes | yes |
//! | acceptance filters in hardware | 28, of CAN1 | 28 |
//! | overruns | not reported; two FIFOs with three frames, of which one is used | as `Bxcan` |
//!
//! A node that has no error state does not report bus-off. A node whose controller recovers by itself may be on the bus
//! again earlier than ECSS-E-ST-50-15C allows. The driver of this project (`ecss-can-stm32f4`) has none of these limits.
//!
//! # Defects of embassy-stm32 0.6.0 that these ports avoid
//!
//! 1. The queue by priority of FDCAN, its default, discards the frame of the *higher* priority when it is full
//!    (`Registers::is_available`). `Fdcan` selects the FIFO.
//! 2. `flush` of FDCAN uses `1 << index` as an index and therefore checks wrong buffers. `Fdcan` has no results.
//! 3. Stamps of FDCAN divide by the prescaler where they have to multiply. `Fdcan` reads the clock of the node.
//! 4. The buffered drivers drop received frames when their queue is full.
//! 5. The buffered driver of bxCAN also drops frames that it replaced. The ports use no buffered driver.
//! 6. An abort of bxCAN reads the result after the interrupt handler may have cleared it. `Bxcan` disables interrupts.
//! 7. `set_automatic_retransmit` of bxCAN does the opposite. `Bxcan` leaves it at its default.
//!
//! # Limits
//!
//! - `join` and `listen` of `Bxcan` wait, without yielding, until the controller was initialised: up to a frame when it
//!   was on the bus, longer when that is dominant all the time.
//! - `Fdcan` has not run, neither on a board nor on the emulated one, which has no FDCAN.
//! - `Can::new` of bxCAN enables the time-triggered mode (TTCM), which the errata of the STM32F4 forbid. No function
//!   disables it.

#![cfg_attr(target_os = "none", no_std)]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(all(target_os = "none", feature = "bxcan"))]
mod bxcan;
#[cfg(all(target_os = "none", feature = "fdcan"))]
mod fdcan;
#[cfg(all(target_os = "none", any(feature = "bxcan", feature = "fdcan")))]
mod frame;
#[cfg(target_os = "none")]
mod platform;

#[cfg(all(target_os = "none", feature = "bxcan"))]
pub use bxcan::Bxcan;
#[cfg(all(target_os = "none", feature = "fdcan"))]
pub use fdcan::Fdcan;
#[cfg(target_os = "none")]
pub use platform::{Board, Uptime};
