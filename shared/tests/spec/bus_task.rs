//! The task of a bus: priority, lifetimes, leaving; on a controller that is moved by hand.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::future::poll_fn;
use std::pin::{Pin, pin};
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use ecss_can::link::port::{
    Busy, CanPort, ErrorState, Filter, Health, MAILBOXES, Mailbox, PortEvent, is_urgent,
};
use ecss_can::link::queue::Outgoing;
use ecss_can::link::{Bus, Frame};
use ecss_can::runner::{
    AppLink, BusCommand, FailCause, LinkEvent, Links, Node, Outbox, Telltale, bus_task, node_task,
};
use ecss_can::time::{Clock, Instant};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;

use crate::bench::{NOMINAL, REDUNDANT, frame, ms, stamp};

/// Hands commands of the test to the buses and events of the buses to the test.
struct Relay;

impl Node for Relay {
    type Event = (Bus, LinkEvent);
    type Request = (Bus, BusCommand);

    fn start(&mut self, _: Instant, _: &mut Outbox<Self::Event>) {}

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, _: Instant, out: &mut Outbox<Self::Event>) {
        out.event((bus, *event));
    }

    fn on_request(&mut self, (bus, command): Self::Request, _: Instant, out: &mut Outbox<Self::Event>) {
        out.command(bus, command);
    }

    fn poll(&mut self, _: Instant, _: &mut Outbox<Self::Event>) {}

    fn deadline(&self) -> Option<Instant> {
        None
    }
}

/// A clock set by hand. Tasks are polled after every change, so no waker is needed.
#[derive(Clone)]
struct HandClock(Rc<Cell<Instant>>);

impl Clock for HandClock {
    fn now(&self) -> Instant {
        self.0.get()
    }

    async fn at(&self, deadline: Instant) {
        poll_fn(|_| if self.now() >= deadline { Poll::Ready(()) } else { Poll::Pending }).await;
    }
}

/// What a controller was told, and what it has to tell.
#[derive(Default)]
struct Controller {
    mailboxes: [Option<Frame>; MAILBOXES],
    told: Vec<&'static str>,
    events: VecDeque<PortEvent>,
}

struct HandPort(Rc<RefCell<Controller>>);

impl CanPort for HandPort {
    fn set_filters(&mut self, _: &[Filter]) {
        self.0.borrow_mut().told.push("filters");
    }

    fn join(&mut self) {
        self.0.borrow_mut().told.push("join");
    }

    fn leave(&mut self) {
        self.0.borrow_mut().told.push("leave");
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        let mailboxes = &mut self.0.borrow_mut().mailboxes;
        let free = mailboxes.iter().filter(|mailbox| mailbox.is_none()).count();
        if free == 0 || (free == 1 && !is_urgent(frame.id())) {
            return Err(Busy);
        }
        let number = mailboxes.iter().position(Option::is_none).ok_or(Busy)?;
        mailboxes[number] = Some(*frame);
        Ok(Mailbox(number as u8))
    }

    fn abort(&mut self, Mailbox(number): Mailbox) {
        self.0.borrow_mut().told.push(["abort 0", "abort 1", "abort 2"][usize::from(number)]);
    }

    fn health(&self) -> Health {
        Health::default()
    }

    fn recover(&mut self) {
        self.0.borrow_mut().told.push("recover");
    }

    async fn event(&mut self) -> PortEvent {
        poll_fn(|_| match self.0.borrow_mut().events.pop_front() {
            Some(event) => Poll::Ready(event),
            None => Poll::Pending,
        })
        .await
    }
}

type App = AppLink<NoopRawMutex, (Bus, LinkEvent), (Bus, BusCommand)>;

/// Two controllers, their tasks and a relay, all moved by hand.
struct Board<'a> {
    now: Rc<Cell<Instant>>,
    nominal: Rc<RefCell<Controller>>,
    app: &'a App,
    telltale: &'a Telltale,
    tasks: Vec<Pin<&'a mut dyn Future<Output = ()>>>,
}

impl Board<'_> {
    fn settle(&mut self) {
        let mut cx = Context::from_waker(Waker::noop());
        // More rounds than the channels have places.
        for _ in 0..100 {
            for task in &mut self.tasks {
                assert!(task.as_mut().poll(&mut cx).is_pending(), "tasks run for ever");
            }
        }
    }

    fn set_time(&mut self, at: u64) {
        self.now.set(ms(at));
        self.settle();
    }

    fn command(&mut self, command: BusCommand) {
        self.app.requests.try_send((NOMINAL, command)).expect("the node takes every request");
        self.settle();
    }

    fn send(&mut self, id: u16, tag: u8, expires: Option<u64>) {
        self.command(BusCommand::Send(Outgoing { frame: frame(id, &[tag]), expires: expires.map(ms) }));
    }

    fn port_event(&mut self, event: PortEvent) {
        self.nominal.borrow_mut().events.push_back(event);
        self.settle();
    }

    /// The mailbox ends: acknowledged, or given up.
    fn end(&mut self, number: u8, acknowledged: bool) {
        self.nominal.borrow_mut().mailboxes[usize::from(number)] = None;
        let (mailbox, stamp) = (Mailbox(number), stamp(self.now.get()));
        self.port_event(match acknowledged {
            true => PortEvent::Transmitted { mailbox, stamp },
            false => PortEvent::Failed { mailbox },
        });
    }

    fn mailboxes(&self) -> [Option<u16>; MAILBOXES] {
        self.nominal.borrow().mailboxes.map(|frame| frame.map(|frame| frame.id().raw()))
    }

    fn told(&self) -> Vec<&'static str> {
        std::mem::take(&mut self.nominal.borrow_mut().told)
    }

    fn events(&mut self) -> Vec<LinkEvent> {
        std::iter::from_fn(|| self.app.events.try_receive().ok())
            .map(|(bus, event)| {
                assert_eq!(bus, NOMINAL);
                event
            })
            .collect()
    }
}

fn on_board(test: impl FnOnce(&mut Board<'_>)) {
    let now = Rc::new(Cell::new(Instant::ZERO));
    let (nominal, redundant) = (Rc::<RefCell<Controller>>::default(), Rc::default());
    let (links, app, telltale) = (Links::<NoopRawMutex>::new(), App::new(), Telltale::new());
    let clock = || HandClock(now.clone());
    let n = pin!(async { bus_task(NOMINAL, HandPort(nominal.clone()), clock(), &links).await });
    let r = pin!(async { bus_task(REDUNDANT, HandPort(redundant), clock(), &links).await });
    let node = pin!(async { node_task(Relay, clock(), &links, &app, &telltale).await });
    let tasks: Vec<Pin<&mut dyn Future<Output = ()>>> = vec![n, r, node];
    let mut board =
        Board { now: now.clone(), nominal: nominal.clone(), app: &app, telltale: &telltale, tasks };
    board.settle();
    test(&mut board);
}

fn failed(id: u16, tag: u8, cause: FailCause) -> LinkEvent {
    LinkEvent::Failed { frame: frame(id, &[tag]), cause }
}

#[test]
fn lower_cob_ids_overtake_in_the_queue_and_one_mailbox_stays_for_the_urgent() {
    on_board(|board| {
        for (id, tag) in [(0x705, 1), (0x385, 2), (0x385, 3), (0x305, 4)] {
            board.send(id, tag, None);
        }
        assert_eq!(board.mailboxes(), [Some(0x705), Some(0x385), None]);
        board.send(0x000, 5, None);
        assert_eq!(board.mailboxes(), [Some(0x705), Some(0x385), Some(0x000)]);
        board.end(2, true);
        board.end(1, true);
        assert_eq!(board.mailboxes(), [Some(0x705), Some(0x305), None]);
        board.end(1, true);
        assert_eq!(board.mailboxes(), [Some(0x705), Some(0x385), None]);
        let sent = |id, tag| LinkEvent::Transmitted { frame: frame(id, &[tag]), stamp: stamp(ms(0)) };
        assert_eq!(board.events(), [sent(0x000, 5), sent(0x385, 2), sent(0x305, 4)]);
    });
}

#[test]
fn a_lifetime_ends_in_the_queue_and_in_the_mailbox() {
    on_board(|board| {
        board.send(0x705, 1, Some(100));
        board.send(0x385, 2, None);
        board.send(0x385, 3, Some(50));
        board.set_time(50);
        assert_eq!(board.events(), [failed(0x385, 3, FailCause::Expired)]);
        board.set_time(99);
        assert_eq!(board.told(), [""; 0]);
        board.set_time(100);
        assert_eq!(board.told(), ["abort 0"]);
        board.set_time(101);
        assert_eq!((board.told(), board.events()), (vec![], vec![]));
        board.end(0, false);
        assert_eq!(board.events(), [failed(0x705, 1, FailCause::Expired)]);
    });
}

#[test]
fn an_abort_that_came_too_late_is_a_transmission() {
    on_board(|board| {
        board.send(0x705, 1, Some(100));
        board.set_time(100);
        board.end(0, true);
        let stamp = stamp(ms(100));
        assert_eq!(board.events(), [LinkEvent::Transmitted { frame: frame(0x705, &[1]), stamp }]);
    });
}

#[test]
fn abandoning_a_bus_gives_up_queue_and_mailboxes_but_stays_on_it() {
    on_board(|board| {
        for (id, tag) in [(0x705, 1), (0x385, 2), (0x385, 3)] {
            board.send(id, tag, None);
        }
        board.command(BusCommand::Abandon);
        assert_eq!(board.told(), ["abort 0", "abort 1"]);
        assert_eq!(board.events(), [failed(0x385, 3, FailCause::BusLeft)]);
        // A frame for the bus that comes later is none of those.
        board.send(0x080, 4, None);
        assert_eq!(board.mailboxes()[2], Some(0x080));
        board.end(0, false);
        board.end(1, false);
        assert_eq!(
            board.events(),
            [failed(0x705, 1, FailCause::BusLeft), failed(0x385, 2, FailCause::BusLeft)]
        );
    });
}

#[test]
fn joining_leaving_and_recovering_reach_the_controller() {
    on_board(|board| {
        board.command(BusCommand::Join);
        board.send(0x705, 1, None);
        board.command(BusCommand::Leave);
        board.command(BusCommand::Recover);
        assert_eq!(board.told(), ["join", "abort 0", "leave", "recover"]);
    });
}

#[test]
fn a_frame_that_the_controller_gave_up_is_told_as_aborted() {
    on_board(|board| {
        board.send(0x705, 1, None);
        board.end(0, false);
        assert_eq!(board.events(), [failed(0x705, 1, FailCause::Aborted)]);
        // The end of an empty mailbox is nobody's.
        board.end(0, false);
        board.end(1, true);
        assert_eq!(board.events(), []);
    });
}

#[test]
fn what_a_full_queue_does_not_take_is_told() {
    on_board(|board| {
        // Two in mailboxes, 32 in the queue, one too many.
        for tag in 0..35 {
            board.send(0x385, tag, None);
        }
        assert_eq!(board.events(), [failed(0x385, 34, FailCause::QueueFull)]);
    });
}

#[test]
fn receptions_losses_and_error_states_pass_through_and_are_tallied() {
    on_board(|board| {
        let received = frame(0x701, &[5]);
        board.port_event(PortEvent::Received { frame: received, stamp: stamp(ms(0)) });
        board.port_event(PortEvent::Overrun { lost: 3 });
        let health = Health { state: ErrorState::Passive, ..Health::default() };
        board.port_event(PortEvent::Health(health));
        assert_eq!(
            board.events(),
            [
                LinkEvent::Received { frame: received, stamp: stamp(ms(0)) },
                LinkEvent::Overrun { lost: 3 },
                LinkEvent::Health(health)
            ]
        );
        let handled = board.telltale.handled_frames();
        assert_eq!((handled.nominal, handled.redundant, board.telltale.overruns().get()), (1, 0, 3));
    });
}

#[test]
fn a_slow_application_loses_events_and_the_node_goes_on() {
    on_board(|board| {
        for tag in 0..20 {
            board.port_event(PortEvent::Received { frame: frame(0x701, &[tag]), stamp: stamp(ms(0)) });
        }
        assert_eq!(board.telltale.handled_frames().nominal, 20);
        assert_eq!(board.telltale.app_overflows().get(), 4);
        assert_eq!(board.events().len(), 16);
    });
}
