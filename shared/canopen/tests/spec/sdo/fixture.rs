//! A small dictionary that keeps watch over how it is used, and a server on a bench.

use std::collections::BTreeMap;

use async_canopen::od::machine::{ObjectAccess, Transfer};
use async_canopen::sdo::machine::{Payload, Server};
use async_canopen::types::{AbortCode, Address, Duration, Instant};

pub const TIMEOUT: Duration = Duration::from_millis(400);
/// After which a sub-block that does not go on is acknowledged: a quarter of the timeout.
pub const PAUSE: Duration = Duration::from_millis(100);

pub const U32: Address = Address::new(0x2000, 0);
pub const U8: Address = Address::new(0x2001, 0);
pub const TEXT: Address = Address::new(0x2004, 0);
pub const CONST: Address = Address::new(0x2005, 0);
pub const WRITE_ONLY: Address = Address::new(0x2006, 0);
pub const DOMAIN: Address = Address::new(0x2008, 0);
pub const EMPTY: Address = Address::new(0x200E, 0);

/// Most bytes of [`DOMAIN`].
pub const DOMAIN_MOST: usize = 5_000;

/// How an object behaves.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Exactly so many bytes.
    Fixed(usize),
    /// At most so many.
    Text(usize),
    Domain(usize),
    ReadOnly,
    WriteOnly,
    /// A byte from 1 to 9.
    Limited,
    /// A domain that fails when byte 100 is written.
    Broken,
    /// A domain that has fewer bytes than it says.
    Short(usize),
    /// A domain that refuses at the end.
    Refusing,
    /// Has no value at the moment.
    NoData,
}

/// The dictionary.
pub struct Objects {
    entries: BTreeMap<Address, (Kind, Vec<u8>)>,
    /// The stream that is being written.
    open: Option<(Address, Vec<u8>)>,
    /// What was written, in order.
    pub changes: Vec<(Address, Vec<u8>)>,
    pub cancelled: usize,
    /// Bytes asked for by one read or given in one write, the most there were.
    pub largest_part: usize,
}

impl Objects {
    pub fn new() -> Objects {
        let entries = [
            (U32, Kind::Fixed(4), vec![0x78, 0x56, 0x34, 0x12]),
            (U8, Kind::Fixed(1), vec![0x5A]),
            (Address::new(0x2002, 0), Kind::Fixed(2), vec![0x34, 0x12]),
            (Address::new(0x2003, 5), Kind::Fixed(3), vec![1, 2, 3]),
            (TEXT, Kind::Text(64), b"ECSS-E-ST-50-15C".to_vec()),
            (CONST, Kind::ReadOnly, vec![1, 0, 0, 0]),
            (WRITE_ONLY, Kind::WriteOnly, vec![0; 4]),
            (Address::new(0x2007, 0), Kind::Text(300), vec![7; 257]),
            (DOMAIN, Kind::Domain(DOMAIN_MOST), pattern(100)),
            (Address::new(0x2009, 0), Kind::Limited, vec![5]),
            (Address::new(0x200A, 0), Kind::Broken, vec![]),
            (Address::new(0x200B, 0), Kind::Short(100), pattern(50)),
            (Address::new(0x200C, 0), Kind::Refusing, vec![]),
            (Address::new(0x200D, 0), Kind::NoData, vec![]),
            (EMPTY, Kind::Domain(3), vec![]),
            (Address::new(0x200F, 0), Kind::Short(4), vec![1, 2, 3]),
        ];
        Objects {
            entries: entries.into_iter().map(|(at, kind, value)| (at, (kind, value))).collect(),
            open: None,
            changes: vec![],
            cancelled: 0,
            largest_part: 0,
        }
    }

    pub fn value(&self, at: Address) -> &[u8] {
        &self.entries[&at].1
    }

    /// A value that can be read and is as long as it says.
    pub fn readable(&self, at: Address) -> Option<Vec<u8>> {
        let (kind, value) = self.entries.get(&at)?;
        (!matches!(kind, Kind::WriteOnly | Kind::Short(_) | Kind::NoData)).then(|| value.clone())
    }

    pub fn set(&mut self, at: Address, value: &[u8]) {
        self.entries.get_mut(&at).unwrap().1 = value.to_vec();
    }

    /// Whether a stream was begun and neither finished nor cancelled.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    fn find(&self, at: Address) -> Result<Kind, AbortCode> {
        if !self.entries.keys().any(|known| known.index == at.index) {
            return Err(AbortCode::NoObject);
        }
        self.entries.get(&at).map(|entry| entry.0).ok_or(AbortCode::NoSubIndex)
    }

    fn commit(&mut self, at: Address, value: Vec<u8>) {
        self.changes.push((at, value.clone()));
        self.set(at, &value);
    }
}

impl ObjectAccess for Objects {
    fn upload(&mut self, at: Address) -> Result<Transfer, AbortCode> {
        let kind = self.find(at)?;
        let len = self.value(at).len();
        match kind {
            Kind::WriteOnly => Err(AbortCode::WriteOnly),
            Kind::NoData => Err(AbortCode::NoData),
            Kind::Short(told) => Ok(Transfer::Stream(told)),
            Kind::Domain(_) | Kind::Broken | Kind::Refusing => Ok(Transfer::Stream(len)),
            _ => Ok(Transfer::Whole(len)),
        }
    }

    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> Result<usize, AbortCode> {
        self.upload(at)?;
        self.largest_part = self.largest_part.max(into.len());
        let rest = &self.value(at)[offset.min(self.value(at).len())..];
        let len = rest.len().min(into.len());
        into[..len].copy_from_slice(&rest[..len]);
        Ok(len)
    }

    fn download(&mut self, at: Address, size: Option<usize>) -> Result<Transfer, AbortCode> {
        assert!(self.open.is_none(), "the stream before was neither finished nor cancelled");
        let most = match self.find(at)? {
            Kind::ReadOnly | Kind::Short(_) | Kind::NoData => return Err(AbortCode::ReadOnly),
            Kind::Domain(most) => most,
            Kind::Broken | Kind::Refusing => 1_000,
            Kind::Limited => return Ok(Transfer::Whole(1)),
            Kind::WriteOnly => return Ok(Transfer::Whole(4)),
            Kind::Text(most) => return Ok(Transfer::Whole(most)),
            Kind::Fixed(exact) => {
                return match size {
                    Some(size) if size > exact => Err(AbortCode::TooLong),
                    Some(size) if size < exact => Err(AbortCode::TooShort),
                    _ => Ok(Transfer::Whole(exact)),
                };
            }
        };
        self.open = Some((at, vec![]));
        Ok(Transfer::Stream(most))
    }

    fn write(&mut self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        match self.find(at)? {
            Kind::Fixed(exact) if value.len() < exact => return Err(AbortCode::TooShort),
            Kind::Fixed(exact) if value.len() > exact => return Err(AbortCode::TooLong),
            Kind::Limited if *value < [1][..] => return Err(AbortCode::ValueTooLow),
            Kind::Limited if *value > [9][..] => return Err(AbortCode::ValueTooHigh),
            _ => self.commit(at, value.to_vec()),
        }
        Ok(())
    }

    fn write_part(&mut self, at: Address, offset: usize, part: &[u8]) -> Result<(), AbortCode> {
        let is_broken = self.find(at)? == Kind::Broken;
        self.largest_part = self.largest_part.max(part.len());
        let (open_at, bytes) = self.open.as_mut().expect("a part without a stream");
        assert_eq!((*open_at, bytes.len()), (at, offset), "a part out of order");
        bytes.extend(part);
        if is_broken && bytes.len() > 100 {
            self.open = None;
            return Err(AbortCode::Hardware);
        }
        Ok(())
    }

    fn finish(&mut self, at: Address, size: usize) -> Result<(), AbortCode> {
        let (open_at, bytes) = self.open.take().expect("an end without a stream");
        assert_eq!((open_at, bytes.len()), (at, size), "the size at the end is not that of the parts");
        if self.find(at)? == Kind::Refusing {
            return Err(AbortCode::DeviceState);
        }
        self.commit(at, bytes);
        Ok(())
    }

    fn cancel(&mut self, at: Address) {
        let (open_at, _) = self.open.take().expect("cancelled without a stream");
        assert_eq!(open_at, at);
        self.cancelled += 1;
    }
}

/// A server, its dictionary, and what it sent.
pub struct Bench {
    pub server: Server,
    pub objects: Objects,
    pub now: Instant,
}

impl Bench {
    pub fn new() -> Bench {
        Bench { server: Server::new(TIMEOUT), objects: Objects::new(), now: Instant::from_micros(1_000_000) }
    }

    /// What it answers to a frame.
    pub fn ask(&mut self, payload: Payload) -> Vec<Payload> {
        self.request(payload).1
    }

    /// Whether a frame is of use, and what it answers.
    pub fn request(&mut self, payload: Payload) -> (bool, Vec<Payload>) {
        let mut sent = vec![];
        let Bench { server, objects, now } = self;
        let used = server.on_request(&payload, *now, objects, &mut |payload| sent.push(payload));
        (used, sent)
    }

    /// A frame that is not of use; nothing is sent.
    #[track_caller]
    pub fn ignores(&mut self, payload: Payload) {
        let Bench { server, objects, now } = self;
        assert!(!server.on_request(&payload, *now, objects, &mut |payload| panic!("{payload:02X?}")));
    }

    /// Time passes. What the server sends meanwhile.
    pub fn wait(&mut self, span: Duration) -> Vec<Payload> {
        let mut sent = vec![];
        let until = self.now + span;
        while let Some(deadline) = self.server.deadline().filter(|deadline| *deadline <= until) {
            assert!(deadline >= self.now);
            self.now = deadline;
            sent.extend(self.poll());
            assert!(self.server.deadline().is_none_or(|next| next > deadline), "a busy loop");
        }
        self.now = until;
        sent
    }

    pub fn poll(&mut self) -> Vec<Payload> {
        let mut sent = vec![];
        let Bench { server, objects, now } = self;
        server.poll(*now, objects, &mut |payload| sent.push(payload));
        sent
    }

    /// So many frames have left the bus. What the server sends then.
    pub fn left(&mut self, frames: usize) -> Vec<Payload> {
        (0..frames).for_each(|_| self.server.on_sent());
        self.poll()
    }

    /// Exchanges: what is asked, what must be answered.
    pub fn exchange(&mut self, script: &[(&str, &str)]) {
        for (request, response) in script {
            let expected: Vec<Payload> = if response.is_empty() { vec![] } else { vec![frame(response)] };
            let sent = self.ask(frame(request));
            assert_eq!(hex(&sent), hex(&expected), "answer to {request}");
        }
    }
}

/// A payload from hexadecimal digits; what is not given is zero.
pub fn frame(digits: &str) -> Payload {
    let digits: Vec<u8> = digits.bytes().filter(|digit| *digit != b' ').collect();
    let mut payload = [0; 8];
    assert!(digits.len() <= 16 && digits.len().is_multiple_of(2));
    for (byte, pair) in payload.iter_mut().zip(digits.chunks(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    }
    payload
}

/// For messages that can be read.
pub fn hex(payloads: &[Payload]) -> Vec<String> {
    payloads.iter().map(|payload| payload.map(|byte| format!("{byte:02X}")).join(" ")).collect()
}

/// Bytes that differ from their neighbours.
pub fn pattern(len: usize) -> Vec<u8> {
    (0..len).map(|at| (at.wrapping_mul(167) ^ (at >> 8)) as u8).collect()
}
