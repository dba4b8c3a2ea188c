//! The task of one node: events in, outbox out.

use core::future::{pending, poll_fn};

use embassy_futures::select::{Either5, select5};
use embassy_sync::blocking_mutex::raw::RawMutex;
use heapless::Deque;

use super::{APP_DEPTH, AppLink, BusCommand, LinkEvent, Links, NodeCell, QUEUE_DEPTH, Telltale};
use crate::link::queue::Outgoing;
use crate::link::{Bus, Frame, PerBus};
use crate::time::{Clock, Duration, Instant};

/// A protocol node: master or slave, sans-IO.
pub trait Node {
    /// What it tells its application.
    type Event;
    /// What its application may ask of it.
    type Request;

    /// Power-on, at `now`. Called once, before anything else.
    fn start(&mut self, now: Instant, out: &mut Outbox<Self::Event>);

    /// Something happened on a bus.
    fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Outbox<Self::Event>);

    /// The application wants something.
    fn on_request(&mut self, request: Self::Request, now: Instant, out: &mut Outbox<Self::Event>);

    /// Do what is due at `now`.
    fn poll(&mut self, now: Instant, out: &mut Outbox<Self::Event>);

    /// When to call [`Node::poll`] next, `None`: not before another event.
    fn deadline(&self) -> Option<Instant>;
}

/// Places of an [`Outbox`] that frames cannot take: joining and leaving a bus must always get through.
const CONTROL_RESERVE: usize = 8;

/// Where a node puts what it wants done.
pub struct Outbox<E> {
    commands: Deque<(Bus, BusCommand), QUEUE_DEPTH>,
    events: Deque<E, APP_DEPTH>,
    overflows: u32,
    unsent: PerBus<u16>,
}

impl<E> Outbox<E> {
    /// An empty outbox.
    pub const fn new() -> Self {
        Outbox {
            commands: Deque::new(),
            events: Deque::new(),
            overflows: 0,
            unsent: PerBus { nominal: 0, redundant: 0 },
        }
    }

    /// Send a frame now or within `lifetime` of `now`; after that it is stale and dies.
    #[inline]
    pub fn send_for(&mut self, bus: Bus, frame: Frame, now: Instant, lifetime: Duration) {
        self.send_until(bus, frame, now + lifetime);
    }

    /// Send a frame before `expires`; from then on it is stale and dies.
    #[inline(never)] // sent from many places
    pub fn send_until(&mut self, bus: Bus, frame: Frame, expires: Instant) {
        self.command(bus, BusCommand::Send(Outgoing { frame, expires }));
    }

    /// Command a bus. The last `CONTROL_RESERVE` places are kept for commands other than sending.
    pub fn command(&mut self, bus: Bus, command: BusCommand) {
        let sends = matches!(command, BusCommand::Send(_));
        let reserve = if sends { CONTROL_RESERVE } else { 0 };
        if self.commands.len() + reserve >= QUEUE_DEPTH || self.commands.push_back((bus, command)).is_err() {
            self.overflows = self.overflows.saturating_add(1);
            self.unsent[bus] = self.unsent[bus].saturating_add(u16::from(sends));
        }
    }

    /// Whether frames have at least half of it to themselves: commands that can wait should, if not.
    pub fn has_room(&self) -> bool {
        self.commands.len() < QUEUE_DEPTH / 2
    }

    /// Tell the application.
    pub fn event(&mut self, event: E) {
        if self.events.push_back(event).is_err() {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// The next command, in order.
    pub fn pop_command(&mut self) -> Option<(Bus, BusCommand)> {
        self.commands.pop_front()
    }

    /// The bus of the next command.
    fn next_bus(&self) -> Option<Bus> {
        self.commands.front().map(|(bus, _)| *bus)
    }

    /// The next event, in order.
    pub fn pop_event(&mut self) -> Option<E> {
        self.events.pop_front()
    }

    /// Frames for `bus` lost since the last call because this outbox was full.
    pub fn take_unsent(&mut self, bus: Bus) -> u16 {
        core::mem::take(&mut self.unsent[bus])
    }

    /// Commands and events lost since the last call because this outbox was full.
    pub fn take_overflows(&mut self) -> u32 {
        core::mem::take(&mut self.overflows)
    }
}

impl<E> Default for Outbox<E> {
    fn default() -> Self {
        Self::new()
    }
}

/// Runs a node for ever.
///
/// A slow application loses events (counted in `telltale`). The node never waits for a bus: commands a bus cannot take
/// yet stay in the outbox while events go on being handled, so bus and node cannot wait for each other.
pub async fn node_task<M: RawMutex, N: Node>(
    node: &NodeCell<M, N>,
    clock: impl Clock,
    links: &Links<M>,
    app: &AppLink<M, N::Event, N::Request>,
    telltale: &Telltale,
) -> ! {
    let mut out = Outbox::new();
    node.step(|node| node.start(clock.now(), &mut out));
    let mut deadline = Some(clock.now());
    loop {
        deliver(&mut out, links, app, telltale);
        let blocked = out.next_bus();
        let timer = async {
            match deadline {
                Some(at) => clock.at(at).await,
                None => pending().await,
            }
        };
        let room = async {
            match blocked {
                Some(bus) => poll_fn(|cx| links.commands[bus].poll_ready_to_send(cx)).await,
                None => pending().await,
            }
        };
        let (requests, touched) = (app.requests.receive(), node.touched());
        let happened = select5(links.events.receive(), timer, requests, touched, room).await;
        deadline = node.step(|node| {
            let now = clock.now();
            match happened {
                Either5::First((bus, event)) => {
                    node.on_link(bus, &event, now, &mut out);
                    match event {
                        LinkEvent::Received { .. } => telltale.handled(bus).count(),
                        LinkEvent::Overrun { lost } => telltale.overruns().add(u32::from(lost)),
                        _ => {}
                    }
                }
                Either5::Second(()) | Either5::Fourth(()) => node.poll(now, &mut out),
                Either5::Third(request) => node.on_request(request, now, &mut out),
                Either5::Fifth(()) => {}
            }
            for bus in Bus::ALL {
                let frames = out.take_unsent(bus);
                if frames > 0 {
                    node.on_link(bus, &LinkEvent::Unsent { frames }, now, &mut out);
                }
            }
            node.deadline()
        });
    }
}

/// Hands over what the channels take; commands they do not take stay, in order.
fn deliver<M: RawMutex, E, R>(
    out: &mut Outbox<E>,
    links: &Links<M>,
    app: &AppLink<M, E, R>,
    telltale: &Telltale,
) {
    telltale.app_overflows().add(out.take_overflows());
    while let Some(event) = out.pop_event() {
        if app.events.try_send(event).is_err() {
            telltale.app_overflows().count();
        }
    }
    while let Some(bus) = out.next_bus() {
        if links.commands[bus].is_full() {
            return;
        }
        if let Some((bus, command)) = out.pop_command() {
            // Only this task sends, so there is still room.
            if links.commands[bus].try_send(command).is_err() {
                telltale.app_overflows().count();
            }
        }
    }
}
