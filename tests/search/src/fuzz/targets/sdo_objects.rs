//! A dictionary with an object of each kind, which checks its use.

use ecss_can::od::machine::{ObjectAccess, Transfer};
use ecss_can::types::{AbortCode, Address};

/// Largest size of the domain, bytes.
const DOMAIN: usize = 1_200;
/// Byte at which a defective domain fails.
const BROKEN: usize = 20;

/// Behaviour of an object.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Exactly this many bytes.
    Fixed(usize),
    /// At most this many bytes.
    Text(usize),
    /// A value that is transferred in parts.
    Domain,
    ReadOnly,
    WriteOnly,
    /// A byte from 1 to 9.
    Limited,
    /// A domain that fails beyond a number of bytes.
    Broken,
    /// A domain with fewer bytes than its size.
    Short(usize),
    /// A domain that refuses at the end.
    Refusing,
}

const KINDS: [Kind; 9] = [
    Kind::Fixed(4),
    Kind::Fixed(1),
    Kind::Text(64),
    Kind::Domain,
    Kind::ReadOnly,
    Kind::WriteOnly,
    Kind::Limited,
    Kind::Broken,
    Kind::Short(40),
];

/// Index of the first object, 2000h. Objects are consecutive, and the one after the last refuses access.
const FIRST: u16 = 0x2000;
/// Number of objects.
pub const OBJECTS: u16 = 10;

/// Returns the address of the object with this number.
pub const fn address(number: u8) -> Address {
    Address::new(FIRST + number as u16, 0)
}

/// The dictionary.
pub struct Objects {
    values: [Vec<u8>; OBJECTS as usize],
    /// The stream that is being written.
    open: Option<(Address, Vec<u8>)>,
    /// Written values, in order.
    pub changes: Vec<(Address, Vec<u8>)>,
}

impl Objects {
    pub fn new() -> Objects {
        let values = [
            vec![0x78, 0x56, 0x34, 0x12],
            vec![0x5A],
            b"ECSS-E-ST-50-15C".to_vec(),
            (0..100).map(|byte: u8| byte.wrapping_mul(167)).collect(),
            vec![1, 0, 0, 0],
            vec![0; 4],
            vec![5],
            vec![],
            vec![9; 30],
            vec![],
        ];
        Objects { values, open: None, changes: vec![] }
    }

    /// Returns a value that is readable and has its indicated size.
    pub fn readable(&self, at: Address) -> Option<&[u8]> {
        let (number, kind) = find(at).ok()?;
        (!matches!(kind, Kind::WriteOnly | Kind::Short(_))).then(|| &*self.values[number])
    }

    /// Returns whether a stream was started and neither finished nor cancelled.
    pub const fn is_open(&self) -> bool {
        self.open.is_some()
    }

    pub fn set(&mut self, at: Address, value: &[u8]) {
        if let Ok((number, _)) = find(at) {
            self.values[number] = value.to_vec();
        }
    }

    fn commit(&mut self, at: Address, value: Vec<u8>) {
        self.set(at, &value);
        self.changes.push((at, value));
    }
}

fn find(at: Address) -> Result<(usize, Kind), AbortCode> {
    let number = at.index.checked_sub(FIRST).filter(|number| *number < OBJECTS).ok_or(AbortCode::NoObject)?;
    let kind = KINDS.get(usize::from(number)).copied().unwrap_or(Kind::Refusing);
    if at.sub == 0 { Ok((usize::from(number), kind)) } else { Err(AbortCode::NoSubIndex) }
}

impl ObjectAccess for Objects {
    fn upload(&mut self, at: Address) -> Result<Transfer, AbortCode> {
        let (number, kind) = find(at)?;
        let len = self.values[number].len();
        match kind {
            Kind::WriteOnly => Err(AbortCode::WriteOnly),
            Kind::Short(told) => Ok(Transfer::Stream(told)),
            Kind::Domain | Kind::Broken | Kind::Refusing => Ok(Transfer::Stream(len)),
            _ => Ok(Transfer::Whole(len)),
        }
    }

    fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> Result<usize, AbortCode> {
        self.upload(at)?;
        let value = &self.values[find(at)?.0];
        let rest = &value[offset.min(value.len())..];
        let len = rest.len().min(into.len());
        into[..len].copy_from_slice(&rest[..len]);
        Ok(len)
    }

    fn download(&mut self, at: Address, size: Option<usize>) -> Result<Transfer, AbortCode> {
        assert!(self.open.is_none(), "the stream before was neither finished nor cancelled");
        match find(at)?.1 {
            Kind::ReadOnly | Kind::Short(_) => return Err(AbortCode::ReadOnly),
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
            Kind::Domain | Kind::Broken | Kind::Refusing => {}
        }
        self.open = Some((at, vec![]));
        Ok(Transfer::Stream(DOMAIN))
    }

    fn write(&mut self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        match find(at)?.1 {
            Kind::Fixed(exact) if value.len() < exact => return Err(AbortCode::TooShort),
            Kind::Fixed(exact) if value.len() > exact => return Err(AbortCode::TooLong),
            Kind::Limited if *value < [1][..] => return Err(AbortCode::ValueTooLow),
            Kind::Limited if *value > [9][..] => return Err(AbortCode::ValueTooHigh),
            Kind::Text(most) => assert!(value.len() <= most, "more than was allowed"),
            Kind::Limited | Kind::Fixed(_) | Kind::WriteOnly => {}
            _ => panic!("written as a whole"),
        }
        self.commit(at, value.to_vec());
        Ok(())
    }

    fn write_part(&mut self, at: Address, offset: usize, part: &[u8]) -> Result<(), AbortCode> {
        let (open_at, bytes) = self.open.as_mut().expect("a part without a stream");
        assert_eq!((*open_at, bytes.len()), (at, offset), "a part out of order");
        bytes.extend(part);
        assert!(bytes.len() <= DOMAIN, "more than was allowed");
        if find(at)?.1 == Kind::Broken && bytes.len() > BROKEN {
            self.open = None;
            return Err(AbortCode::Hardware);
        }
        Ok(())
    }

    fn finish(&mut self, at: Address, size: usize) -> Result<(), AbortCode> {
        let (open_at, bytes) = self.open.take().expect("an end without a stream");
        assert_eq!((open_at, bytes.len()), (at, size), "the size at the end is not that of the parts");
        if find(at)?.1 == Kind::Refusing {
            return Err(AbortCode::DeviceState);
        }
        self.commit(at, bytes);
        Ok(())
    }

    fn cancel(&mut self, at: Address) {
        let (open_at, _) = self.open.take().expect("cancelled without a stream");
        assert_eq!(open_at, at);
    }
}
