//! A client and a server in one virtual time, and a line between them that may lose, repeat and reorder.

use std::collections::VecDeque;

use async_canopen::sdo::Error;
use async_canopen::sdo::Mode;
use async_canopen::sdo::machine::{Client, Payload, Server};
use async_canopen::types::{Address, Duration, Instant};

use super::fixture::{Objects, TIMEOUT};

/// How long a frame takes.
const FRAME: Duration = Duration::from_micros(130);

/// What becomes of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    Passes,
    Lost,
    /// An error in its last bit: received twice.
    Twice,
    /// Goes after the next frame.
    Late,
}

/// How the application of the client behaves.
#[derive(Clone, Copy, Debug)]
pub struct Application {
    /// Bytes pushed or pulled at a time.
    pub chunk: usize,
    /// It has time after so many frames only.
    pub every: usize,
}

/// One direction of the line.
struct Lane {
    /// Of the frames to come; then all pass.
    fates: VecDeque<Fate>,
    frames: VecDeque<Payload>,
    late: Option<Payload>,
}

impl Lane {
    fn new(fates: Vec<Fate>) -> Lane {
        Lane { fates: fates.into(), frames: VecDeque::new(), late: None }
    }

    fn is_empty(&self) -> bool {
        self.frames.is_empty() && self.late.is_none()
    }

    /// What arrives when one frame leaves; whether one did.
    fn transmit(&mut self) -> (Vec<Payload>, bool) {
        let Some(frame) = self.frames.pop_front() else {
            return (self.late.take().into_iter().collect(), false);
        };
        let arrives = match self.fates.pop_front().unwrap_or(Fate::Passes) {
            Fate::Passes => vec![frame],
            Fate::Lost => vec![],
            Fate::Twice => vec![frame; 2],
            Fate::Late if self.late.is_none() => {
                self.late = Some(frame);
                return (vec![], true);
            }
            Fate::Late => vec![frame],
        };
        (arrives.into_iter().chain(self.late.take()).collect(), true)
    }
}

pub struct World {
    pub client: Client,
    pub server: Server,
    pub objects: Objects,
    pub now: Instant,
    pub frames: usize,
    requests: Lane,
    responses: Lane,
}

impl World {
    /// The fates of requests and of responses.
    pub fn new(requests: Vec<Fate>, responses: Vec<Fate>) -> World {
        World {
            client: Client::new(TIMEOUT),
            server: Server::new(TIMEOUT),
            objects: Objects::new(),
            now: Instant::from_micros(1_000_000),
            frames: 0,
            requests: Lane::new(requests),
            responses: Lane::new(responses),
        }
    }

    /// From now on all frames pass.
    pub fn repair(&mut self) {
        self.requests.fates.clear();
        self.responses.fates.clear();
    }

    /// Writes a value; the outcome.
    pub fn download(
        &mut self,
        at: Address,
        value: &[u8],
        mode: Mode,
        application: Application,
    ) -> Result<usize, Error> {
        self.client.start_download(at, value.len(), mode);
        let mut rest = value;
        self.run(application, |client, chunk| {
            let pushed = client.push(&rest[..chunk.min(rest.len())]);
            rest = &rest[pushed..];
        })
    }

    /// Reads a value of at most `most` bytes.
    pub fn upload(
        &mut self,
        at: Address,
        most: usize,
        mode: Mode,
        application: Application,
    ) -> Result<Vec<u8>, Error> {
        self.client.start_upload(at, most, mode);
        let mut value = vec![];
        let pull = |client: &mut Client, chunk: usize| {
            let mut part = vec![0; chunk];
            let pulled = client.pull(&mut part);
            value.extend(&part[..pulled]);
        };
        let size = self.run(application, pull)?;
        let mut part = vec![0; 1_000];
        let pulled = self.client.pull(&mut part);
        value.extend(&part[..pulled]);
        assert_eq!(value.len(), size);
        Ok(value)
    }

    fn run(
        &mut self,
        application: Application,
        mut work: impl FnMut(&mut Client, usize),
    ) -> Result<usize, Error> {
        for step in 0..1_000_000 {
            if step % application.every == 0 {
                work(&mut self.client, application.chunk);
            }
            self.client.poll(self.now, &mut |payload| self.requests.frames.push_back(payload));
            if let Some(outcome) = self.client.outcome() {
                return outcome;
            }
            self.step();
        }
        panic!("neither an end nor an error");
    }

    /// Lets the line run dry and both sides come to rest.
    pub fn settle(&mut self) {
        for _ in 0..1_000_000 {
            if self.requests.is_empty() && self.responses.is_empty() && !self.server.is_busy() {
                return;
            }
            self.step();
        }
        panic!("the server does not come to rest");
    }

    /// One frame in each direction.
    fn step(&mut self) {
        // Nobody can do anything before something is due, unless the application has time.
        let is_client_idle = self.client.deadline().is_none() && !self.client.needs_application();
        let is_idle = self.requests.is_empty() && self.responses.is_empty() && is_client_idle;
        let due = self.server.deadline().filter(|due| is_idle && *due > self.now);
        self.now = due.unwrap_or(self.now + FRAME);
        let World { client, server, objects, now, frames, requests, responses } = self;
        if !requests.is_empty() {
            let (arrived, has_left) = requests.transmit();
            *frames += usize::from(has_left);
            if has_left {
                client.on_sent();
            }
            for payload in arrived {
                server
                    .on_request(&payload, *now, objects, &mut |payload| responses.frames.push_back(payload));
            }
        }
        if !responses.is_empty() {
            let (arrived, has_left) = responses.transmit();
            *frames += usize::from(has_left);
            if has_left {
                server.on_sent();
            }
            for payload in arrived {
                client.on_response(&payload, *now, &mut |payload| requests.frames.push_back(payload));
            }
        }
        server.poll(*now, objects, &mut |payload| responses.frames.push_back(payload));
        client.poll(*now, &mut |payload| requests.frames.push_back(payload));
        assert!(requests.frames.len() <= 20 && responses.frames.len() <= 20, "the bus is flooded");
    }
}
