//! The client against the server.
//!
//! Verifies: ECSS 6.1a

use async_canopen::sdo::Error;
use async_canopen::sdo::Mode;
use async_canopen::types::AbortCode;
use proptest::prelude::*;

use super::channel::{Application, Fate, World};
use super::fixture::{CONST, DOMAIN, EMPTY, TEXT, TIMEOUT, U8, U32, WRITE_ONLY, pattern};
use crate::random::cases;

const PROMPT: Application = Application { chunk: 1_000, every: 1 };

const BAD: [Fate; 3] = [Fate::Lost, Fate::Twice, Fate::Late];

fn mode() -> impl Strategy<Value = Mode> {
    prop_oneof![Just(Mode::Auto), Just(Mode::Segmented), Just(Mode::Block)]
}

fn application() -> impl Strategy<Value = Application> {
    (1..1_000_usize, 1..60_usize).prop_map(|(chunk, every)| Application { chunk, every })
}

/// Fates of frames: mostly good.
fn fates(bad: &'static [Fate]) -> impl Strategy<Value = Vec<Fate>> {
    let rate = prop_oneof![Just(200), Just(40), Just(8)];
    rate.prop_flat_map(move |rate| {
        let fate = (0..rate, prop::sample::select(bad));
        prop::collection::vec(fate.prop_map(|(die, bad)| if die == 0 { bad } else { Fate::Passes }), 0..1_500)
    })
}

/// Verifies: ECSS 11.1a, 11.1b
/// Notices: ECSS 11.1b: unused bytes of the last segment of a block download are kept.
/// Notices: ECSS 11.1a: a segmented upload of a multiple of seven bytes has a segment too many.
#[test]
fn every_mode_moves_every_size() {
    for mode in [Mode::Auto, Mode::Segmented, Mode::Block] {
        for size in (0..80).chain([881, 882, 883, 888, 889, 890, 896, 1_778, 3_000, 5_000]) {
            let value = pattern(size);
            let mut world = World::new(vec![], vec![]);
            assert_eq!(world.download(DOMAIN, &value, mode, PROMPT), Ok(size), "{mode:?} {size}");
            assert_eq!(world.objects.changes, [(DOMAIN, value.clone())]);
            assert_eq!(world.upload(DOMAIN, 5_000, mode, PROMPT), Ok(value), "{mode:?} {size}");
            world.settle();
        }
    }
}

#[test]
fn a_transfer_takes_no_more_frames_than_it_must() {
    let frames = |size: usize, mode| {
        let mut world = World::new(vec![], vec![]);
        world.download(DOMAIN, &pattern(size), mode, PROMPT).unwrap();
        let down = world.frames;
        world.upload(DOMAIN, 5_000, mode, PROMPT).unwrap();
        world.settle();
        (down, world.frames - down)
    };
    assert_eq!(frames(4, Mode::Auto), (2, 2));
    assert_eq!(frames(28, Mode::Auto), (2 + 2 * 4, 2 + 2 * 4));
    // Initiate and its answer, five segments, acknowledgement, end and its answer; the start of an upload.
    assert_eq!(frames(29, Mode::Auto), (2 + 5 + 1 + 2, 3 + 5 + 1 + 2));
    assert_eq!(frames(889 * 2 + 1, Mode::Block), (2 + 255 + 3 + 2, 3 + 255 + 3 + 2));
    assert_eq!(frames(29, Mode::Segmented), (2 + 2 * 5, 2 + 2 * 5));
}

#[test]
fn refusals_reach_the_application() {
    let mut world = World::new(vec![], vec![]);
    for mode in [Mode::Auto, Mode::Segmented, Mode::Block] {
        let abort = |code| Err(Error::Abort(code));
        assert_eq!(world.download(CONST, &[0; 4], mode, PROMPT), abort(AbortCode::ReadOnly));
        assert_eq!(world.upload(WRITE_ONLY, 4, mode, PROMPT), Err(Error::Abort(AbortCode::WriteOnly)));
        assert_eq!(world.download(U8, &[0; 2], mode, PROMPT), abort(AbortCode::TooLong));
        assert_eq!(world.download(DOMAIN, &pattern(5_001), mode, PROMPT), abort(AbortCode::TooLong));
        assert_eq!(world.upload(TEXT, 15, mode, PROMPT), Err(Error::TooLarge));
        assert_eq!(world.upload(U32, 3, mode, PROMPT), Err(Error::TooLarge));
        assert_eq!(world.upload(EMPTY, 0, mode, PROMPT), Ok(vec![]));
        world.settle();
    }
    assert!(world.objects.changes.is_empty());
}

#[test]
fn no_segment_of_a_block_transfer_is_missed() {
    let value = pattern(300);
    for lost in 0..43 {
        let mut fates = vec![Fate::Passes; 50];
        // After the initiate frame.
        fates[lost + 1] = Fate::Lost;
        let mut world = World::new(fates.clone(), vec![]);
        assert_eq!(world.download(DOMAIN, &value, Mode::Block, PROMPT), Ok(300), "{lost}");
        assert_eq!(world.objects.changes, [(DOMAIN, value.clone())]);
        let mut world = World::new(vec![], fates);
        world.objects.set(DOMAIN, &value);
        assert_eq!(world.upload(DOMAIN, 300, Mode::Block, PROMPT), Ok(value.clone()), "{lost}");
    }
}

/// Errors in the last bit of a frame: any frame of a block transfer may come twice.
#[test]
fn no_frame_of_a_block_transfer_counts_twice() {
    let value = pattern(1_800);
    for twice in 0..265 {
        let mut fates = vec![Fate::Passes; 265];
        fates[twice] = Fate::Twice;
        for (requests, responses) in [(fates.clone(), vec![]), (vec![], fates)] {
            let mut world = World::new(requests.clone(), responses.clone());
            assert_eq!(world.download(DOMAIN, &value, Mode::Block, PROMPT), Ok(1_800), "{twice}");
            assert_eq!(world.objects.changes, [(DOMAIN, value.clone())]);
            let mut world = World::new(requests, responses);
            world.objects.set(DOMAIN, &value);
            assert_eq!(world.upload(DOMAIN, 1_800, Mode::Block, PROMPT), Ok(value.clone()), "{twice}");
        }
    }
}

proptest! {
    #![proptest_config(cases(120))]

    #[test]
    fn without_faults_everything_arrives(
        size in 0..3_000_usize, mode in mode(), application in application()
    ) {
        let value = pattern(size);
        let mut world = World::new(vec![], vec![]);
        prop_assert_eq!(world.download(DOMAIN, &value, mode, application), Ok(size));
        prop_assert_eq!(&world.objects.changes, &[(DOMAIN, value.clone())]);
        prop_assert_eq!(world.upload(DOMAIN, size, mode, application), Ok(value));
        world.settle();
    }

    /// What arrives is right or nothing; nobody is stuck; the next transfer goes well.
    #[test]
    fn on_a_bus_that_loses_and_repeats_nothing_wrong_arrives(
        size in 0..3_000_usize, mode in mode(), application in application(),
        requests in fates(&BAD[..2]), responses in fates(&BAD[..2]), up in any::<bool>()
    ) {
        transfer(size, mode, application, World::new(requests, responses), up)?;
    }

    /// As above, with a checksum against frames out of order.
    #[test]
    fn in_blocks_nothing_wrong_arrives_out_of_order(
        size in 0..3_000_usize, application in application(),
        requests in fates(&BAD), responses in fates(&BAD), up in any::<bool>()
    ) {
        transfer(size, Mode::Block, application, World::new(requests, responses), up)?;
    }

    /// A bus that only loses segments now and then costs time, not the transfer.
    #[test]
    fn sub_blocks_are_repeated_until_all_has_arrived(
        size in 100..3_000_usize, up in any::<bool>(), application in application(),
        lost in prop::collection::vec(any::<prop::sample::Index>(), 1..10)
    ) {
        let value = pattern(size);
        // After the initiate frame.
        let mut fates = vec![Fate::Passes; size / 7];
        lost.iter().for_each(|at| *at.get_mut(&mut fates) = Fate::Lost);
        fates.insert(0, Fate::Passes);
        let (requests, responses) = if up { (vec![], fates) } else { (fates, vec![]) };
        let mut world = World::new(requests, responses);
        if up {
            world.objects.set(DOMAIN, &value);
            prop_assert_eq!(world.upload(DOMAIN, size, Mode::Block, application), Ok(value));
        } else {
            prop_assert_eq!(world.download(DOMAIN, &value, Mode::Block, application), Ok(size));
            prop_assert_eq!(&world.objects.changes, &[(DOMAIN, value)]);
        }
    }
}

fn transfer(
    size: usize,
    mode: Mode,
    application: Application,
    mut world: World,
    up: bool,
) -> Result<(), TestCaseError> {
    let value = pattern(size);
    let begin = world.now;
    if up {
        world.objects.set(DOMAIN, &value);
        if let Ok(read) = world.upload(DOMAIN, size, mode, application) {
            prop_assert!(read == value, "a wrong value was read");
        }
    } else {
        let outcome = world.download(DOMAIN, &value, mode, application);
        prop_assert!(outcome.is_err() || !world.objects.changes.is_empty(), "written, it was said");
    }
    let right = world.objects.changes.iter().all(|change| *change == (DOMAIN, value.clone()));
    prop_assert!(right, "a wrong value was written");
    world.repair();
    world.settle();
    prop_assert!(!world.objects.is_open());
    prop_assert!(world.now.since(begin) < TIMEOUT.times(600), "it took {:?}", world.now.since(begin));
    world.now += TIMEOUT;
    prop_assert_eq!(world.download(DOMAIN, &value, mode, PROMPT), Ok(size));
    prop_assert_eq!(world.upload(DOMAIN, size, mode, PROMPT), Ok(value));
    Ok(())
}
