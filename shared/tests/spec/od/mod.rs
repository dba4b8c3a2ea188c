//! The object dictionary of a node: the objects that every node has, and checks of the application.

mod check;
mod node;

use ecss_can::od::machine::Transfer;
use ecss_can::od::{Objects, checked};
use ecss_can::types::{AbortCode, Address};

fn at(index: u16, sub: u8) -> Address {
    Address::new(index, sub)
}

fn read<D: Objects>(device: &mut D, index: u16, sub: u8) -> Result<Vec<u8>, AbortCode> {
    let mut found = checked::find(device, at(index, sub))?;
    let (Transfer::Whole(len) | Transfer::Stream(len)) = found.upload()?;
    let mut bytes = [0xEE; 32];
    let count = found.read(0, &mut bytes);
    assert_eq!(count, len);
    Ok(bytes[..count].to_vec())
}

fn write<D: Objects>(device: &mut D, index: u16, sub: u8, value: &[u8]) -> Result<(), AbortCode> {
    checked::find(device, at(index, sub))?.write(value)
}
