//! Two controllers on one bus.

use bxcan::filter::{ListEntry32, Mask32};
use bxcan::{Fifo, Frame, Id, Interrupt, StandardId};
use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::pac::Interrupt as Irq;

use super::Scenario;
use super::rig::{MEGABIT, Outcome, Rig, eventually, standard};
use crate::check;

pub const SCENARIOS: &[Scenario] = &[
    ("both_ways", both_ways),
    ("split_of_the_filters", split_of_the_filters),
    ("filters_of_the_slave", filters_of_the_slave),
    ("silent", silent),
    ("single_shot", single_shot),
    ("wake_up_by_traffic", wake_up_by_traffic),
    ("wake_up_by_software", wake_up_by_software),
];

fn both_ways(rig: &mut Rig) -> Outcome {
    rig.both_on_the_bus();
    let (there, back) = (Frame::new_data(standard(0x111), [1, 2]), Frame::new_data(standard(0x222), [3]));
    rig.send(&there)?;
    check!(rig.can2.receive().is_ok_and(|frame| frame == there));
    check!(rig.can2.transmit(&back).is_ok());
    check!(eventually(|| rig.can1.receive().is_ok_and(|frame| frame == back)));
    // A sender does not receive its own frame.
    check!(matches!(rig.can2.receive(), Err(nb::Error::WouldBlock)));
    Ok(())
}

fn split_of_the_filters(rig: &mut Rig) -> Outcome {
    let mut filters = rig.can1.modify_filters();
    for split in [0, 1, 14, 27, 28] {
        filters.set_split(split);
        check!(filters.num_banks() == split);
        check!(filters.slave_filters().num_banks() == 28 - split);
    }
    filters.set_split(14);
    Ok(())
}

/// CAN2 receives by its own banks only, for any split of the banks.
fn filters_of_the_slave(rig: &mut Rig) -> Outcome {
    rig.both_on_the_bus();
    for split in [1, 9, 27] {
        let mut filters = rig.can1.modify_filters();
        filters.set_split(28).clear();
        filters.set_split(split).enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
        let list = [0x10, 0x11].map(|id| ListEntry32::data_frames_with_id(standard(id)));
        filters.slave_filters().enable_bank(split, Fifo::Fifo1, list);
        drop(filters);
        rig.send(&Frame::new_data(standard(0x0F), []))?;
        check!(matches!(rig.can2.receive(), Err(nb::Error::WouldBlock)));
        for (id, number) in [(0x10, 0), (0x11, 1)] {
            rig.send(&Frame::new_data(standard(id), []))?;
            // The numbers of the slave begin at its own first bank.
            check!(stm32_metapac::CAN2.rx(1).rdtr().read().fmi() == number);
            check!(rig.can2.rx1().receive().is_ok_and(|frame| frame.id() == Id::Standard(standard(id))));
        }
    }
    Ok(())
}

/// A silent controller does not acknowledge, so the other one continues to send. It receives the frame as soon as the
/// sender is error passive and its error flags are recessive.
fn silent(rig: &mut Rig) -> Outcome {
    rig.both_on_the_bus();
    rig.can2.modify_config().set_silent(true).enable();
    let frame = Frame::new_data(standard(0x123), [9]);
    check!(rig.can1.transmit(&frame).is_ok());
    // Some attempts; the sender is error passive after 16.
    cortex_m::asm::delay(168 * 150);
    check!(matches!(rig.can2.receive(), Err(nb::Error::WouldBlock)));
    check!(eventually(|| rig.can2.receive().is_ok_and(|received| received == frame)));
    check!(!rig.can1.is_transmitter_idle());
    rig.can2.modify_config().set_silent(false).enable();
    check!(eventually(|| rig.can1.is_transmitter_idle()));
    Ok(())
}

/// Without automatic retransmission the mailbox is empty after one attempt, acknowledged or not.
fn single_shot(rig: &mut Rig) -> Outcome {
    rig.both_on_the_bus();
    rig.can2.sleep();
    rig.can1.modify_config().set_automatic_retransmit(false).enable();
    rig.send(&Frame::new_data(standard(0x123), []))?;
    rig.can2.wakeup();
    check!(matches!(rig.can2.receive(), Err(nb::Error::WouldBlock)));
    rig.can1.modify_config().set_automatic_retransmit(true).enable();
    rig.send(&Frame::new_data(standard(0x124), []))?;
    check!(rig.can2.receive().is_ok_and(|frame| frame.id() == Id::Standard(standard(0x124))));
    Ok(())
}

/// Given automatic wake-up, the frame that wakes the controller is sent again until it is received.
fn wake_up_by_traffic(rig: &mut Rig) -> Outcome {
    rig.both_on_the_bus();
    rig.can1.enable_interrupt(Interrupt::Wakeup);
    rig.can1.set_automatic_wakeup(true);
    rig.can1.sleep();
    check!(!NVIC::is_pending(Irq::CAN1_SCE));
    let frame = Frame::new_data(StandardId::ZERO, []);
    check!(rig.can2.transmit(&frame).is_ok());
    check!(eventually(|| rig.can2.is_transmitter_idle()));
    check!(NVIC::is_pending(Irq::CAN1_SCE));
    check!(rig.can1.receive().is_ok_and(|received| received == frame));
    rig.can1.clear_wakeup_interrupt();
    rig.can1.set_automatic_wakeup(false);
    Ok(())
}

/// Without automatic wake-up the interrupt is raised, and the program wakes the controller.
fn wake_up_by_software(rig: &mut Rig) -> Outcome {
    rig.both_on_the_bus();
    rig.can1.enable_interrupt(Interrupt::Wakeup);
    rig.can1.sleep();
    check!(rig.can2.transmit(&Frame::new_data(standard(1), [])).is_ok());
    check!(eventually(|| NVIC::is_pending(Irq::CAN1_SCE)));
    check!(!eventually(|| rig.can2.is_transmitter_idle()));
    rig.can1.clear_wakeup_interrupt();
    rig.can1.wakeup();
    check!(eventually(|| rig.can2.is_transmitter_idle()));
    check!(rig.can1.receive().is_ok());
    rig.can1.modify_config().set_bit_timing(MEGABIT).enable();
    Ok(())
}
