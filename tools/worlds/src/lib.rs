//! Worlds of nodes on two simulated buses, in virtual time, on the host. [`judge`] contains the rules by which searches
//! judge them, [`local_clock`] emulated crystals for a single clock.
//!
//! The same runners as on the boards run on mocks of [`CanPort`] and [`Clock`]: one single-threaded executor per node,
//! no sleeping, and time that jumps from event to event. Equal worlds give equal traces.
//!
//! # Your own device
//!
//! A world takes masters and slaves of any device. A node is made at each power-on, as by `main` of an image, and its
//! application runs with it. The test controls power, clocks, cables and objects, and sees every frame. In this example
//! a heater gets its setpoint while its clock drifts, and continues when a bus is cut:
//!
//! ```
//! use ecss_can::prelude::*;
//! use ecss_can_worlds::{Events, Handle, MockBoard, NEXT_TO_MASTER_M, Plain, Time, World, idle, plain_master};
//!
//! const PROFILE: Profile = Profile { name: "heater", ..Profile::DEFAULT };
//! const HEATER: NodeId = NodeId::of::<5>();
//!
//! #[derive(Objects)]
//! #[objects(device)]
//! struct Heater {
//!     /// Setpoint
//!     #[object(0x6000, rw, high = 850)]
//!     setpoint: i16,
//!     /// Power
//!     #[object(0x6001, ro, pdo)]
//!     power: u8,
//! }
//!
//! impl Device for Heater {
//!     type Pdos = PdoObjects<4, 4>;
//!     type Consumers = HeartbeatConsumers<1>;
//!     /// 285h, on every change.
//!     const PDOS: PdoSet = PdoSet::new(&[], &[Pdo::<()>::new(CobIdOf::node(0x280)).map(Heater::POWER).transmit(2)]);
//! }
//!
//! fn heater(board: MockBoard) -> Slave<Heater> {
//!     Slave::builder(board.node_id, &PROFILE, Heater::default()).hardware(board.hardware).build()
//! }
//!
//! async fn application(heater: Handle<Slave<Heater>>, mut events: Events<Slave<Heater>>) {
//!     loop {
//!         match events.next().await {
//!             SlaveEvent::Written(at) if at == Heater::SETPOINT.address() => {
//!                 heater.update(|heater| heater.power = if heater.setpoint > 250 { 100 } else { 0 });
//!             }
//!             SlaveEvent::ResetNode => events.reset(),
//!             _ => {}
//!         }
//!     }
//! }
//!
//! let mut world = World::builder()
//!     .master(|_| plain_master(&PROFILE), idle)
//!     .slave(HEATER, heater, application)
//!     .drift(HEATER, 80) // its clock is 80 ppm fast
//!     .build();
//! world.run_for(Time::from_ms(1_000));
//! assert!(world.all_operational());
//!
//! // The master writes the setpoint by SDO.
//! let master: Handle<Master<Plain>> = world.master();
//! let work = async move { master.sdo(HEATER).write(Heater::SETPOINT, 400).await };
//! let written = world.spawn(NodeId::MASTER, work);
//! world.run_for(Time::from_ms(10));
//! assert_eq!(written.take().map(|(_, result)| result), Some(Ok(())));
//! let pdos: Vec<_> = world.frames(Bus::Nominal).iter().filter(|sent| sent.id() == Some(0x285)).collect();
//! assert_eq!(pdos.last().unwrap().frame.payload(), [100]);
//!
//! // All nodes go to the other bus, and the heater heats.
//! world.cut(Bus::Nominal, NEXT_TO_MASTER_M);
//! world.run_for(Time::from_ms(1_000));
//! assert!(world.all_operational());
//! assert_eq!(world.active(HEATER), Some(Bus::Redundant));
//! let power = world.slave::<Heater>(HEATER).read(|heater| heater.power);
//! assert_eq!(power, 100);
//! ```
//!
//! Receive PDOs that do not match their transmit PDOs are printed on stderr: [`World::pdo_mismatches`].
//! [`World::unsent_pdos`] lists receive PDOs that no node sends, for example because of a wrong COB-ID.
//!
//! `tests/thermometer.rs` runs the thermometer of `firmware/examples` with its master, `tests/worlds` the demonstration
//! mission. The buses run at 1 Mbit/s, independent of the profile, unless [`Builder::kbit`] sets another rate. Flash
//! and interrupts take no time; the emulated board models these.
//!
//! Related crates: [`ecss-can`](https://docs.rs/ecss-can), [`can-twin`](https://docs.rs/can-twin),
//! [`ecss-can-eds`](https://docs.rs/ecss-can-eds), [`ecss-can-cli`](https://docs.rs/ecss-can-cli).
//!
//! [`CanPort`]: ecss_can::link::port::CanPort
//! [`Clock`]: ecss_can::runner::Clock

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod board;
mod builder;
pub mod clock;
pub mod judge;
mod key;
pub mod local_clock;
pub mod log;
mod mappings;
mod member;
mod memory;
mod plain;
mod pool;
pub mod port;
pub mod task;
pub mod timeline;
mod unit;
pub mod world;

pub use board::MockBoard;
pub use builder::Builder;
pub use can_twin::wire;
pub use can_twin::wire::time::Time;
pub use key::NodeKey;
pub use member::{Events, Handle, Member, ResetLine, idle};
pub use plain::{Plain, plain_master};
pub use world::{NEXT_TO_MASTER_M, World};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
