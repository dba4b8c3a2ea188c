//! Errors: each public one can be shown, and goes into a `Box<dyn Error>` by `?`.

use std::error::Error;

use ecss_can::boot::BootFailure;
use ecss_can::link::Miss;
use ecss_can::link::bit_timing::BitTimingError;
use ecss_can::link::machine::Full;
use ecss_can::link::port::Busy;
use ecss_can::node::{ParallelAccess, Refusal};
use ecss_can::sdo;
use ecss_can::store::StoreError;
use ecss_can::store::identity::{NoNodeId, Straps, node_id};
use ecss_can::sync::machine::UnexpectedLength;
use ecss_can::time::NoTime;
use ecss_can::types::{AbortCode, CobId, Frame, FrameError};

use crate::bench::node;

const fn assert_error<E: Error>() {}

const _: () = {
    assert_error::<AbortCode>();
    assert_error::<BitTimingError>();
    assert_error::<BootFailure>();
    assert_error::<Busy>();
    assert_error::<FrameError>();
    assert_error::<Full>();
    assert_error::<Miss>();
    assert_error::<NoNodeId>();
    assert_error::<NoTime>();
    assert_error::<ParallelAccess>();
    assert_error::<Refusal>();
    assert_error::<StoreError>();
    assert_error::<UnexpectedLength>();
    assert_error::<sdo::Error>();
};

fn long_frame() -> Result<Frame, Box<dyn Error>> {
    Ok(Frame::new(CobId::SYNC, &[0; 9])?)
}

fn contradiction() -> Result<(), Box<dyn Error>> {
    node_id(Straps::Closed(node(3)), Some(node(4)))?;
    Ok(())
}

#[test]
fn errors_say_what_is_wrong() {
    let text = |error: Box<dyn Error>| error.to_string();
    assert_eq!(long_frame().map_err(text), Err("a CAN frame has at most 8 data bytes".to_owned()));
    let expected = "the straps say Node-ID 3, the store says 4";
    assert_eq!(contradiction().map_err(text), Err(expected.to_owned()));
    let refused = sdo::Error::Abort(AbortCode::ReadOnly);
    let expected = "the server aborted the transfer: attempt to write a read-only object (06010002h)";
    assert_eq!(refused.to_string(), expected);
}

/// Given the abort codes of CiA 301, then the text of each ends with its value, and no two have one text.
#[test]
fn each_abort_code_has_a_text_of_its_own() {
    let texts = AbortCode::ALL.map(|code| code.to_string());
    for (code, text) in AbortCode::ALL.iter().zip(&texts) {
        assert!(text.ends_with(&format!(" ({:08X}h)", code.code())), "{text}");
    }
    let distinct: std::collections::BTreeSet<_> = texts.iter().collect();
    assert_eq!(distinct.len(), AbortCode::ALL.len());
}
