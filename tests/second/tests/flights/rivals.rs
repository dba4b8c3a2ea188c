//! A foreign node sends the master's heartbeat, 701h: the master reports it and continues.

use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

/// Returns the answer of the master when the guest reads 1001h, or 1003h sub 1.
fn read(flight: &mut Flight, guest: GuestId, at: Time, index: u16) -> u32 {
    let [low, high] = index.to_le_bytes();
    let sub = u8::from(index == 0x1003);
    flight.fly(at);
    let answer = flight.ask(guest, MASTER, [0x40, low, high, sub, 0, 0, 0, 0]);
    u32::from_le_bytes(answer[4..].try_into().unwrap())
}

/// Given heartbeats of a second master on either bus for 500 ms, then the master reports a collision until it is
/// silent. Ttoggle consumer times are 500 ms.
#[test]
fn a_second_master_is_reported_as_collision_until_it_is_silent() {
    for bus in Bus::ALL {
        let mut flight = Flight::with(&MASTER_AND_THREE[..1], &STANDARD);
        let asking = flight.twin.add_guest(Bus::Nominal, 30.0);
        let rival = flight.twin.add_guest(bus, 31.0);
        // Between those of the master, because equal frames with the same start merge on the bus.
        for beat in 0..10 {
            flight.twin.inject(rival, ms(1_045 + 50 * beat), WireFrame::standard(0x701, &[OPERATIONAL]));
        }
        flight.fly_to(1_100);
        let told = flight.assert_said(1, "another master", ms(1_000));
        assert!(told < ms(1_047), "{} us", told.as_us());
        assert_eq!(read(&mut flight, asking, ms(1_110), 0x1001) & 0x11, 0x11, "generic, communication");
        // The first byte of the error's information is its bus.
        assert_eq!(read(&mut flight, asking, ms(1_120), 0x1003), 0x8150 | (bus as u32) << 16);
        flight.fly_to(1_985);
        assert_eq!(read(&mut flight, asking, ms(1_987), 0x1001) & 0x11, 0x11, "492 ms after the last");
        assert_eq!(read(&mut flight, asking, ms(2_025), 0x1001), 0);
        assert_eq!(flight.logs.iter().filter(|log| log.text.contains("another master")).count(), 1);

        flight.fly_to(3_000);
        let own = flight.heartbeats(MASTER, Bus::Nominal);
        assert!(own[1..].iter().all(|(_, state)| *state == OPERATIONAL));
        let ends: Vec<Time> = own.iter().map(|(at, _)| *at).collect();
        assert!(gaps(&ends[2..]).all(|gap| about(ms(100), ms(1)).contains(&gap)), "{ends:?}");
        assert!(!flight.of(MASTER).any(|seen| seen.bus == Bus::Redundant), "it has not moved");
        flight.assert_nothing_lost();
    }
}
