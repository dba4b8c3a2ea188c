//! Isolated is who hears nothing and gets no acknowledgement; whoever was just acknowledged is not.

use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::board::{BoardConfig, Fittings, FlashTiming};
use twin::guest::Presence;
use twin::spacecraft::{Bus, GuestId};

use crate::craft::*;

/// Attempts of the master on the nominal bus that came to nothing since the cut.
fn failed(craft: &Craft) -> usize {
    craft.attempts(1, Bus::Nominal).filter(|at| *at > CUT).count()
}

const CUT: Time = Time::from_ms(1_000);

/// The guest acknowledges one frame of the master. Returns its end.
fn acknowledge_one(craft: &mut Craft, guest: GuestId) -> Time {
    craft.twin.set_presence(guest, Presence::Present);
    let seen = craft.fly_until(|seen| seen.bus == Bus::Nominal && seen.sender == 0);
    craft.twin.set_presence(guest, Presence::Listening);
    seen.end
}

fn fly_to_failed(craft: &mut Craft, attempts: usize) {
    while failed(craft) < attempts {
        let next = craft.end + Time::from_us(10);
        craft.fly(next);
    }
}

/// With ideal memory: the flight meets a window of some 100 us, which wait states move.
fn ideal(seat: Seat) -> BoardConfig {
    let fittings = Fittings { flash_timing: FlashTiming::Ideal, ..Fittings::default() };
    BoardConfig { fittings, ..seat.with(&STANDARD) }
}

/// Cut off with a guest that acknowledges two frames: one early, so that the error counter of the master is above 128
/// after more attempts, and one shortly before the 2 ms end in which it must hear from another node. The other bus is
/// full of frames, and keeps the master from looking at its error state at once. It stays for 2 ms more.
#[test]
fn a_master_that_was_just_acknowledged_is_not_isolated() {
    for after_us in (1_300..1_950).step_by(50) {
        let mut craft = Craft::of(&MASTER_AND_THREE[..2], ideal);
        let guest = craft.twin.add_guest(Bus::Nominal, 0.2);
        let busy = craft.twin.add_guest(Bus::Redundant, 30.0);
        craft.twin.set_presence(guest, Presence::Listening);
        craft.fly(CUT);
        craft.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
        fly_to_failed(&mut craft, 4);
        acknowledge_one(&mut craft, guest);
        // 4 x 8 - 1 + 13 x 8 = 135.
        fly_to_failed(&mut craft, 17);
        let passive = craft.end;
        for _ in 0..60 {
            craft.twin.inject(busy, passive, WireFrame::standard(0x385, &[0xAA; 8]));
        }
        craft.fly(passive + Time::from_us(after_us));
        let last = acknowledge_one(&mut craft, guest);
        let next = last + ms(6);
        craft.fly(next);
        let isolated = craft.said(1, "Isolated", CUT).unwrap();
        assert!(
            isolated > last + ms(2) || last > passive + ms(2),
            "{after_us} us: {} us after an acknowledgement\n{}",
            isolated.since(last).as_us(),
            craft.log(1)
        );
    }
}
