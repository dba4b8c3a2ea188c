//! Object 1201h of a slave: what may be written, and when the channel works.
//!
//! Verifies: ECSS 6.1a, 6.8a

use ecss_can::node::DeviceNode;
use ecss_can::types::{Bus, NmtState};

use super::{
    FIRST, Recorder, SECOND, SECOND_SDO, answers, ask, open, plain_slave, read, spacecraft_slave, write,
};
use crate::bench::{Bench, NOMINAL, node, span};
use crate::device::fixture::{done, powered, refused};

const NOT_VALID: u32 = 0x8000_0000;
const READ: [u8; 8] = [0x40, 0x00, 0x60, 0, 0, 0, 0, 0];

/// Given a slave that does not declare a second server, then 1201h does not exist.
#[test]
fn a_device_without_a_second_server_has_no_1201h() {
    let mut slave = powered();
    let request = |sub| [0x40, 0x01, 0x12, sub, 0, 0, 0, 0];
    for sub in 0..4 {
        assert_eq!(ask(&mut slave, FIRST, request(sub)), refused(SECOND_SDO, sub, 0x0602_0000));
    }
}

#[test]
fn the_channel_is_not_valid_at_power_on() {
    let mut slave = spacecraft_slave();
    let values = [0, 1, 2, 3].map(|sub| read(&mut slave, FIRST, SECOND_SDO, sub));
    assert_eq!(values, [3, NOT_VALID, NOT_VALID, 0]);
}

/// `ignored`: frames that the node counted as ignored.
fn opens_in_two_steps<N: DeviceNode<Device = Recorder>>(
    slave: &mut Bench<N>,
    ignored: impl Fn(&Bench<N>) -> u16,
) {
    let is_silent = |slave: &mut Bench<N>| {
        let before = ignored(slave);
        slave.clear();
        slave.receive(NOMINAL, SECOND.request, &READ);
        slave.receive(NOMINAL, SECOND.answer, &READ);
        assert_eq!((slave.frames(), ignored(slave) - before), (vec![], 2));
    };
    is_silent(slave);
    let own = [SECOND.request, SECOND.answer].map(u32::from);
    for subs in [[1, 2], [2, 1]] {
        for (step, sub) in subs.into_iter().enumerate() {
            let id = own[usize::from(sub) - 1];
            assert_eq!(write(slave, FIRST, SECOND_SDO, sub, &id.to_le_bytes()), done(SECOND_SDO, sub));
            if step == 0 {
                is_silent(slave);
            }
        }
        assert_eq!(read(slave, SECOND, SECOND_SDO, 1), own[0]);
        for sub in subs {
            let id = own[usize::from(sub) - 1] | NOT_VALID;
            assert_eq!(write(slave, FIRST, SECOND_SDO, sub, &id.to_le_bytes()), done(SECOND_SDO, sub));
            is_silent(slave);
        }
    }
}

/// Given a second channel, when one or both of its COB-IDs are not valid, then its frames are ignored and counted.
#[test]
fn the_channel_works_while_both_cob_ids_are_valid() {
    opens_in_two_steps(&mut plain_slave(), |slave| slave.node.counters().ignored);
    opens_in_two_steps(&mut spacecraft_slave(), |slave| {
        slave.node.status(slave.now).counters[Bus::Nominal].ignored
    });
}

/// CiA 301 7.5.2.34. In use: 080h SYNC, 085h EMCY, 205h RPDO 1, 185h TPDO 1, 605h and 585h the first server. 181h belongs to node 1, which
/// 1016h names.
#[test]
fn cob_ids_that_cannot_be_are_refused() {
    let mut slave = spacecraft_slave();
    let range = 0x0609_0030;
    let in_use = 0x0604_0043;
    let table: [(u8, u32, u32); 22] = [
        (1, 0x605, range), // restricted identifiers: CiA 301 7.3.5
        (1, 0x000, range),
        (2, 0x585, range),
        (2, 0x6E0, range),
        (2, 0x701, range),
        (2, 0x7FF, range),
        (1, 0x2000_06C5, range), // an extended frame
        (1, 0x0000_0800, range),
        (1, 0xA000_06C5, range),
        (1, 0x4000_06C5, range), // assigned dynamically
        (1, 0xC000_06C5, range),
        (1, 0x080, in_use),
        (2, 0x080, in_use),
        (1, 0x085, in_use),
        (2, 0x085, in_use),
        (1, 0x205, in_use),
        (2, 0x205, in_use),
        (1, 0x185, in_use),
        (2, 0x185, in_use),
        (2, 0x181, in_use), // of another node
        (2, 0x081, in_use),
        (3, 128, 0x0609_0031), // a Node-ID
    ];
    for (sub, value, code) in table {
        let bytes = value.to_le_bytes();
        let value = if sub == 3 { &bytes[..1] } else { &bytes[..] };
        assert_eq!(
            write(&mut slave, FIRST, SECOND_SDO, sub, value),
            refused(SECOND_SDO, sub, code),
            "sub {sub}: {value:02X?}"
        );
    }
    // An identifier that is not valid may be any.
    assert_eq!(write(&mut slave, FIRST, SECOND_SDO, 1, &0x8000_0205_u32.to_le_bytes()), done(SECOND_SDO, 1));
    open(&mut slave);
    for (sub, value, code) in [
        (1, 0x6C6, range), // another identifier while it is valid
        (1, 0x8000_06C6, range),
        (2, 0x6B6, range),
    ] {
        let value: u32 = value;
        assert_eq!(
            write(&mut slave, FIRST, SECOND_SDO, sub, &value.to_le_bytes()),
            refused(SECOND_SDO, sub, code),
            "sub {sub}: {value:08X}h"
        );
    }
    assert_eq!(write(&mut slave, FIRST, SECOND_SDO, 1, &0x8000_06C5_u32.to_le_bytes()), done(SECOND_SDO, 1));
    // Both directions with one identifier.
    assert_eq!(
        write(&mut slave, FIRST, SECOND_SDO, 1, &0x6B5_u32.to_le_bytes()),
        refused(SECOND_SDO, 1, in_use)
    );
}

/// Given a valid second channel, then SYNC, EMCY and PDOs cannot have its COB-IDs.
#[test]
fn no_other_object_takes_a_cob_id_of_the_channel() {
    let mut slave = spacecraft_slave();
    open(&mut slave);
    let off = |slave: &mut _, index, sub, id: u32| {
        assert_eq!(write(slave, FIRST, index, sub, &(NOT_VALID | id).to_le_bytes()), done(index, sub));
    };
    off(&mut slave, 0x1014, 0, 0x85);
    off(&mut slave, 0x1400, 1, 0x4000_0205);
    off(&mut slave, 0x1800, 1, 0x4000_0185);
    for id in [SECOND.request, SECOND.answer].map(u32::from) {
        for (index, sub, flags) in
            [(0x1005, 0, 0), (0x1014, 0, 0), (0x1400, 1, 1 << 30), (0x1800, 1, 1 << 30)]
        {
            assert_eq!(
                write(&mut slave, FIRST, index, sub, &(flags | id).to_le_bytes()),
                refused(index, sub, 0x0604_0043),
                "{index:04X}h {id:03X}h"
            );
        }
    }
    // They may as soon as it is not valid.
    off(&mut slave, SECOND_SDO, 1, SECOND.request.into());
    let id = 0x4000_0000 | u32::from(SECOND.request);
    assert_eq!(write(&mut slave, FIRST, 0x1400, 1, &id.to_le_bytes()), done(0x1400, 1));
    assert_eq!(
        write(&mut slave, FIRST, SECOND_SDO, 1, &u32::from(SECOND.request).to_le_bytes()),
        refused(SECOND_SDO, 1, 0x0604_0043)
    );
}

/// Given a second channel, then the controllers admit its requests while it is valid, and its answers never.
#[test]
fn the_filter_follows_the_object() {
    let mut slave = spacecraft_slave();
    let admitted = |slave: &mut Bench<_>| {
        let until = slave.now + span(5);
        slave.run_until(until);
        Bus::ALL.map(|bus| [SECOND.request, SECOND.answer].map(|id| slave.admits(bus, id)))
    };
    assert_eq!(admitted(&mut slave), [[false; 2]; 2]);
    open(&mut slave);
    assert_eq!(admitted(&mut slave), [[true, false]; 2]);
    let off = (NOT_VALID | u32::from(SECOND.answer)).to_le_bytes();
    assert_eq!(write(&mut slave, FIRST, SECOND_SDO, 2, &off), done(SECOND_SDO, 2));
    assert_eq!(admitted(&mut slave), [[false; 2]; 2]);
    open_again(&mut slave);
    assert_eq!(admitted(&mut slave), [[true, false]; 2]);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(admitted(&mut slave), [[false; 2]; 2]);
}

/// Writes the COB-ID of answers once more.
fn open_again(slave: &mut Bench<impl DeviceNode<Device = Recorder>>) {
    let on = u32::from(SECOND.answer).to_le_bytes();
    assert_eq!(write(slave, FIRST, SECOND_SDO, 2, &on), done(SECOND_SDO, 2));
}

/// Given a valid second channel, when the communication is reset, then the channel is as at power-on.
#[test]
fn reset_communication_switches_the_channel_off() {
    let mut slave = plain_slave();
    open(&mut slave);
    assert_eq!(write(&mut slave, FIRST, SECOND_SDO, 3, &[9]), done(SECOND_SDO, 3));
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(slave.node.state(), NmtState::PreOperational);
    slave.clear();
    slave.receive(NOMINAL, SECOND.request, &READ);
    assert_eq!(answers(&slave, SECOND), [[0; 8]; 0]);
    let values = [1, 2, 3].map(|sub| read(&mut slave, FIRST, SECOND_SDO, sub));
    assert_eq!(values, [NOT_VALID, NOT_VALID, 0]);
    assert_eq!(slave.node.objects().sdo.second.client, 0);
    assert_eq!(slave.node.objects().communication.emcy.cob_id, u32::from(0x80 + node(5).get()));
}
