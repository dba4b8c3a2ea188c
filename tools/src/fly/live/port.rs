//! One bus as SLCAN over TCP: the clients, and the one node on the bus that they share.
//!
//! The node is active while a client has its channel open, and only listens while all of them listen. Without an open
//! channel it is as if not connected. A frame of a client is on the bus when the node has sent it; then the other
//! clients get it like any other frame.

use std::collections::VecDeque;
use std::io;
use std::net::{SocketAddr, TcpListener, TcpStream};

use anyhow::anyhow;
use can_twin::guest::{GuestEvent, Presence};
use can_twin::spacecraft::{Bus, GuestId, Spacecraft};
use can_twin::wire::time::Time;
use can_twin::wire::timing::BitTiming;

use super::channel::{Channel, Mode};
use super::client::{Client, Counts};

/// Greatest number of clients of one bus at the same time.
const MOST_CLIENTS: usize = 16;

/// Time without a successful frame after which frames of disconnected clients are dropped.
const PATIENCE: Time = Time::from_ms(100);

/// Interval at which new connections are accepted.
const BETWEEN_WELCOMES: Time = Time::from_ms(10);

/// Position of the node of the clients on its bus, metres from the master's end.
pub const POSITION_M: f64 = 30.0;

/// A client with its address and number.
struct Connection {
    number: u64,
    address: SocketAddr,
    client: Client<TcpStream>,
}

/// A bus that is offered.
pub struct OfferedBus {
    /// The bus.
    pub bus: Bus,
    /// Listener for clients.
    pub listener: TcpListener,
    /// Bit timing of the node.
    pub timing: BitTiming,
    guest: GuestId,
    presence: Presence,
    connections: Vec<Connection>,
    /// Clients of the frames that the node has not sent yet, the oldest first.
    senders: VecDeque<u64>,
    /// Last instant at which a client was connected, or a frame of a client was queued or sent.
    last_use: Time,
    next_welcome: Time,
    totals: Totals,
    /// Lines for the user, to be taken from here.
    pub notes: Vec<String>,
}

/// Counters of a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Clients that connected.
    pub clients: u64,
    /// Frames that they sent.
    pub sent: u64,
    /// Frames dropped because a client did not read in time.
    pub lost: u64,
    /// Frames of clients that were not sent.
    pub abandoned: u64,
}

/// Listens for clients of `bus`.
///
/// # Errors
/// When the address cannot be listened on.
pub fn listen(bus: Bus, address: SocketAddr) -> anyhow::Result<TcpListener> {
    let listener = TcpListener::bind(address).map_err(|error| {
        let remedy = match error.kind() {
            io::ErrorKind::AddrNotAvailable => "choose an address of this computer with --listen".into(),
            io::ErrorKind::PermissionDenied => format!("choose a port above 1023 with --slcan-{bus}"),
            _ => format!("choose another port with --slcan-{bus}, 0 is any free one"),
        };
        anyhow!("cannot listen on {address}: {error}; {remedy}")
    })?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

impl OfferedBus {
    /// Connects a node with this bit timing to the bus. It is inactive until a client connects to `listener`. All
    /// boards must have been added.
    pub fn new(spacecraft: &mut Spacecraft, bus: Bus, timing: BitTiming, listener: TcpListener) -> Self {
        let guest = spacecraft.add_guest_at(bus, POSITION_M, timing);
        spacecraft.set_presence(guest, Presence::Away);
        OfferedBus {
            bus,
            listener,
            timing,
            guest,
            presence: Presence::Away,
            connections: Vec::new(),
            senders: VecDeque::new(),
            last_use: Time::ZERO,
            next_welcome: Time::ZERO,
            totals: Totals::default(),
            notes: Vec::new(),
        }
    }

    /// Returns the counters so far.
    pub fn totals(&self) -> Totals {
        let lost = self.connections.iter().map(|connection| connection.client.counts.lost).sum::<u64>();
        Totals { lost: self.totals.lost + lost, ..self.totals }
    }

    /// Handles the lines of the clients and sends their frames.
    pub fn hear_clients(&mut self, spacecraft: &mut Spacecraft) {
        if spacecraft.now() >= self.next_welcome {
            self.next_welcome = spacecraft.now() + BETWEEN_WELCOMES;
            self.welcome();
        }
        self.listen(spacecraft);
        self.say_goodbye();
        self.appear(spacecraft);
    }

    /// Gives the clients the frames of the bus.
    pub fn tell_clients(&mut self, spacecraft: &mut Spacecraft) {
        for (at, heard) in spacecraft.take_heard(self.guest) {
            self.forward(at, heard);
        }
        self.connections.iter_mut().for_each(|connection| connection.client.flush());
    }

    fn welcome(&mut self) {
        loop {
            // No client waits, a client left before the port accepted it, or the process has no free descriptor.
            let Ok((stream, address)) = self.listener.accept() else { return };
            if self.connections.len() >= MOST_CLIENTS {
                let text = format!("turned away, there are {MOST_CLIENTS} clients");
                self.notes.push(note(self.bus, address, &text));
                continue;
            }
            // Without TCP_NODELAY an answer would wait for the acknowledgement of the one before.
            if stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true)).is_err() {
                continue;
            }
            self.notes.push(note(self.bus, address, "connected"));
            let number = self.totals.clients;
            self.totals.clients += 1;
            let channel = Channel::new(self.timing.bit_rate(), self.bus as u16 + 1);
            self.connections.push(Connection { number, address, client: Client::new(stream, channel) });
        }
    }

    fn forward(&mut self, at: Time, heard: GuestEvent) {
        let (sender, frame) = match heard {
            GuestEvent::Received(frame) => (None, frame),
            GuestEvent::Sent(frame) => {
                self.totals.sent += 1;
                self.last_use = at;
                (self.senders.pop_front(), frame)
            }
        };
        for connection in &mut self.connections {
            if sender == Some(connection.number) {
                connection.client.was_sent();
            } else {
                connection.client.give(at, &frame);
            }
        }
    }

    fn listen(&mut self, spacecraft: &mut Spacecraft) {
        let errors = spacecraft.wire(self.bus).error_counters(self.guest.node);
        for Connection { number, address, client } in &mut self.connections {
            for frame in client.listen(errors) {
                self.senders.push_back(*number);
                self.last_use = spacecraft.now();
                spacecraft.inject(self.guest, spacecraft.now(), frame);
            }
            let refused = client.refused.drain(..).map(|text| note(self.bus, *address, &text));
            self.notes.extend(refused);
        }
    }

    fn say_goodbye(&mut self) {
        for Connection { address, client, .. } in
            self.connections.extract_if(.., |connection| connection.client.is_gone())
        {
            let Counts { taken, given, lost, refused } = client.counts;
            self.totals.lost += lost;
            let mut text = format!("left: {taken} frames from it, {given} to it");
            for (count, what) in [(lost, "lost because it did not read"), (refused, "lines refused")] {
                if count > 0 {
                    text += &format!(", {count} {what}");
                }
            }
            self.notes.push(note(self.bus, address, &text));
        }
    }

    /// Sets how the node takes part in the bus, by the clients' channels.
    fn appear(&mut self, spacecraft: &mut Spacecraft) {
        let now = spacecraft.now();
        let any = |mode| self.connections.iter().any(|connection| connection.client.mode() == mode);
        let (open, listening) = (any(Mode::Open), any(Mode::Listening));
        if open {
            self.last_use = now;
        }
        let owes = !self.senders.is_empty() && now.since(self.last_use) <= PATIENCE;
        let presence = match (open || owes, listening) {
            (true, _) => Presence::Present,
            (false, true) => Presence::Listening,
            (false, false) => Presence::Away,
        };
        if presence == self.presence {
            return;
        }
        self.presence = presence;
        spacecraft.set_presence(self.guest, presence);
        if presence != Presence::Present {
            self.totals.abandoned += self.senders.len() as u64;
            self.senders.clear();
            self.connections.iter_mut().for_each(|connection| connection.client.was_abandoned());
        }
    }
}

/// Formats a line about a client.
fn note(bus: Bus, address: SocketAddr, text: &str) -> String {
    format!("{bus} bus: {address} {text}")
}
