//! A node of `zencan-node`: its SDO server, and objects for it to serve.

use std::sync::Mutex;

use ecss_can::sdo::machine::Payload;
use ecss_can::types::{Address, Instant};
use zencan_node::common::NodeId;
use zencan_node::common::messages::{CanId, CanMessage};
use zencan_node::common::objects::{AccessType, DataType, ObjectCode, SubInfo};
use zencan_node::common::sdo::AbortCode;
use zencan_node::object_dict::{ODEntry, ProvidesSubObjects, SubObjectAccess};
use zencan_node::priority_queue::PriorityQueue;
use zencan_node::{Callbacks, Node, NodeMbox, NodeState, SDO_BUFFER_SIZE};

use super::line::Server;

const NODE: u8 = 5;

/// DOMAIN that can be read and written.
pub const DOMAIN: Address = Address::new(0x2000, 0);
/// DOMAIN that cannot be written.
pub const CONSTANT: Address = Address::new(0x2001, 0);
/// DOMAIN that cannot be read.
pub const KEY: Address = Address::new(0x2002, 0);
/// A string of at most 100 bytes.
pub const STRING: Address = Address::new(0x2003, 0);

/// An object without sub-indices.
struct Object {
    access: AccessType,
    data_type: DataType,
    /// Size of its value. Zero is any.
    size: usize,
    bytes: Bytes,
}

/// Its value; the server reads and writes it in parts.
#[derive(Default)]
struct Bytes {
    value: Mutex<Vec<u8>>,
    /// Parts of a download.
    parts: Mutex<Vec<u8>>,
}

impl SubObjectAccess for Bytes {
    fn read(&self, offset: usize, buf: &mut [u8]) -> Result<usize, AbortCode> {
        let value = self.value.lock().unwrap();
        let rest = &value[offset.min(value.len())..];
        let size = rest.len().min(buf.len());
        buf[..size].copy_from_slice(&rest[..size]);
        Ok(size)
    }

    fn read_size(&self) -> usize {
        self.value.lock().unwrap().len()
    }

    fn write(&self, data: &[u8]) -> Result<(), AbortCode> {
        *self.value.lock().unwrap() = data.to_vec();
        Ok(())
    }

    fn begin_partial(&self) -> Result<(), AbortCode> {
        self.parts.lock().unwrap().clear();
        Ok(())
    }

    fn write_partial(&self, buf: &[u8]) -> Result<(), AbortCode> {
        self.parts.lock().unwrap().extend(buf);
        Ok(())
    }

    fn end_partial(&self) -> Result<(), AbortCode> {
        self.write(&self.parts.lock().unwrap())
    }
}

impl ProvidesSubObjects for Object {
    fn get_sub_object(&self, sub: u8) -> Option<(SubInfo, &dyn SubObjectAccess)> {
        let info = SubInfo {
            size: self.size,
            data_type: self.data_type,
            access_type: self.access,
            ..SubInfo::default()
        };
        (sub == 0).then_some((info, &self.bytes))
    }

    fn object_code(&self) -> ObjectCode {
        ObjectCode::Var
    }
}

/// The node. Its static data stays until the end of the tests.
pub struct Zencan {
    node: Node<'static>,
    mailbox: &'static NodeMbox,
    domain: &'static Object,
}

impl Zencan {
    pub fn new() -> Zencan {
        let object = |access, data_type, size| -> &'static Object {
            Box::leak(Box::new(Object {
                access,
                data_type,
                size,
                bytes: Bytes { value: Mutex::new(vec![0xA5; 300]), parts: Mutex::default() },
            }))
        };
        let domain = object(AccessType::Rw, DataType::Domain, 0);
        let entries = Box::leak(Box::new([
            ODEntry { index: DOMAIN.index, data: domain },
            ODEntry { index: CONSTANT.index, data: object(AccessType::Ro, DataType::Domain, 0) },
            ODEntry { index: KEY.index, data: object(AccessType::Wo, DataType::Domain, 0) },
            ODEntry { index: STRING.index, data: object(AccessType::Rw, DataType::OctetString, 100) },
        ]));
        let queue = Box::leak(Box::new(PriorityQueue::<4, CanMessage>::new()));
        let buffer = Box::leak(Box::new([0; SDO_BUFFER_SIZE]));
        let mailbox = Box::leak(Box::new(NodeMbox::new(&[], &[], queue, buffer)));
        let state = Box::leak(Box::new(NodeState::new(&[], &[])));
        let id = NodeId::new(NODE).expect("it is 1 to 127");
        let mut node = Node::new(id, Callbacks::new(), mailbox, state, entries);
        node.process(0);
        Zencan { node, mailbox, domain }
    }

    /// The value of [`DOMAIN`].
    pub fn value(&self) -> Vec<u8> {
        self.domain.bytes.value.lock().unwrap().clone()
    }

    pub fn set(&self, value: &[u8]) {
        *self.domain.bytes.value.lock().unwrap() = value.to_vec();
    }
}

impl Server for Zencan {
    fn on_request(&mut self, request: Payload, now: Instant) {
        let message = CanMessage::new(CanId::std(0x600 + u16::from(NODE)), &request);
        self.mailbox.store_message(message).expect("the node knows its SDO server");
        self.node.process(now.as_micros());
    }

    fn tick(&mut self, now: Instant) {
        self.node.process(now.as_micros());
    }

    fn next_response(&mut self) -> Option<Payload> {
        let response = CanId::std(0x580 + u16::from(NODE));
        // Its boot-up message is not for the client.
        let mut messages = std::iter::from_fn(|| self.mailbox.next_transmit_message());
        messages.find(|message| message.id() == response).map(|message| message.data)
    }
}
