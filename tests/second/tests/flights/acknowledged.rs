//! A master is isolated when it hears nothing and gets no acknowledgement. One that was just acknowledged is not.

use can_twin::board::{BoardConfig, Fittings, FlashTiming};
use can_twin::guest::Presence;
use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

/// COB-IDs of the master's frames: a telemetry request, SYNC, the emergency of an error passive controller.
const REQUEST_2: u16 = 0x402;
const SYNC: u16 = 0x080;
const EMERGENCY: u16 = 0x081;

/// Lets the guest acknowledge the frames of the master until frame `id` completes. Returns its end.
fn acknowledge(flight: &mut Flight, guest: GuestId, id: u16) -> Time {
    flight.twin.set_presence(guest, Presence::Present);
    let seen = flight.fly_until(|seen| seen.bus == Bus::Nominal && seen.sender == 0 && seen.id() == Some(id));
    flight.twin.set_presence(guest, Presence::Listening);
    seen.end
}

/// Returns a configuration with ideal memory. The flight needs a window of some 100 us, which wait states would shift.
fn ideal(setup: BoardSetup) -> BoardConfig {
    let fittings = Fittings { flash_timing: FlashTiming::Ideal, ..Fittings::default() };
    BoardConfig { fittings, ..setup.with(&STANDARD) }
}

/// Given a master that is cut off and error passive, when a guest acknowledges its SYNC and, 1.3 to 1.7 ms later,
/// its emergency, then it leaves 2 ms after the emergency at the earliest.
///
/// Heartbeats on the other bus keep it busy: it reads the error register after the next attempt has failed, so that only
/// the result of the mailbox shows that there is another node.
#[test]
fn a_master_that_was_just_acknowledged_is_not_isolated() {
    for after_us in (1_250..=1_550).step_by(50) {
        let mut flight = Flight::of(&MASTER_AND_THREE[..3], ideal);
        let guest = flight.twin.add_guest(Bus::Nominal, 0.2);
        let busy = flight.twin.add_guest(Bus::Redundant, 30.0);
        flight.twin.set_presence(guest, Presence::Listening);
        flight.fly_to(1_000);
        // SYNC, emergency, spacecraft time and heartbeat follow, in this order by their COB-IDs.
        let cut = flight.fly_until(|seen| seen.id() == Some(REQUEST_2)).end;
        flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
        while flight.attempts(1, Bus::Nominal).filter(|at| *at > cut).count() < 17 {
            flight.fly(flight.end + Time::from_us(10));
        }
        let first = acknowledge(&mut flight, guest, SYNC);
        for n in 0..80 {
            let state = if n / 10 % 2 == 0 { OPERATIONAL } else { PRE_OPERATIONAL };
            let heartbeat = WireFrame::standard(0x705 + n % 10, &[state]);
            flight.twin.inject(busy, first + Time::from_us(1_150), heartbeat);
        }
        flight.fly(first + Time::from_us(after_us));
        let last = acknowledge(&mut flight, guest, EMERGENCY);
        flight.fly(last + ms(10));
        let isolated = flight.assert_said(1, "Isolated", cut);
        let active = flight.said(1, "error Active", first);
        assert!(active.is_none_or(|at| at > isolated), "error passive all the time\n{}", flight.log(1));
        let apart = last.since(first);
        assert!(apart < Time::from_us(1_700), "the flight is another one: {} us", apart.as_us());
        assert!(isolated > last + ms(2), "isolated {} us after the emergency", isolated.since(last).as_us());
    }
}
