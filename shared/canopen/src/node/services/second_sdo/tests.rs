//! A flipped bit in a COB-ID that the second SDO server uses: it makes the [`Sealed`] COB-ID none.

extern crate std;

use std::vec::Vec;

use super::SECOND;
use crate::node::probe::{Guard, TwoServers};
use crate::node::services::objects::NodeObjects;
use crate::node::services::{SdoStep, Services};
use crate::node::turn::Turn;
use crate::node::{Event, Outbox, Settings};
use crate::sdo::TwoSdoServers;
use crate::store::machine::NoStore;
use crate::types::{Address, CobId, Frame, Instant, NodeId, Sealed};

const ID: NodeId = NodeId::of::<5>();
const NOW: Instant = Instant::from_micros(1_000);
const REQUEST: u32 = 0x6C5;
const ANSWER: u32 = 0x6B5;
/// SYNC, emergencies, a PDO of each direction, both COB-IDs of the second server.
const OBJECTS: usize = 6;

/// Services with a valid channel.
fn services() -> Services<TwoServers, Guard> {
    let settings = Settings::DEFAULT;
    let objects = || NodeObjects::at_power_on(ID, settings.heartbeats, TwoServers::default());
    let mut services = Services::new(ID, objects, NoStore, &settings, || ());
    services.configure(NOW);
    for (sub, id) in [(1, REQUEST), (2, ANSWER)] {
        let mut out = Outbox::<Event>::new();
        let at = Address::new(TwoSdoServers::SECOND.index(), sub);
        services.write(at, &id.to_le_bytes(), NOW).unwrap();
        services.on_own_written(at, &mut Turn::new(NOW, &mut out));
    }
    services
}

/// COB-IDs of the answers to a request of the second client.
fn ask(services: &mut Services<TwoServers, Guard>, request: [u8; 8]) -> Vec<u16> {
    let mut answers = Vec::new();
    let id = CobId::new(REQUEST as u16).unwrap();
    if services.is_sdo(id) {
        let frame = Frame::of(id, request);
        services.serve(SdoStep::Request(&frame), NOW, &mut |frame| answers.push(frame.id().raw()));
    }
    answers
}

fn mended(services: &Services<TwoServers, Guard>) -> u16 {
    services.objects().extension.mended
}

/// Given a valid channel and a transfer on it, when a bit of a COB-ID flips where the server has it, then the server takes no request and
/// is not due. The comparison of copies mends the bit, and the transfer continues.
///
/// Verifies: ECSS 6.10d
#[test]
fn a_flipped_bit_makes_the_channel_wait_until_it_is_mended() {
    for nth in 0..2 {
        let mut services = services();
        // A segmented download of one byte.
        assert_eq!(ask(&mut services, [0x21, 0x00, 0x60, 0, 1, 0, 0, 0]), [ANSWER as u16]);
        assert!(services.is_sdo_busy() && services.second_sdo_deadline().is_some());
        services.second_sdo[0].ids[nth] = Sealed::NONE;
        assert_eq!(ask(&mut services, [0x0D, 7, 0, 0, 0, 0, 0, 0]), []);
        assert!(!services.is_sdo_busy() && services.second_sdo_deadline().is_none());
        (0..OBJECTS).for_each(|_| _ = services.compare_cob_ids(NOW));
        assert_eq!(mended(&services), 1);
        assert_eq!(ask(&mut services, [0x0D, 7, 0, 0, 0, 0, 0, 0]), [ANSWER as u16]);
        assert_eq!(services.server_of(CobId::new(REQUEST as u16).unwrap()), SECOND);
    }
}

/// Verifies: ECSS 6.10d
#[test]
fn nothing_is_reported_where_no_bit_of_the_channel_has_flipped() {
    let mut services = services();
    (0..2 * OBJECTS).for_each(|_| assert!(!services.compare_cob_ids(NOW)));
    assert_eq!(mended(&services), 0);
}

/// Given a valid channel, when a bit of a second copy flips, then it is right again and the channel works.
///
/// Verifies: ECSS 6.10d
#[test]
fn a_flipped_bit_of_a_second_copy_is_mended() {
    for nth in 0..2 {
        let mut services = services();
        services.second_sdo[0].copies[nth] = super::Copied::NONE;
        (0..OBJECTS).for_each(|_| _ = services.compare_cob_ids(NOW));
        assert_eq!(mended(&services), 1);
        let second = services.objects().sdo.second;
        assert_eq!([second.request, second.response], [REQUEST, ANSWER]);
        assert_eq!(ask(&mut services, [0x40, 0x00, 0x60, 0, 0, 0, 0, 0]), [ANSWER as u16]);
    }
}
