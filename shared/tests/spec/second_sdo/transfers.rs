//! Transfers of both servers at once.
//!
//! Verifies: ECSS 6.1a

use ecss_can::node::DeviceNode;
use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::types::AbortCode;

use super::{
    BLOCK, BOTH, DEVICE_STATE, FIRST, Recorder, SECOND, SECOND_SDO, SPARE, Transfer, answers, ask, blocks,
    fill, open, pattern, plain_slave, read, run, spacecraft_slave, write,
};
use crate::bench::{Bench, NOMINAL, span};
use crate::device::fixture::{done, initiate, refused};

const MODES: [Mode; 2] = [Mode::Segmented, Mode::Block];

fn every_pair_of_modes(slave: &mut Bench<impl DeviceNode<Device = Recorder>>) {
    open(slave);
    for (nth, one) in MODES.into_iter().enumerate() {
        for other in MODES {
            let seed = (nth as u8) << 4;
            let values = [pattern(1_500, seed), pattern(1_300, seed | 1)];
            let mut writes = [
                Transfer::download(FIRST, BLOCK, values[0].clone(), one),
                Transfer::download(SECOND, SPARE, values[1].clone(), other),
            ];
            run(slave, &mut writes);
            assert_eq!(
                writes.map(|write| write.outcome),
                [Some(Ok(1_500)), Some(Ok(1_300))],
                "{one:?} {other:?}"
            );
            assert_eq!(blocks(slave), values, "{one:?} {other:?}");
            // Each reads what the other one wrote.
            let mut reads = [Transfer::upload(SECOND, BLOCK, other), Transfer::upload(FIRST, SPARE, one)];
            run(slave, &mut reads);
            assert_eq!(reads.each_ref().map(|read| read.outcome), [Some(Ok(1_500)), Some(Ok(1_300))]);
            assert_eq!(reads.map(|read| read.read), values, "{one:?} {other:?}");
        }
    }
}

/// Given two clients, when their frames reach a slave in turn, then each of its servers moves its value by segments or blocks.
#[test]
fn both_servers_transfer_at_once() {
    every_pair_of_modes(&mut spacecraft_slave());
    every_pair_of_modes(&mut plain_slave());
}

/// Given a long transfer of one server, then the other one reads and writes numbers between its frames.
#[test]
fn numbers_move_between_the_segments_of_the_other_server() {
    let mut slave = spacecraft_slave();
    open(&mut slave);
    for [one, other] in [[FIRST, SECOND], [SECOND, FIRST]] {
        let value = pattern(700, 9);
        assert_eq!(ask(&mut slave, one, initiate(BLOCK, 0, value.len())), done(BLOCK, 0));
        let segments = value.chunks(7).enumerate();
        let last = segments.len() - 1;
        for (nth, bytes) in segments {
            let toggle = (nth as u8 & 1) << 4;
            let mut segment = [toggle | u8::from(nth == last), 0, 0, 0, 0, 0, 0, 0];
            segment[1..].copy_from_slice(bytes);
            assert_eq!(ask(&mut slave, one, segment)[0], 0x20 | toggle);
            let number = nth as u32 * 3;
            assert_eq!(write(&mut slave, other, 0x6000, 0, &number.to_le_bytes()), done(0x6000, 0));
            assert_eq!(read(&mut slave, other, 0x6000, 0), number);
        }
        assert_eq!(blocks(&mut slave)[0], value);
    }
}

fn one_long_object(slave: &mut Bench<impl DeviceNode<Device = Recorder>>) {
    open(slave);
    let value = pattern(600, 0x55);
    fill(slave, BLOCK, &value);
    let upload = [0x40, 0x00, 0x63, 0, 0, 0, 0, 0];
    let block_upload = [0xA4, 0x00, 0x63, 0, 127, 0, 0, 0];
    let block_download = [0xC6, 0x00, 0x63, 0, 100, 0, 0, 0];
    let expedited = [0x23, 0x00, 0x63, 0, 1, 2, 3, 4];
    let downloads = [initiate(BLOCK, 0, 100), block_download];
    let uploads = [upload, block_upload];
    let late = refused(BLOCK, 0, DEVICE_STATE);
    for [one, other] in [[FIRST, SECOND], [SECOND, FIRST]] {
        for begun in downloads {
            assert_ne!(ask(slave, one, begun)[0], 0x80, "{begun:02X?}");
            for second in downloads.into_iter().chain(uploads).chain([expedited]) {
                assert_eq!(ask(slave, other, second), late, "{begun:02X?} {second:02X?}");
            }
            slave.receive(NOMINAL, one.request, &[0x80, 0x00, 0x63, 0, 0, 0, 0, 0x08]);
            assert_eq!(blocks(slave)[0], value, "{begun:02X?}");
        }
        for begun in uploads {
            assert_ne!(ask(slave, one, begun)[0], 0x80, "{begun:02X?}");
            for second in downloads.into_iter().chain([expedited]) {
                assert_eq!(ask(slave, other, second), late, "{begun:02X?} {second:02X?}");
            }
            // Two readers do not disturb each other.
            let mut reads = [Transfer::upload(other, BLOCK, Mode::Block)];
            run(slave, &mut reads);
            assert_eq!(reads[0].read, value);
            slave.receive(NOMINAL, one.request, &[0x80, 0x00, 0x63, 0, 0, 0, 0, 0x08]);
        }
        // Another object, and the same one after the end.
        assert_eq!(ask(slave, one, downloads[0]), done(BLOCK, 0));
        assert_eq!(ask(slave, other, initiate(SPARE, 0, 100)), done(SPARE, 0));
        for channel in BOTH {
            slave.receive(NOMINAL, channel.request, &[0x80, 0, 0, 0, 0, 0, 0, 0x08]);
        }
        let mut writes = [Transfer::download(other, BLOCK, value.clone(), Mode::Segmented)];
        run(slave, &mut writes);
        assert_eq!(writes[0].outcome, Some(Ok(value.len())));
    }
}

/// Given a client that writes or reads a block of bytes, when another client begins to write it, or to read what is being written, then
/// the later one gets 0800 0022h, and the transfer of the first one goes on.
#[test]
fn a_long_object_has_one_writer_and_no_reader_beside_it() {
    one_long_object(&mut spacecraft_slave());
    one_long_object(&mut plain_slave());
}

/// Given a block that is being written, when another client is refused, then the first one ends its transfer as if it were alone.
#[test]
fn a_refused_client_does_not_disturb_the_first_one() {
    for mode in MODES {
        let mut slave = spacecraft_slave();
        open(&mut slave);
        let value = pattern(900, 3);
        let mut transfers = [
            Transfer::download(SECOND, BLOCK, value.clone(), mode),
            Transfer::download(FIRST, BLOCK, pattern(900, 4), mode),
        ];
        run(&mut slave, &mut transfers);
        let outcomes = transfers.map(|transfer| transfer.outcome);
        assert_eq!(outcomes, [Some(Ok(900)), Some(Err(Error::Abort(AbortCode::DeviceState)))], "{mode:?}");
        assert_eq!(blocks(&mut slave)[0], value, "{mode:?}");
    }
}

/// Given a client that falls silent while it writes a block, then its transfer ends after the SDO timeout, and the other client may write.
#[test]
fn a_silent_client_gives_the_object_back_after_the_timeout() {
    let mut slave = plain_slave();
    open(&mut slave);
    assert_eq!(ask(&mut slave, SECOND, initiate(BLOCK, 0, 100)), done(BLOCK, 0));
    let (before, after) = (slave.now + span(499), slave.now + span(500));
    slave.clear();
    slave.run_until(before);
    assert_eq!(answers(&slave, SECOND), [[0; 8]; 0]);
    assert_eq!(ask(&mut slave, FIRST, initiate(BLOCK, 0, 100)), refused(BLOCK, 0, DEVICE_STATE));
    slave.clear();
    slave.run_until(after);
    assert_eq!(answers(&slave, SECOND), [refused(BLOCK, 0, 0x0504_0000)]);
    assert_eq!(answers(&slave, FIRST), [[0; 8]; 0]);
    assert_eq!(ask(&mut slave, FIRST, initiate(BLOCK, 0, 100)), done(BLOCK, 0));
}

/// Given two clients that write one text in segments, then each text is written as a whole: the one that ends later stays.
#[test]
fn short_values_are_written_as_a_whole() {
    let mut slave = spacecraft_slave();
    open(&mut slave);
    let mut writes = [
        Transfer::download(FIRST, 0x6302, b"first text, which is longer".to_vec(), Mode::Segmented),
        Transfer::download(SECOND, 0x6302, b"second text".to_vec(), Mode::Segmented),
    ];
    run(&mut slave, &mut writes);
    assert_eq!(writes.map(|write| write.outcome), [Some(Ok(27)), Some(Ok(11))]);
    let text = slave.touch(|slave, now| slave.change(now, |recorder| recorder.text));
    assert_eq!(text.as_bytes(), b"first text, which is longer");
}

fn stop(slave: &mut Bench<impl DeviceNode<Device = Recorder>>) {
    open(slave);
    let value = pattern(300, 7);
    fill(slave, BLOCK, &value);
    assert_eq!(ask(slave, SECOND, initiate(BLOCK, 0, 100)), done(BLOCK, 0));
    slave.receive(NOMINAL, 0x000, &[2, 5]);
    slave.clear();
    slave.receive(NOMINAL, SECOND.request, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    let until = slave.now + span(700);
    slave.run_until(until);
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(answers(slave, SECOND), [[0; 8]; 0]);
    assert_eq!(blocks(slave)[0], value);
    // The channel stays valid.
    assert_eq!(read(slave, SECOND, SECOND_SDO, 1), SECOND.request.into());
}

/// Given a transfer of the second server, when the slave is stopped, then it ends without an abort.
#[test]
fn stopped_ends_the_transfer_of_the_second_server() {
    stop(&mut plain_slave());
}

/// Given a transfer of the second server, when a client changes or switches off its COB-IDs, then the transfer ends without an abort.
#[test]
fn a_changed_cob_id_ends_the_transfer_of_its_server() {
    let mut slave = plain_slave();
    open(&mut slave);
    let value = pattern(300, 7);
    fill(&mut slave, BLOCK, &value);
    for sub in [1, 2] {
        let own = if sub == 1 { SECOND.request } else { SECOND.answer };
        assert_eq!(ask(&mut slave, SECOND, initiate(BLOCK, 0, 100)), done(BLOCK, 0));
        // Sub-index 3 changes nothing.
        assert_eq!(write(&mut slave, FIRST, SECOND_SDO, 3, &[9]), done(SECOND_SDO, 3));
        assert_eq!(ask(&mut slave, SECOND, [0x00, 1, 2, 3, 4, 5, 6, 7])[0], 0x20);
        let off = (0x8000_0000 | u32::from(own)).to_le_bytes();
        assert_eq!(write(&mut slave, FIRST, SECOND_SDO, sub, &off), done(SECOND_SDO, sub));
        slave.clear();
        slave.receive(NOMINAL, SECOND.request, &[0x10, 1, 2, 3, 4, 5, 6, 7]);
        let until = slave.now + span(700);
        slave.run_until(until);
        assert_eq!(answers(&slave, SECOND), [[0; 8]; 0]);
        assert_eq!(blocks(&mut slave)[0], value);
        let on = u32::from(own).to_le_bytes();
        assert_eq!(write(&mut slave, FIRST, SECOND_SDO, sub, &on), done(SECOND_SDO, sub));
        assert_eq!(ask(&mut slave, FIRST, initiate(BLOCK, 0, 100)), done(BLOCK, 0), "it is free again");
        slave.receive(NOMINAL, FIRST.request, &[0x80, 0, 0, 0, 0, 0, 0, 0x08]);
    }
    // A client switches off its own channel, and is answered.
    let off = (0x8000_0000 | u32::from(SECOND.request)).to_le_bytes();
    assert_eq!(write(&mut slave, SECOND, SECOND_SDO, 1, &off), done(SECOND_SDO, 1));
}
