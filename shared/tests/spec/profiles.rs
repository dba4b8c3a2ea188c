//! The numbers of a profile and the objects they stand in.

use crate::instrument::Instrument;
use crate::instrument::STANDARD;
use ecss_can::link::bit_timing::{BitRate, BitTiming, Hertz, Limits, Metres, Network, Range};
use ecss_can::link::budget::{BudgetPolicy, Rate};
use ecss_can::node::Slave;
use ecss_can::od::checked::find;
use ecss_can::profile::Profile;
use ecss_can::redundancy::{Pair, Parameters};
use ecss_can::types::{Address, CobId, Duration};

use crate::bench::{node, span};

/// Verifies: ECSS 8.3.1a, 6.5.2b, 8.3.3c
/// Notices: ECSS 6.5.2b: 1016h of a slave does not name the master.
#[test]
fn a_slave_holds_the_objects_of_table_8_1() {
    let mut objects = Slave::builder(node(5), &STANDARD, Instrument::default()).build().into_objects();
    objects.extension.redundancy.parameters = (&Parameters { ctoggle: 3, ..STANDARD.redundancy() }).into();
    let values: [(u16, u8, &[u8]); 8] = [
        (0x1016, 0, &[8]),
        (0x1016, 1, &[0xFA, 0, 1, 0]),
        (0x1017, 0, &[100, 0]),
        (0x2000, 0, &[4]),
        (0x2000, 1, &[0]),
        (0x2000, 2, &[2]),
        (0x2000, 3, &[50]),
        (0x2000, 4, &[3]),
    ];
    for (index, sub, value) in values {
        let mut found = find(&mut objects, Address::new(index, sub)).expect("it is there");
        let mut read = [0; 8];
        let len = found.read(0, &mut read);
        assert_eq!(&read[..len], value, "{index:04X} sub {sub}");
    }
    assert!(find(&mut objects, Address::new(0x2000, 5)).is_err());
}

/// Given the rate of the profile that images use, at each rate of the standard and at the slower ones that images have in addition, then
/// bxCAN at 42 MHz meets it: prescaler, TS1, TS2 and SJW. The line of 40 m and its transceivers fit, as do oscillators of 0.1 %.
///
/// Verifies: ECSS 5.4.2a, 5.4.2a.1, 5.4.2a.2, 5.4.2a.3, 5.4.2b
/// Notices: ECSS 5.4.2a: the recommended sample point counts as the earliest one: 250 and 500 kbit/s have no timing.
/// Notices: ECSS 5.4.2a.1: below 800 kbit/s the sample point begins at 87.5 %, which no option has.
/// Notices: ECSS 5.4.2a.3: a clock that is no multiple of the rate is taken, and the rate is too high.
/// Notices: ECSS 5.4.2a.2: the sample point at 250 kbit/s may not be before 87 %.
#[test]
fn profile_of_images_has_a_timing_for_each_rate_they_offer() {
    const CLOCK: u32 = 42_000_000;
    /// RM0090 32.9.2.
    const BXCAN: Limits = Limits {
        prescaler: Range::new(1, 1024),
        segment1: Range::new(1, 16),
        segment2: Range::new(1, 8),
        jump_width: 4,
    };
    for (bit_rate, expected) in [
        (BitRate::MBIT_1, [3, 11, 2, 1]),
        (BitRate::KBIT_500, [6, 11, 2, 1]),
        (BitRate::KBIT_250, [12, 11, 2, 1]),
        (BitRate::KBIT_125, [21, 13, 2, 1]),
        (BitRate::KBIT_50, [56, 12, 2, 1]),
        (BitRate::KBIT_20, [140, 12, 2, 1]),
        (BitRate::KBIT_10, [280, 12, 2, 1]),
    ] {
        let network = STANDARD.at(bit_rate).network;
        assert_eq!((network.bit_rate, network.length), (bit_rate, Metres(40)));
        let timing = BitTiming::new(&BXCAN, Hertz(CLOCK), &network).unwrap();
        let [ts1, ts2, sjw] = [timing.segment1(), timing.segment2(), timing.jump_width()].map(u16::from);
        assert_eq!([timing.prescaler(), ts1, ts2, sjw], expected, "{} bit/s", bit_rate.get());
        let quanta = u32::from(1 + ts1 + ts2) * u32::from(timing.prescaler());
        assert_eq!(quanta * bit_rate.get(), CLOCK);
    }
}

#[test]
fn the_settling_time_covers_a_search_and_two_heartbeats() {
    assert_eq!(STANDARD.redundancy().settling_time(), span(2 * 250 + 2 * 100));
}

/// Given two master boards, when one number does not fit the others, then the profile is not sound: the standby would take
/// over while the active master changes the bus, or after the slaves changed the bus, or both boards would be active.
///
/// Verifies: ECSS 8.1a, 6.10l, 6.10b
/// Notices: ECSS 6.10l: the claims of two master boards may have one COB-ID.
/// Notices: ECSS 6.10b: a master board may claim by the COB-ID of its heartbeat.
#[test]
fn each_number_of_two_master_boards_has_its_limits() {
    let is_sound = |pair| Profile { standby: Some(pair), ..STANDARD }.is_standby_sound();
    let pair = Profile::PAIR;
    assert!(is_sound(pair));
    assert!(Profile { standby: None, ..STANDARD }.is_standby_sound());
    for (consumer, expected) in [(349, false), (350, true), (499, true), (500, false)] {
        assert_eq!(is_sound(Pair { consumer: span(consumer), ..pair }), expected, "consumer {consumer} ms");
    }
    for (prime_listens, expected) in [(599, false), (600, true), (800, true), (801, false)] {
        assert_eq!(is_sound(Pair { prime_listens: span(prime_listens), ..pair }), expected);
    }
    for (prime_claims, expected) in [(0x680, true), (0x681, false), (0x701, false), (0x6DF, true)] {
        let prime_claims = CobId::new(prime_claims).unwrap();
        assert_eq!(is_sound(Pair { prime_claims, ..pair }), expected, "{prime_claims:?}");
        assert!(!is_sound(Pair { second_claims: pair.prime_claims, ..pair }));
    }
    let never_toggles = Profile { standby: Some(pair), ttoggle: 0, ..STANDARD };
    assert!(never_toggles.is_standby_sound());
}

/// Verifies: ECSS 5.3.3.1b
#[test]
fn a_budget_admits_twice_what_the_periods_make() {
    assert!(STANDARD.is_budget_sound());
    let is_sound = |period| {
        let heartbeat = Profile { heartbeat: period, ..STANDARD }.is_budget_sound();
        let sync = Profile { sync: period, ..STANDARD }.is_budget_sound();
        let time = Profile { time: period, ..STANDARD }.is_budget_sound();
        [heartbeat, sync, time]
    };
    assert_eq!(is_sound(Duration::from_micros(2_000)), [true; 3]);
    assert_eq!(is_sound(Duration::from_micros(1_999)), [false; 3]);
    let cob_id = STANDARD.budget.cob_id;
    let less = Rate::new(128, 999);
    for budget in
        [BudgetPolicy { slave: less, ..STANDARD.budget }, BudgetPolicy { master: less, ..STANDARD.budget }]
    {
        assert!(!Profile { budget, ..STANDARD }.is_budget_sound());
    }
    assert!(
        !Profile { budget: BudgetPolicy { heard: Rate::new(255, 3_000), ..STANDARD.budget }, ..STANDARD }
            .is_budget_sound()
    );
    let same = BudgetPolicy { slave: cob_id, master: cob_id, ..STANDARD.budget };
    assert!(Profile { budget: same, ..STANDARD }.is_budget_sound());
}

/// On paper: 350 bits are 35 ms at 10 kbit/s, 2.8 ms at 125 kbit/s and 350 us at 1 Mbit/s; four recoveries of 128 x 11 bits are
/// 563.2 ms, 45.056 ms and 5.632 ms.
///
/// Verifies: ECSS 5.4.2a, 5.4.2a.2, 5.4.2a.3
/// Notices: ECSS 5.4.2a: frames of a slow bus have the time of those at 1 Mbit/s.
/// Notices: ECSS 5.4.2a.2: at 250 kbit/s late heartbeats are as late as at 1 Mbit/s.
/// Notices: ECSS 5.4.2a.3: at 125 kbit/s a master is isolated before a frame is acknowledged.
#[test]
fn a_slow_bus_has_more_time_for_its_frames_and_recoveries() {
    let us = Duration::from_micros;
    let profile = Profile { grace: us(2_000), ..STANDARD };
    assert_eq!(profile.bus_off.patience, us(50_000));
    for (bits_per_second, grace, patience, late) in [
        (10_000, 35_000, 563_200, 54_000),
        (125_000, 2_800, 50_000, 4_320),
        (250_000, 2_000, 50_000, 2_160),
        (1_000_000, 2_000, 50_000, 540),
    ] {
        let bit_rate = BitRate::new(bits_per_second).unwrap();
        let at = profile.at(bit_rate);
        assert_eq!(at.network, Network { bit_rate, ..profile.network });
        assert_eq!((at.grace, at.bus_off.patience), (us(grace), us(patience)), "{bits_per_second} bit/s");
        assert_eq!(at.late_heartbeat, us(late), "{bits_per_second} bit/s: four frames of 135 bits");
        assert_eq!((at.heartbeat, at.sync), (profile.heartbeat, profile.sync), "periods stay");
    }
}
