//! Filters of all four forms, and the numbers of their matches.

use bxcan::filter::{ListEntry16, ListEntry32, Mask16, Mask32};
use bxcan::{ExtendedId, Fifo, Frame, StandardId};

use super::Scenario;
use super::rig::{Outcome, Rig, standard};
use crate::check;

pub const SCENARIOS: &[Scenario] = &[
    ("mask32_standard", mask32_standard),
    ("mask32_extended", mask32_extended),
    ("mask16", mask16),
    ("list32_standard", list32_standard),
    ("list32_extended", list32_extended),
    ("list16", list16),
    ("frame_kinds", frame_kinds),
    ("match_numbers", match_numbers),
    ("match_priority", match_priority),
];

fn extended(id: u32) -> ExtendedId {
    ExtendedId::new(id).unwrap()
}

fn mask32_standard(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let exactly = Mask32::frames_with_std_id(standard(42), StandardId::MAX);
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, exactly);
    check!(rig.admits(&Frame::new_data(standard(42), []))?);
    check!(rig.admits(&Frame::new_data(standard(42), [1, 2, 3, 4, 5, 6, 7, 8]))?);
    for length in [0, 7, 8] {
        check!(rig.admits(&Frame::new_remote(standard(42), length))?);
    }
    check!(!rig.admits(&Frame::new_data(standard(1000), []))?);
    // Extended identifiers of the same value, or with the same upper bits.
    check!(!rig.admits(&Frame::new_data(extended(42), []))?);
    check!(!rig.admits(&Frame::new_data(extended(42 << 18), []))?);
    Ok(())
}

fn mask32_extended(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let exactly = Mask32::frames_with_ext_id(ExtendedId::ZERO, ExtendedId::MAX);
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, exactly);
    check!(rig.admits(&Frame::new_data(extended(0), [1, 2, 3, 4, 5, 6, 7, 8]))?);
    check!(rig.admits(&Frame::new_remote(extended(0), 7))?);
    check!(!rig.admits(&Frame::new_data(extended(1000), []))?);
    check!(!rig.admits(&Frame::new_data(standard(0), []))?);
    check!(!rig.admits(&Frame::new_data(StandardId::MAX, []))?);
    // Half of the bits are not compared.
    let upper = Mask32::frames_with_ext_id(extended(0x1234_0000), extended(0x1FFF_0000));
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, upper);
    check!(rig.admits(&Frame::new_data(extended(0x1234_FFFF), []))?);
    check!(!rig.admits(&Frame::new_data(extended(0x1235_0000), []))?);
    Ok(())
}

fn mask16(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let exactly = |id| Mask16::frames_with_std_id(standard(id), StandardId::MAX);
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, [exactly(16), exactly(17)]);
    for (id, admitted) in [(15, false), (16, true), (17, true), (18, false)] {
        check!(rig.admits(&Frame::new_data(standard(id), []))? == admitted);
        check!(rig.admits(&Frame::new_remote(standard(id), 3))? == admitted);
    }
    for id in [16, 17, 16 << 18, 17 << 18] {
        check!(!rig.admits(&Frame::new_data(extended(id), []))?);
    }
    Ok(())
}

fn list32_standard(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let entries =
        [ListEntry32::data_frames_with_id(StandardId::MAX), ListEntry32::remote_frames_with_id(standard(42))];
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, entries);
    check!(rig.admits(&Frame::new_data(StandardId::MAX, []))?);
    check!(rig.admits(&Frame::new_remote(standard(42), 8))?);
    check!(!rig.admits(&Frame::new_remote(StandardId::MAX, 8))?);
    check!(!rig.admits(&Frame::new_data(standard(42), []))?);
    check!(!rig.admits(&Frame::new_data(extended(0x7FF), []))?);
    check!(!rig.admits(&Frame::new_remote(extended(42), 8))?);
    Ok(())
}

fn list32_extended(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let entries =
        [ListEntry32::data_frames_with_id(ExtendedId::MAX), ListEntry32::remote_frames_with_id(extended(42))];
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, entries);
    check!(rig.admits(&Frame::new_data(ExtendedId::MAX, []))?);
    check!(rig.admits(&Frame::new_remote(extended(42), 8))?);
    check!(!rig.admits(&Frame::new_remote(ExtendedId::MAX, 8))?);
    check!(!rig.admits(&Frame::new_data(extended(42), []))?);
    check!(!rig.admits(&Frame::new_remote(extended(41), 1))?);
    check!(!rig.admits(&Frame::new_remote(extended(43), 1))?);
    check!(!rig.admits(&Frame::new_remote(standard(42), 1))?);
    Ok(())
}

fn list16(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let entries = [
        ListEntry16::data_frames_with_id(standard(1)),
        ListEntry16::remote_frames_with_id(standard(2)),
        ListEntry16::data_frames_with_id(standard(0x400)),
        ListEntry16::data_frames_with_id(StandardId::MAX),
    ];
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, entries);
    for id in [1, 0x400, 0x7FF] {
        check!(rig.admits(&Frame::new_data(standard(id), [id as u8]))?);
        check!(!rig.admits(&Frame::new_remote(standard(id), 1))?);
    }
    check!(rig.admits(&Frame::new_remote(standard(2), 1))?);
    check!(!rig.admits(&Frame::new_data(standard(2), []))?);
    check!(!rig.admits(&Frame::new_data(standard(3), []))?);
    check!(!rig.admits(&Frame::new_data(extended(1 << 18), []))?);
    Ok(())
}

/// Masks for data frames or remote frames alone.
fn frame_kinds(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let mut data = Mask32::frames_with_std_id(standard(1), StandardId::MAX);
    data.data_frames_only();
    let mut remote = Mask16::frames_with_std_id(standard(2), StandardId::MAX);
    remote.remote_frames_only();
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, data).enable_bank(
        1,
        Fifo::Fifo0,
        [remote, remote],
    );
    check!(rig.admits(&Frame::new_data(standard(1), []))?);
    check!(!rig.admits(&Frame::new_remote(standard(1), 0))?);
    check!(rig.admits(&Frame::new_remote(standard(2), 0))?);
    check!(!rig.admits(&Frame::new_data(standard(2), []))?);
    Ok(())
}

/// FIFO and filter match index (FMI of RDTR) of a frame that CAN1 sends to itself.
fn matched(rig: &mut Rig, frame: &Frame) -> Result<(usize, u8), &'static str> {
    rig.send(frame)?;
    let can = stm32_metapac::CAN1;
    let fifo = (0..2).find(|&fifo| can.rfr(fifo).read().fmp() > 0).ok_or("no filter admits the frame")?;
    let number = can.rx(fifo).rdtr().read().fmi();
    check!(rig.can1.receive().is_ok_and(|received| received == *frame));
    Ok((fifo, number))
}

/// Filters are numbered per FIFO over all banks of the controller, including inactive ones (RM0090 figure 342).
fn match_numbers(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let list32 = |a, b| [a, b].map(|id| ListEntry32::data_frames_with_id(standard(id)));
    let list16 = |ids: [u16; 4]| ids.map(|id| ListEntry16::data_frames_with_id(standard(id)));
    let mask16 = |a, b| [a, b].map(|id| Mask16::frames_with_std_id(standard(id), StandardId::MAX));
    let mask32 = |id| Mask32::frames_with_std_id(standard(id), StandardId::MAX);
    rig.can1
        .modify_filters()
        .clear()
        .enable_bank(0, Fifo::Fifo0, list32(0x10, 0x11))
        .enable_bank(1, Fifo::Fifo0, mask32(0x12))
        .enable_bank(2, Fifo::Fifo1, list16([0x20, 0x21, 0x22, 0x23]))
        .enable_bank(3, Fifo::Fifo0, mask16(0x13, 0x14))
        .enable_bank(4, Fifo::Fifo0, list16([0x30, 0x31, 0x32, 0x33]))
        .disable_bank(4)
        .enable_bank(5, Fifo::Fifo1, mask32(0x24))
        .enable_bank(6, Fifo::Fifo0, list32(0x15, 0x16))
        .enable_bank(7, Fifo::Fifo1, mask16(0x25, 0x26));
    for (id, place) in [
        (0x10, (0, 0)),
        (0x11, (0, 1)),
        (0x12, (0, 2)),
        (0x20, (1, 0)),
        (0x23, (1, 3)),
        (0x13, (0, 3)),
        (0x14, (0, 4)),
        (0x24, (1, 4)),
        // Four numbers of the bank that is off lie between.
        (0x15, (0, 9)),
        (0x16, (0, 10)),
        (0x25, (1, 5)),
        (0x26, (1, 6)),
    ] {
        check!(matched(rig, &Frame::new_data(standard(id), []))? == place);
    }
    check!(!rig.admits(&Frame::new_data(standard(0x30), []))?);
    Ok(())
}

/// Given filters of every form for one frame, 32 bits go before 16, a list before a mask, then the lower number.
fn match_priority(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let id = standard(0x155);
    rig.can1
        .modify_filters()
        .clear()
        .enable_bank(0, Fifo::Fifo1, [Mask16::frames_with_std_id(id, StandardId::MAX); 2])
        .enable_bank(1, Fifo::Fifo1, [ListEntry16::data_frames_with_id(id); 4])
        .enable_bank(2, Fifo::Fifo0, Mask32::frames_with_std_id(id, StandardId::MAX))
        .enable_bank(3, Fifo::Fifo0, [ListEntry32::data_frames_with_id(id); 2]);
    for (off, place) in [(3, (0, 1)), (2, (0, 0)), (1, (1, 2)), (0, (1, 0))] {
        check!(matched(rig, &Frame::new_data(id, []))? == place);
        rig.can1.modify_filters().disable_bank(off);
    }
    check!(!rig.admits(&Frame::new_data(id, []))?);
    Ok(())
}
