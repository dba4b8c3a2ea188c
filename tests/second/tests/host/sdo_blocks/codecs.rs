//! A server of one object, made of the codecs of `canopen-rs`.
//!
//! The crate has frames, CRC, and how a value is cut into segments and put together again, but no server for blocks.
//! The order of frames is implemented here. It requests sub-blocks of given sizes, and may decline the CRC.

use std::collections::VecDeque;

use canopen_rs::Address as TheirAddress;
use canopen_rs::sdo::block::{self, BlockReceiver, BlockWriter};
use ecss_can::sdo::machine::Payload;
use ecss_can::types::{Address, Instant};

use super::line::Server;

/// The object.
pub const OBJECT: Address = Address::new(0x2000, 0);

/// Room for the largest value and the unused bytes of the last segment.
const ROOM: usize = 20_006;

pub struct Codecs {
    pub value: Vec<u8>,
    /// Whether it knows the CRC.
    crc: bool,
    /// Numbers of segments of its sub-blocks, in turn.
    sizes: Box<dyn Iterator<Item = u8>>,
    state: State,
    responses: VecDeque<Payload>,
}

enum State {
    Idle,
    Download { receiver: Box<BlockReceiver<ROOM>>, size: u8, heard: u8, crc: bool },
    DownloadEnd { receiver: Box<BlockReceiver<ROOM>>, crc: bool },
    Upload { writer: BlockWriter<'static>, crc: bool },
    UploadEnd,
}

impl Codecs {
    pub fn new(crc: bool, sizes: &'static [u8]) -> Codecs {
        let sizes = Box::new(sizes.iter().copied().cycle());
        Codecs { value: Vec::new(), crc, sizes, state: State::Idle, responses: VecDeque::new() }
    }

    fn next_size(&mut self) -> u8 {
        self.sizes.next().expect("they come again and again")
    }

    fn begin(&mut self, request: &Payload) -> State {
        let at = TheirAddress::new(OBJECT.index, OBJECT.sub);
        if let Ok(initiate) = block::decode_download_initiate(request) {
            assert_eq!(initiate.address, at);
            let size = self.next_size();
            self.responses.push_back(block::encode_download_initiate_response(at, size, self.crc));
            let crc = self.crc && initiate.crc_support;
            return State::Download { receiver: Box::default(), size, heard: 0, crc };
        }
        let initiate = block::decode_upload_initiate(request).expect("a block transfer begins");
        assert_eq!(initiate.address, at);
        let size = u32::try_from(self.value.len()).expect("it is small");
        self.responses.push_back(block::encode_upload_initiate_response(at, Some(size), self.crc));
        let value = self.value.clone().leak();
        let crc = self.crc && initiate.crc_support;
        State::Upload { writer: BlockWriter::new(value, initiate.blksize), crc }
    }

    fn send_sub_block(&mut self, writer: &mut BlockWriter) {
        while let Some(segment) = writer.next_segment() {
            self.responses.push_back(segment);
        }
    }
}

impl Server for Codecs {
    fn on_request(&mut self, request: Payload, _now: Instant) {
        self.state = match std::mem::replace(&mut self.state, State::Idle) {
            State::Idle => self.begin(&request),
            State::Download { mut receiver, mut size, mut heard, crc } => {
                let segment = block::decode_sub_segment(&request);
                heard += 1;
                assert_eq!(segment.seqno, heard, "segments come in order");
                receiver.push(&segment).expect("there is room");
                let done = receiver.is_done();
                if done || heard == size {
                    let acknowledged = std::mem::take(&mut heard);
                    size = self.next_size();
                    self.responses.push_back(block::encode_sub_response(acknowledged, size));
                }
                if done {
                    State::DownloadEnd { receiver, crc }
                } else {
                    State::Download { receiver, size, heard, crc }
                }
            }
            State::DownloadEnd { mut receiver, crc } => {
                let (unused, sum) = block::decode_end(&request).expect("the transfer ends");
                self.value = receiver.finish(unused, sum, crc).expect("the CRC is right").to_vec();
                self.responses.push_back(block::encode_end_response());
                State::Idle
            }
            State::Upload { mut writer, crc } => {
                if block::decode_upload_start(&request).is_err() {
                    let (_, size) =
                        block::decode_sub_response(&request).expect("a sub-block is acknowledged");
                    writer.start_sub_block(size);
                }
                if writer.is_done() {
                    self.responses.push_back(writer.end_frame(crc));
                    State::UploadEnd
                } else {
                    self.send_sub_block(&mut writer);
                    State::Upload { writer, crc }
                }
            }
            State::UploadEnd => {
                block::decode_end_response(&request).expect("the transfer has ended well");
                State::Idle
            }
        };
    }

    fn tick(&mut self, _now: Instant) {}

    fn next_response(&mut self) -> Option<Payload> {
        self.responses.pop_front()
    }
}
