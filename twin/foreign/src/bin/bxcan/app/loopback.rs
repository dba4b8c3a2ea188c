//! One controller in loopback: mailboxes, FIFOs and their interrupts.

use bxcan::filter::{ListEntry32, Mask32};
use bxcan::{ExtendedId, Fifo, Frame, Id, Interrupt, Mailbox};
use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::pac::Interrupt as Irq;

use super::Scenario;
use super::rig::{Outcome, Rig, eventually, standard};
use crate::check;

pub const SCENARIOS: &[Scenario] = &[
    ("loopback", loopback),
    ("no_filter_no_frame", no_filter_no_frame),
    ("priority", priority),
    ("fourth_frame_replaces_the_lowest", fourth_frame_replaces_the_lowest),
    ("equal_frames_keep_their_order", equal_frames_keep_their_order),
    ("abort", abort),
    ("transmit_interrupt", transmit_interrupt),
    ("pending_interrupt", pending_interrupt),
    ("fifo_full", fifo_full),
    ("fifo_overrun", fifo_overrun),
    ("second_fifo", second_fifo),
    ("sleep_interrupt", sleep_interrupt),
];

fn loopback(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    for frame in [
        Frame::new_data(standard(0), []),
        Frame::new_data(standard(0x7FF), [1, 2, 3, 4, 5, 6, 7, 8]),
        Frame::new_data(ExtendedId::new(0xFFFF).unwrap(), [1, 2, 3, 4, 5]),
        Frame::new_data(ExtendedId::MAX, [0xFF]),
        Frame::new_remote(standard(0x123), 0),
        Frame::new_remote(ExtendedId::ZERO, 8),
    ] {
        check!(rig.admits(&frame)?);
    }
    Ok(())
}

fn no_filter_no_frame(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.can1.modify_filters().clear();
    check!(!rig.admits(&Frame::new_data(ExtendedId::ZERO, []))?);
    check!(!rig.admits(&Frame::new_data(standard(0), []))?);
    Ok(())
}

/// Given three frames in the mailboxes, the lowest identifier leaves first.
fn priority(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    rig.slow_self_test();
    for id in [0x300, 0x200, 0x100] {
        let status = nb::block!(rig.can1.transmit(&Frame::new_data(standard(id), [])));
        check!(status.is_ok_and(|status| status.dequeued_frame().is_none()));
    }
    let mut order = [0; 3];
    for id in &mut order {
        let received = nb::block!(rig.can1.receive()).map_err(|_| "an overrun")?;
        if let Id::Standard(standard) = received.id() {
            *id = standard.as_raw();
        }
    }
    check!(order == [0x100, 0x200, 0x300]);
    Ok(())
}

/// Given full mailboxes, a more urgent frame replaces the least urgent one, which is returned.
fn fourth_frame_replaces_the_lowest(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    rig.slow_self_test();
    let frame = |id| Frame::new_data(ExtendedId::new(id).unwrap(), [id as u8; 3]);
    for id in [3, 2, 1] {
        let status = rig.can1.transmit(&frame(id)).map_err(|_| "no mailbox")?;
        check!(status.dequeued_frame().is_none());
    }
    let status = rig.can1.transmit(&frame(0)).map_err(|_| "no mailbox")?;
    check!(status.dequeued_frame() == Some(&frame(3)));
    // A frame that is less urgent than all is not accepted.
    check!(matches!(rig.can1.transmit(&frame(4)), Err(nb::Error::WouldBlock)));
    Ok(())
}

fn equal_frames_keep_their_order(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    for number in 0..20 {
        check!(nb::block!(rig.can1.transmit(&Frame::new_data(standard(7), [number]))).is_ok());
        let received = nb::block!(rig.can1.receive()).map_err(|_| "an overrun")?;
        check!(received.data().is_some_and(|data| data[..] == [number]));
    }
    Ok(())
}

fn abort(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    check!(!rig.can1.abort(Mailbox::Mailbox0));
    rig.slow_self_test();
    let sent = |rig: &mut Rig, id| {
        let status = rig.can1.transmit(&Frame::new_data(standard(id), []));
        status.map(|status| status.mailbox()).map_err(|_| "no mailbox")
    };
    let (first, second) = (sent(rig, 0x222)?, sent(rig, 0x111)?);
    check!(rig.can1.abort(first));
    check!(!rig.can1.abort(first));
    // During its transmission it can no longer be stopped.
    cortex_m::asm::delay(168 * 1_000);
    check!(!rig.can1.abort(second));
    check!(rig.can1.receive().is_ok_and(|frame| frame.id() == Id::Standard(standard(0x111))));
    check!(matches!(rig.can1.receive(), Err(nb::Error::WouldBlock)));
    Ok(())
}

fn transmit_interrupt(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    rig.can1.enable_interrupt(Interrupt::TransmitMailboxEmpty);
    check!(!NVIC::is_pending(Irq::CAN1_TX));
    rig.send(&Frame::new_data(standard(0), []))?;
    check!(NVIC::is_pending(Irq::CAN1_TX));
    check!(rig.can1.clear_request_completed_flag() == Some(Mailbox::Mailbox0));
    check!(rig.can1.clear_request_completed_flag().is_none());
    NVIC::unpend(Irq::CAN1_TX);
    check!(!NVIC::is_pending(Irq::CAN1_TX));
    Ok(())
}

fn pending_interrupt(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    rig.can1.enable_interrupt(Interrupt::Fifo0MessagePending);
    check!(!NVIC::is_pending(Irq::CAN1_RX0));
    rig.send(&Frame::new_data(standard(0), []))?;
    check!(NVIC::is_pending(Irq::CAN1_RX0));
    check!(rig.can1.receive().is_ok());
    NVIC::unpend(Irq::CAN1_RX0);
    check!(!NVIC::is_pending(Irq::CAN1_RX0));
    Ok(())
}

fn fifo_full(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    rig.can1.enable_interrupt(Interrupt::Fifo0Full);
    for _ in 0..2 {
        rig.send(&Frame::new_data(standard(0), []))?;
    }
    check!(!NVIC::is_pending(Irq::CAN1_RX0));
    rig.send(&Frame::new_data(standard(0), []))?;
    check!(NVIC::is_pending(Irq::CAN1_RX0));
    for _ in 0..3 {
        check!(rig.can1.receive().is_ok());
    }
    check!(matches!(rig.can1.receive(), Err(nb::Error::WouldBlock)));
    Ok(())
}

/// Given a full FIFO, the next frame replaces the newest, and the loss is reported once.
fn fifo_overrun(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    rig.can1.enable_interrupt(Interrupt::Fifo0Overrun);
    for number in 0..3 {
        rig.send(&Frame::new_data(standard(0), [number]))?;
    }
    check!(!NVIC::is_pending(Irq::CAN1_RX0));
    rig.send(&Frame::new_data(standard(0), [3]))?;
    check!(NVIC::is_pending(Irq::CAN1_RX0));
    check!(matches!(rig.can1.receive(), Err(nb::Error::Other(_))));
    for number in [0, 1, 3] {
        let received = rig.can1.receive().map_err(|_| "a frame too few")?;
        check!(received.data().is_some_and(|data| data[..] == [number]));
    }
    check!(matches!(rig.can1.receive(), Err(nb::Error::WouldBlock)));
    Ok(())
}

fn second_fifo(rig: &mut Rig) -> Outcome {
    rig.self_test();
    let one = [ListEntry32::data_frames_with_id(standard(1)); 2];
    rig.can1.modify_filters().clear().enable_bank(0, Fifo::Fifo0, one).enable_bank(
        1,
        Fifo::Fifo1,
        Mask32::frames_with_std_id(standard(2), standard(0x7FF)),
    );
    rig.can1.enable_interrupt(Interrupt::Fifo1MessagePending);
    rig.send(&Frame::new_data(standard(1), []))?;
    check!(!NVIC::is_pending(Irq::CAN1_RX1));
    rig.send(&Frame::new_data(standard(2), []))?;
    check!(NVIC::is_pending(Irq::CAN1_RX1));
    check!(rig.can1.rx1().receive().is_ok_and(|frame| frame.id() == Id::Standard(standard(2))));
    check!(rig.can1.rx0().receive().is_ok_and(|frame| frame.id() == Id::Standard(standard(1))));
    Ok(())
}

fn sleep_interrupt(rig: &mut Rig) -> Outcome {
    rig.self_test();
    rig.admit_all();
    rig.can1.enable_interrupt(Interrupt::Sleep);
    check!(!NVIC::is_pending(Irq::CAN1_SCE));
    rig.can1.sleep();
    check!(NVIC::is_pending(Irq::CAN1_SCE));
    rig.can1.clear_sleep_interrupt();
    NVIC::unpend(Irq::CAN1_SCE);
    check!(!NVIC::is_pending(Irq::CAN1_SCE));
    // A frame requested meanwhile is sent after the wake-up.
    check!(rig.can1.transmit(&Frame::new_data(standard(5), [])).is_ok());
    check!(!eventually(|| rig.can1.is_transmitter_idle()));
    rig.can1.wakeup();
    check!(eventually(|| rig.can1.is_transmitter_idle()));
    check!(rig.can1.receive().is_ok());
    Ok(())
}
