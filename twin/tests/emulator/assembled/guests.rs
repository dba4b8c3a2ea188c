//! Foreign controllers that join and leave.

use can_twin::guest::{GuestEvent, Presence};
use can_twin::spacecraft::{Bus, GuestId, Spacecraft, SpacecraftConfig};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;

use super::programs::heard;

/// Two guests on the nominal bus, no board.
fn two() -> (Spacecraft, [GuestId; 2]) {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let guests = [0.0, 10.0].map(|position_m| spacecraft.add_guest(Bus::Nominal, position_m));
    (spacecraft, guests)
}

fn fly(spacecraft: &mut Spacecraft, ms: u64) {
    spacecraft.run_until(Time::from_ms(ms)).unwrap();
}

#[test]
fn a_guest_hears_others_and_is_told_what_it_sent() {
    let (mut spacecraft, [one, other]) = two();
    let (low, high) = (WireFrame::standard(0x111, &[1]), WireFrame::standard(0x222, &[2, 2]));
    spacecraft.inject(one, Time::from_ms(1), high);
    spacecraft.inject(other, Time::from_ms(1), low);
    fly(&mut spacecraft, 2);
    let at_one = spacecraft.take_heard(one);
    assert_eq!(
        at_one.iter().map(|(_, heard)| *heard).collect::<Vec<_>>(),
        [GuestEvent::Received(low), GuestEvent::Sent(high)]
    );
    assert_eq!(heard(&mut spacecraft, other), [GuestEvent::Sent(low), GuestEvent::Received(high)]);
    // 52 bits without and some with stuffing: a frame with one byte, reported when it is valid.
    let first = at_one[0].0.since(Time::from_ms(1));
    assert!(first > Time::from_us(50) && first < Time::from_us(70), "{first:?}");
    assert_eq!(heard(&mut spacecraft, one), [], "it is told once");
}

#[test]
fn a_guest_that_is_away_hears_nothing_and_acknowledges_nothing() {
    let (mut spacecraft, [one, other]) = two();
    let frame = WireFrame::standard(0x123, &[4, 5, 6]);
    spacecraft.set_presence(other, Presence::Away);
    fly(&mut spacecraft, 1);
    spacecraft.inject(one, Time::from_ms(1), frame);
    fly(&mut spacecraft, 3);
    assert_eq!(heard(&mut spacecraft, one), []);
    assert!(spacecraft.wire(Bus::Nominal).counters().ack_errors > 0);
    spacecraft.set_presence(other, Presence::Present);
    fly(&mut spacecraft, 5);
    assert_eq!(heard(&mut spacecraft, one), [GuestEvent::Sent(frame)]);
    assert_eq!(heard(&mut spacecraft, other), [GuestEvent::Received(frame)]);
}

#[test]
fn a_guest_that_listens_hears_without_acknowledging() {
    let (mut spacecraft, [one, other]) = two();
    let frame = WireFrame::standard(0x123, &[]);
    spacecraft.set_presence(other, Presence::Listening);
    fly(&mut spacecraft, 1);
    spacecraft.inject(one, Time::from_ms(1), frame);
    fly(&mut spacecraft, 3);
    assert_eq!(heard(&mut spacecraft, one), [], "nobody acknowledges");
    spacecraft.set_presence(other, Presence::Present);
    fly(&mut spacecraft, 5);
    assert_eq!(heard(&mut spacecraft, one), [GuestEvent::Sent(frame)]);
}

#[test]
fn a_guest_that_leaves_drops_what_it_has_not_sent() {
    let (mut spacecraft, [one, other]) = two();
    spacecraft.inject(one, Time::from_ms(1), WireFrame::standard(0x123, &[]));
    spacecraft.set_presence(one, Presence::Away);
    fly(&mut spacecraft, 2);
    spacecraft.set_presence(one, Presence::Present);
    fly(&mut spacecraft, 4);
    assert_eq!(heard(&mut spacecraft, one), []);
    assert_eq!(heard(&mut spacecraft, other), []);
    let next = WireFrame::standard(0x321, &[]);
    spacecraft.inject(one, Time::from_ms(4), next);
    fly(&mut spacecraft, 5);
    assert_eq!(heard(&mut spacecraft, one), [GuestEvent::Sent(next)]);
}
