//! A driver of `embedded_can::nb` that the test plays by hand, and the port over it.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};

use async_canopen::link::adapter::{Adapter, Mode, Nonblocking, WakeUp};
use async_canopen::link::port::{CanPort, Filter, Health, Mailbox, PortEvent};
use async_canopen::types::{CobId, Frame, Instant};
use embedded_can::nb::Can;
use embedded_can::{ErrorKind, Id, StandardId};

/// Frame as the driver has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Own {
    pub id: Id,
    pub is_remote: bool,
    pub data: Vec<u8>,
}

impl Own {
    pub fn of(frame: &Frame) -> Own {
        embedded_can::Frame::new(StandardId::new(frame.id().raw()).unwrap(), frame.data()).unwrap()
    }

    fn frame(&self) -> Frame {
        let Id::Standard(id) = self.id else { panic!("29 bits") };
        Frame::new(CobId::new(id.as_raw()).unwrap(), &self.data).unwrap()
    }
}

impl embedded_can::Frame for Own {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Some(Own { id: id.into(), is_remote: false, data: data.to_vec() })
    }
    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        Some(Own { id: id.into(), is_remote: true, data: vec![0; dlc] })
    }
    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }
    fn is_remote_frame(&self) -> bool {
        self.is_remote
    }
    fn id(&self) -> Id {
        self.id
    }
    fn dlc(&self) -> usize {
        self.data.len()
    }
    fn data(&self) -> &[u8] {
        &self.data
    }
}

/// Frame that a driver gives up for a new one when all its mailboxes are in use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Replaces {
    /// The last one of the lowest priority, if the new one has a higher priority: as the trait says.
    #[default]
    Lowest,
    /// None: a FIFO.
    Never,
    /// The one of the highest priority: a defect.
    Highest,
}

/// The controller as the test plays it.
#[derive(Default)]
pub struct Chip {
    /// Frames in its mailboxes, in the order in which they were accepted.
    pub pending: Vec<Own>,
    pub mailboxes: usize,
    pub replaces: Replaces,
    /// Each transmission is refused with this error.
    pub failure: Option<ErrorKind>,
    /// Calls of `transmit`.
    pub attempts: usize,
    pub inbox: VecDeque<Result<Own, ErrorKind>>,
    pub health: Option<Health>,
    pub modes: Vec<Mode>,
    pub recoveries: usize,
}

impl Chip {
    /// The frame that wins the arbitration leaves.
    pub fn sends(&mut self) -> Option<Frame> {
        let first = (0..self.pending.len()).min_by_key(|&at| self.pending[at].id)?;
        Some(self.pending.remove(first).frame())
    }
}

#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<Chip>>);

impl Can for Shared {
    type Frame = Own;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Own) -> nb::Result<Option<Own>, ErrorKind> {
        let chip = &mut *self.0.borrow_mut();
        chip.attempts += 1;
        if let Some(failure) = chip.failure {
            return Err(nb::Error::Other(failure));
        }
        if chip.pending.len() < chip.mailboxes {
            chip.pending.push(frame.clone());
            return Ok(None);
        }
        let at = 0..chip.pending.len();
        let victim = match chip.replaces {
            // The last one of equal ones.
            Replaces::Lowest => {
                at.max_by_key(|&at| chip.pending[at].id).filter(|&at| chip.pending[at].id > frame.id)
            }
            Replaces::Never => None,
            Replaces::Highest => at.min_by_key(|&at| chip.pending[at].id),
        };
        let victim = victim.ok_or(nb::Error::WouldBlock)?;
        let replaced = chip.pending.remove(victim);
        chip.pending.push(frame.clone());
        Ok(Some(replaced))
    }

    fn receive(&mut self) -> nb::Result<Own, ErrorKind> {
        let next = self.0.borrow_mut().inbox.pop_front().ok_or(nb::Error::WouldBlock)?;
        next.map_err(nb::Error::Other)
    }
}

thread_local! {
    static NOW: Cell<Instant> = const { Cell::new(Instant::ZERO) };
}

pub fn now() -> Instant {
    NOW.get()
}

pub struct Task(AtomicBool);

impl Wake for Task {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Port, driver and task of a bus.
pub struct Bench {
    pub port: Adapter<Nonblocking<Shared>>,
    pub chip: Rc<RefCell<Chip>>,
    pub wake_up: &'static WakeUp,
    task: Arc<Task>,
}

impl Bench {
    /// A port that admits every frame, on the bus.
    pub fn joined(mailboxes: usize, replaces: Replaces) -> Bench {
        let mut bench = Bench::off(mailboxes, replaces);
        bench.port.join();
        bench
    }

    /// A port that is off its bus.
    pub fn off(mailboxes: usize, replaces: Replaces) -> Bench {
        let chip = Rc::new(RefCell::new(Chip { mailboxes, replaces, ..Chip::default() }));
        let wake_up: &'static WakeUp = Box::leak(Box::default());
        let driver = Nonblocking::new(Shared(chip.clone()), wake_up, now)
            .with_health(|can| can.0.borrow().health)
            .with_mode(|can, mode| can.0.borrow_mut().modes.push(mode))
            .with_recovery(|can| can.0.borrow_mut().recoveries += 1);
        let mut port = Adapter::new(driver);
        port.set_filters(&[Filter::ALL]);
        Bench { port, chip, wake_up, task: Arc::new(Task(AtomicBool::new(false))) }
    }

    pub fn at(&self, micros: u64) {
        NOW.set(Instant::from_micros(micros));
    }

    pub fn poll(&mut self) -> Poll<PortEvent> {
        let waker = Waker::from(self.task.clone());
        self.port.poll_event(&mut Context::from_waker(&waker))
    }

    /// All events that there are.
    pub fn events(&mut self) -> Vec<PortEvent> {
        std::iter::from_fn(|| match self.poll() {
            Poll::Ready(event) => Some(event),
            Poll::Pending => None,
        })
        .collect()
    }

    /// Mailboxes whose frames ended as transmitted.
    pub fn transmitted(&mut self) -> Vec<u8> {
        let of = |event| match event {
            PortEvent::Transmitted { mailbox: Mailbox(number), .. } => number,
            other => panic!("{other:?}"),
        };
        self.events().into_iter().map(of).collect()
    }

    /// The frames that the driver sends from now on, polled after each.
    pub fn drained(&mut self) -> Vec<Frame> {
        std::iter::from_fn(|| {
            let frame = self.chip.borrow_mut().sends();
            self.events();
            frame
        })
        .collect()
    }

    pub fn was_woken(&self) -> bool {
        self.task.0.swap(false, Ordering::Relaxed)
    }
}
