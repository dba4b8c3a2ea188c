//! Object 1201h: the rules of CiA 301 7.5.2.34 for its values.

use async_canopen::od::{Objects, checked};
use async_canopen::sdo::{SdoServerObjects, SdoServers, TwoSdoServers};
use async_canopen::types::{AbortCode, Address};

use crate::bench::node;

const NOT_VALID: u32 = 0x8000_0000;

fn at(sub: u8) -> Address {
    Address::new(0x1201, sub)
}

/// A write of a client.
fn write(servers: &mut TwoSdoServers, sub: u8, value: u32) -> Result<(), AbortCode> {
    servers.may_write(at(sub), value)?;
    let bytes = value.to_le_bytes();
    checked::write(servers, at(sub), if sub == 3 { &bytes[..1] } else { &bytes })
}

#[test]
fn a_second_channel_is_not_valid_at_power_on() {
    let servers = TwoSdoServers::at_power_on(node(5));
    assert_eq!(servers.default, SdoServerObjects::of(node(5)));
    assert_eq!(servers.cob_ids(), Some([NOT_VALID; 2]));
    assert_eq!(servers.second.client, 0);
    assert_eq!(TwoSdoServers::SECOND_SERVER, Some(0x1201));
    // Index, number of sub-indices, structure 22h: SDO parameter.
    let mut found = vec![];
    TwoSdoServers::describe(&mut |object, names| found.push((object.index, names.structure)));
    assert_eq!(found, [(0x1201, 0x22), (0x1200, 0x22)]);
}

#[test]
fn the_default_server_alone_has_no_1201h() {
    let mut servers = SdoServerObjects::at_power_on(node(5));
    assert_eq!((SdoServerObjects::SECOND_SERVER, servers.cob_ids()), (None, None));
    assert!(servers.cob_ids_mut().is_none());
    assert_eq!(checked::write(&mut servers, at(1), &[0; 4]), Err(AbortCode::NoObject));
    assert_eq!(SdoServerObjects::second(|| 7).len(), 0);
}

#[test]
fn a_cob_id_changes_while_it_is_not_valid() {
    for sub in [1, 2] {
        let mut servers = TwoSdoServers::at_power_on(node(5));
        for value in [NOT_VALID | 0x6C6, 0x6C6, 0x6C6, NOT_VALID | 0x6C6, 0x6C5] {
            assert_eq!(write(&mut servers, sub, value), Ok(()), "{sub} {value:08X}");
        }
        for value in [0x6C6, NOT_VALID | 0x6C6, NOT_VALID] {
            assert_eq!(write(&mut servers, sub, value), Err(AbortCode::ValueRange), "{sub} {value:08X}");
        }
        let values = servers.cob_ids_mut().map(|ids| ids.map(|id| *id));
        assert_eq!(values, Some(if sub == 1 { [0x6C5, NOT_VALID] } else { [NOT_VALID, 0x6C5] }));
    }
}

#[test]
fn restricted_and_extended_identifiers_are_refused() {
    for sub in [1, 2] {
        let mut servers = TwoSdoServers::at_power_on(node(5));
        for value in [0x000, 0x07F, 0x101, 0x180, 0x581, 0x605, 0x6E0, 0x701, 0x7FF] {
            assert_eq!(write(&mut servers, sub, value), Err(AbortCode::ValueRange), "{sub} {value:03X}");
            assert_eq!(write(&mut servers, sub, NOT_VALID | value), Ok(()), "{sub} {value:03X}");
        }
        for value in [0x2000_06C5, 0xA000_06C5, 0x0000_0EC5, 0x4000_06C5, 0xC000_06C5] {
            assert_eq!(write(&mut servers, sub, value), Err(AbortCode::ValueRange), "{sub} {value:08X}");
        }
    }
}

#[test]
fn both_directions_have_different_identifiers() {
    let mut servers = TwoSdoServers::at_power_on(node(5));
    assert_eq!(write(&mut servers, 1, 0x6C5), Ok(()));
    assert_eq!(write(&mut servers, 2, 0x6C5), Err(AbortCode::ParameterIncompatible));
    assert_eq!(write(&mut servers, 2, NOT_VALID | 0x6C5), Ok(()));
    assert_eq!(write(&mut servers, 2, 0x6B5), Ok(()));
    assert_eq!(servers.cob_ids(), Some([0x6C5, 0x6B5]));
}

#[test]
fn the_client_is_a_node_id_or_none() {
    let mut servers = TwoSdoServers::at_power_on(node(5));
    for (value, expected) in [(127, Ok(())), (128, Err(AbortCode::ValueTooHigh)), (1, Ok(())), (0, Ok(()))] {
        assert_eq!(write(&mut servers, 3, value), expected, "{value}");
    }
    // Other objects are no matter of this one.
    assert_eq!(servers.may_write(Address::new(0x1014, 0), 0x7FF), Ok(()));
}
