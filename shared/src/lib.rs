//! ECSS-E-ST-50-15C, the CANbus extension protocol, on top of CANopen.
//!
//! The protocol is *sans-IO*: every service is a plain struct that is given frames and the time and puts what it wants
//! done into an outbox. Only [`runner`] is async; it joins a node to two CAN controllers through the traits
//! [`link::port::CanPort`] and [`time::Clock`], which boards implement on bxCAN and host tests on mocks.
//!
//! # A tour
//!
//! A device is a struct of objects and the PDOs that carry them. What cannot work does not compile.
//!
//! ```
//! use ecss_can::prelude::*;
//!
//! /// A thermometer.
//! #[derive(Objects)]
//! #[objects(device)]
//! struct Thermometer {
//!     /// Temperature
//!     ///
//!     /// 0.1 °C.
//!     #[object(0x6000, ro, pdo)]
//!     temperature: i16,
//!     /// Offset
//!     ///
//!     /// 0.1 °C.
//!     #[object(0x6001, rw, low = -50, high = 50)]
//!     offset: i16,
//! }
//!
//! /// Sent on every change: 283h from node 3.
//! const CHANGE: Tpdo = Tpdo::new(2, CobIdOf::node(0x280)).map(Thermometer::TEMPERATURE);
//!
//! impl Device for Thermometer {
//!     type Pdos = PdoObjects<4, 4>;
//!     type Consumers = HeartbeatConsumers<1>;
//!     const PDOS: PdoSet = PdoSet::new(&[], &[CHANGE]);
//! }
//!
//! // The numbers of a mission, the same in all its nodes.
//! const MISSION: Profile = Profile { autostart: true, ..Profile::DEFAULT };
//!
//! // A board is a port for each bus and a clock: `boards::Board`. This one is a mock.
//! static TELLTALE: Telltale = Telltale::new();
//! let (clock, ports) = (Clock::default(), PerBus::from_fn(|_| Port::default()));
//! let (time, nominal) = (clock.clone(), ports.nominal.clone());
//!
//! // The user owns the storage. The node is made where it stays.
//! static RESOURCES: Resources<Mock, Slave<Thermometer>> = Resources::new();
//! let slave = || Slave::new(NodeId::of::<3>(), &MISSION, Thermometer::default());
//! let (slave, mut events, runners) = RESOURCES.start(slave, ports, clock, &TELLTALE);
//!
//! // On a board each runner is the argument of a task of one line. A task is a future.
//! let mut tasks: [Pin<Box<dyn Future<Output = ()>>>; 3] = [
//!     Box::pin(async { runners.nominal.run().await }),
//!     Box::pin(async { runners.redundant.run().await }),
//!     Box::pin(async { runners.due.run().await }),
//! ];
//! let context = &mut Context::from_waker(Waker::noop());
//! tasks.iter_mut().for_each(|task| assert!(task.as_mut().poll(context).is_pending()));
//! assert_eq!(nominal.sent(), [(0x703, vec![0])], "the boot-up message");
//!
//! // The application awaits events and changes objects. The PDO goes out by itself.
//! assert_eq!(pin!(events.next()).poll(context), Poll::Ready(SlaveEvent::ActiveBus {
//!     bus: Bus::Nominal,
//!     cause: BusCause::PowerOn,
//! }));
//! slave.change(|thermometer| thermometer.temperature = 215);
//! tasks.iter_mut().for_each(|task| assert!(task.as_mut().poll(context).is_pending()));
//! assert_eq!(nominal.sent(), [(0x283, 215_i16.to_le_bytes().to_vec())]);
//!
//! // A client of its SDO server writes an object: the 60 of 6001h is too much, -20 is not.
//! for (value, answer) in [(60, [0x80, 0x01, 0x60, 0, 0x31, 0, 9, 6]), (-20, [0x60, 0x01, 0x60, 0, 0, 0, 0, 0])] {
//!     let [low, high] = i16::to_le_bytes(value);
//!     nominal.receive(Frame::of(CobId::sdo_request(NodeId::of::<3>()), [0x2B, 0x01, 0x60, 0, low, high, 0, 0]), &time);
//!     tasks.iter_mut().for_each(|task| assert!(task.as_mut().poll(context).is_pending()));
//!     assert_eq!(nominal.sent(), [(0x583, answer.to_vec())]);
//! }
//! assert_eq!(slave.with(|slave, _| slave.objects().application.offset), -20);
//! # use core::cell::{Cell, RefCell};
//! # use core::pin::{Pin, pin};
//! # use core::task::{Context, Poll, Waker};
//! # use std::{collections::VecDeque, rc::Rc};
//! # use ecss_can::link::{Stamp, port::{self, CanPort, Filter, Health, Mailbox, PortEvent}};
//! # use ecss_can::node::BusCause;
//! # struct Mock;
//! # impl Platform for Mock {
//! #     type Port = Port;
//! #     type Clock = Clock;
//! # }
//! # #[derive(Clone, Default)]
//! # struct Clock(Rc<Cell<u64>>);
//! # impl ecss_can::time::Clock for Clock {
//! #     fn now(&self) -> Instant { Instant::from_micros(self.0.get()) }
//! #     async fn at(&self, _: Instant) { core::future::pending().await }
//! # }
//! # #[derive(Clone, Default)]
//! # struct Port(Rc<RefCell<(VecDeque<PortEvent>, Vec<(u16, Vec<u8>)>)>>);
//! # impl Port {
//! #     fn sent(&self) -> Vec<(u16, Vec<u8>)> { core::mem::take(&mut self.0.borrow_mut().1) }
//! #     fn receive(&self, frame: Frame, clock: &Clock) {
//! #         let stamp = Stamp::interrupt(ecss_can::time::Clock::now(clock));
//! #         self.0.borrow_mut().0.push_back(PortEvent::Received { frame, stamp });
//! #     }
//! # }
//! # impl CanPort for Port {
//! #     type PerMailbox<T: Default> = [T; 3];
//! #     const FILTERS: usize = 28;
//! #     fn set_filters(&mut self, _: &[Filter]) {}
//! #     fn set_filter(&mut self, _: u8, _: Filter) {}
//! #     fn join(&mut self) {}
//! #     fn listen(&mut self) {}
//! #     fn leave(&mut self) {}
//! #     fn send(&mut self, frame: &Frame) -> Result<Mailbox, port::Busy> {
//! #         let (events, sent) = &mut *self.0.borrow_mut();
//! #         sent.push((frame.id().raw(), frame.data().to_vec()));
//! #         events.push_back(PortEvent::Transmitted { mailbox: Mailbox(0), stamp: Stamp::interrupt(Instant::ZERO) });
//! #         Ok(Mailbox(0))
//! #     }
//! #     fn abort(&mut self, _: Mailbox) {}
//! #     fn health(&self) -> Health { Health::default() }
//! #     fn recover(&mut self) {}
//! #     fn poll_event(&mut self, _: &mut Context<'_>) -> Poll<PortEvent> {
//! #         self.0.borrow_mut().0.pop_front().map_or(Poll::Pending, Poll::Ready)
//! #     }
//! # }
//! ```
//!
//! `firmware/examples` has the same as an image for a board, and its master.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

// The derive macros name this crate from outside, also in here.
extern crate self as ecss_can;

pub mod boot;
pub mod emcy;
pub mod heartbeat;
pub mod link;
pub mod nmt;
pub mod node;
pub mod od;
pub mod pdo;
pub mod prelude;
pub mod profile;
pub mod redundancy;
pub mod runner;
pub mod sdo;
pub mod store;
pub mod sync;
pub mod time;
pub mod types;
