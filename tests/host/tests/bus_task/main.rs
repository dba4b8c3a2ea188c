//! The policies of the runners, on a mock port whose wire is simulated by the test.

mod behind;
mod bench;
mod canopen;

use bench::*;
use can_twin::wire::controller::{Controller, ErrorCounters, ErrorKind, WireEvent};
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;
use ecss_can::link::machine::Outgoing;
use ecss_can::link::port::{CanPort, ErrorState, Filter, Health, LastError, PortEvent};
use ecss_can::node::FailCause;
use ecss_can::node::extend::{BusCommand, LinkEvent, QUEUE_DEPTH};
use ecss_can::runner::extend::WholeNode;
use ecss_can::types::{Bus, CobId, Duration, Instant};
use ecss_can_worlds::clock::MockClock;
use ecss_can_worlds::port::{MockPort, RECEIVE_DEPTH};
use futures_util::FutureExt;

#[test]
fn nothing_goes_out_before_eleven_recessive_bits() {
    let mut bench = Bench::new(0);
    bench.start();
    bench.send(0x701, 1);
    assert_eq!(bench.wire.attachment().map(|attachment| attachment.since), Some(Time::ZERO));
    bench.run_for(Time::from_ms(1));
    assert_eq!((bench.wire.request_at(), bench.begin()), (None, None));
    bench.see_eleven_recessive_bits();
    assert_eq!(bench.wire.request_at(), Some(Time::ZERO));
    assert_eq!(bench.drain(), [(0x701, 1)]);
}

#[test]
fn the_lowest_cob_id_goes_first_and_equal_ones_in_order() {
    let mut bench = Bench::joined(0);
    // The first two take the mailboxes. The others are queued and overtake by their COB-ID.
    for (raw, byte) in [(0x705, 1), (0x705, 2), (0x385, 3), (0x302, 4), (0x385, 5), (0x302, 6)] {
        bench.send(raw, byte);
    }
    let sent = bench.drain();
    assert_eq!(sent.len(), 6);
    for raw in [0x302, 0x385, 0x705] {
        let bytes: Vec<u8> = sent.iter().filter(|(id, _)| *id == raw).map(|(_, byte)| *byte).collect();
        assert!(bytes.is_sorted(), "{raw:03X} in order of the calls: {sent:?}");
    }
    // The first frame of 705h freed a mailbox. The queue sent all frames of 302h and 385h through it, lowest COB-ID
    // first.
    let overtakers: Vec<u16> = sent.iter().map(|(id, _)| *id).filter(|id| *id != 0x705).collect();
    assert_eq!(overtakers, [0x302, 0x302, 0x385, 0x385]);
    assert_eq!(bench.transmitted(), 6);
}

#[test]
fn one_mailbox_stays_free_for_urgent_frames() {
    let mut bench = Bench::joined(0);
    for byte in 0..5 {
        bench.send(0x301, byte);
    }
    // 301h is on the wire when SYNC is requested: SYNC is next, not fifth.
    bench.begin().expect("a frame waits");
    bench.send(0x080, 9);
    bench.end(WireEvent::Transmitted);
    assert_eq!(bench.drain(), [(0x080, 9), (0x301, 1), (0x301, 2), (0x301, 3), (0x301, 4)]);
}

/// Given commands that wait for a mailbox, when SYNC is requested, then it has the free one without any other event.
#[test]
fn urgent_frame_has_the_free_mailbox_at_once() {
    let mut bench = Bench::joined(0);
    for byte in 0..3 {
        bench.send(0x301, byte);
    }
    bench.send(0x080, 9);
    assert_eq!(bench.drain(), [(0x080, 9), (0x301, 0), (0x301, 1), (0x301, 2)]);
}

/// Given commands and the spacecraft time in all mailboxes, when SYNC is requested while others hold the bus, then SYNC
/// is sent first, and the frame that was removed from its mailbox is sent later in its order.
#[test]
fn urgent_frame_takes_the_mailbox_of_the_lowest_priority() {
    let mut bench = Bench::joined(0);
    for (raw, byte) in [(0x302, 0), (0x303, 1), (0x181, 2), (0x303, 3), (0x080, 4)] {
        bench.send(raw, byte);
    }
    assert_eq!(bench.drain(), [(0x080, 4), (0x181, 2), (0x302, 0), (0x303, 1), (0x303, 3)]);
    assert_eq!((bench.transmitted(), bench.failures()), (5, vec![]));
}

/// Given a frame that is to be removed from its mailbox while it is on the wire, then it completes, and is not sent
/// again.
#[test]
fn frame_on_the_wire_makes_no_room_and_is_sent_once() {
    let mut bench = Bench::joined(0);
    bench.send(0x705, 0);
    bench.begin().expect("a frame waits");
    for (raw, byte) in [(0x181, 1), (0x181, 2), (0x080, 3)] {
        bench.send(raw, byte);
    }
    bench.end(WireEvent::Transmitted);
    assert_eq!(bench.drain(), [(0x080, 3), (0x181, 1), (0x181, 2)]);
    assert_eq!((bench.transmitted(), bench.failures()), (4, vec![]));
}

/// Given frames in mailboxes and one in the queue, when their bus is abandoned, then each is reported once and none goes out.
///
/// Verifies: ECSS 8.3.3b.1
#[test]
fn frames_that_wait_die_with_their_bus() {
    let mut bench = Bench::joined(0);
    for (raw, byte) in [(0x302, 0), (0x303, 1), (0x181, 2)] {
        bench.send(raw, byte);
    }
    bench.node.request(BusCommand::Send(Outgoing { frame: frame(0x080, 3), expires: Instant::NEVER }));
    bench.command(BusCommand::Abandon);
    let mut failures = bench.failures();
    failures.sort_by_key(|(byte, _)| *byte);
    assert_eq!(failures, [0, 1, 2, 3].map(|byte| (byte, FailCause::BusLeft)));
    assert_eq!(bench.drain(), []);
}

/// Given a frame on the wire that is to be removed from its mailbox, when its bus is abandoned before the attempt
/// fails, then the frame is reported and does not return to the queue.
///
/// Verifies: ECSS 8.3.3b.1
/// Notices: ECSS 8.3.3b.1: a heartbeat that makes room for an urgent frame is sent after its bus was left.
#[test]
fn preempted_frame_on_the_wire_dies_with_its_bus() {
    let mut bench = Bench::joined(0);
    bench.send(0x701, 0);
    bench.begin().expect("a frame waits");
    // The last mailbox is kept for urgent frames.
    for (raw, byte) in [(0x302, 1), (0x181, 2), (0x080, 3)] {
        bench.send(raw, byte);
    }
    bench.command(BusCommand::Abandon);
    bench.end(WireEvent::TransmitError(ErrorKind::Ack));
    let mut failures = bench.failures();
    failures.sort_by_key(|(byte, _)| *byte);
    assert_eq!(failures, [0, 1, 2, 3].map(|byte| (byte, FailCause::BusLeft)));
    assert_eq!(bench.drain(), []);
}

/// Given frames that cannot be sent, for example because of a short, when the bus is free again after their lifetime,
/// then none is sent.
///
/// Verifies: ECSS 5.3.3.2.3g, 5.3.3.2.3d, 5.3.3.2.3h, 5.3.3.2.3j
/// Notices: ECSS 5.3.3.2.3g: a frame in a mailbox is sent late, after the short.
#[test]
fn a_frame_dies_at_the_end_of_its_lifetime_in_queue_and_mailbox() {
    let mut bench = Bench::joined(0);
    for byte in 0..4 {
        bench.send_for(0x701, byte, Duration::from_millis(5));
    }
    bench.send_for(0x702, 4, Duration::from_millis(50));
    bench.run_for(Time::from_us(4_999));
    assert_eq!(bench.failures(), []);
    bench.run_for(Time::from_us(1));
    let mut failures = bench.failures();
    failures.sort_by_key(|(byte, _)| *byte);
    assert_eq!(failures, (0..4).map(|byte| (byte, FailCause::Expired)).collect::<Vec<_>>());
    assert_eq!(bench.drain(), [(0x702, 4)]);
}

/// Verifies: ECSS 5.3.3.2.3k.2
/// Notices: ECSS 5.3.3.2.3k.2: a frame in a mailbox outlives its time and is sent when the cut is healed.
#[test]
fn frame_on_wire_at_end_of_lifetime_is_reported_as_it_ends() {
    let mut bench = Bench::joined(0);
    bench.send_for(0x701, 1, Duration::from_micros(50));
    bench.begin().expect("a frame waits");
    bench.end(WireEvent::Transmitted);
    assert_eq!((bench.failures(), bench.transmitted()), (vec![], 1));

    bench.send_for(0x701, 2, Duration::from_micros(50));
    bench.begin().expect("a frame waits");
    bench.end(WireEvent::TransmitError(ErrorKind::Ack));
    assert_eq!((bench.failures(), bench.transmitted()), (vec![(2, FailCause::Expired)], 1));
    assert_eq!(bench.drain(), []);
}

/// Verifies: ECSS 8.3.3b.1
#[test]
fn abandoned_bus_reports_all_pending_and_sends_nothing_stale() {
    let mut bench = Bench::joined(0);
    for byte in 0..6 {
        bench.send(0x701, byte);
    }
    bench.command(BusCommand::Abandon);
    let mut failures = bench.failures();
    failures.sort_by_key(|(byte, _)| *byte);
    assert_eq!(failures, (0..6).map(|byte| (byte, FailCause::BusLeft)).collect::<Vec<_>>());
    assert_eq!(bench.drain(), []);
    // The bus is still joined. Frames are sent from now on.
    bench.send(0x701, 7);
    assert_eq!(bench.drain(), [(0x701, 7)]);
}

/// Verifies: ECSS 8.3.3b.1, 8.3.3b
/// Notices: ECSS 8.3.3b: a bus that is left keeps its queue.
#[test]
fn a_left_bus_is_silent_and_clean_when_joined_again() {
    let mut bench = Bench::joined(0);
    for byte in 0..6 {
        bench.send(0x701, byte);
    }
    bench.command(BusCommand::Leave);
    assert_eq!(bench.failures().len(), 6);
    assert_eq!((bench.is_on_bus(), bench.begin()), (false, None));
    bench.command(BusCommand::Join);
    bench.see_eleven_recessive_bits();
    assert!(bench.is_on_bus());
    assert_eq!(bench.drain(), []);
}

#[test]
fn leaving_waits_for_the_frame_on_the_wire() {
    let mut bench = Bench::joined(0);
    bench.send(0x701, 1);
    bench.begin().expect("a frame waits");
    bench.command(BusCommand::Leave);
    assert!(bench.is_on_bus(), "a started frame is not torn off");
    bench.end(WireEvent::Transmitted);
    assert_eq!((bench.is_on_bus(), bench.transmitted(), bench.failures()), (false, 1, vec![]));
}

#[test]
fn a_full_transmit_queue_refuses_and_reports() {
    let mut bench = Bench::joined(0);
    let capacity = QUEUE_DEPTH as u8 + 2; // two mailboxes for frames that are not urgent
    for byte in 0..capacity + 3 {
        bench.send(0x302, byte);
    }
    let refused: Vec<_> = (capacity..capacity + 3).map(|byte| (byte, FailCause::QueueFull)).collect();
    assert_eq!(bench.failures(), refused);
    assert_eq!(bench.drain(), (0..capacity).map(|byte| (0x302, byte)).collect::<Vec<_>>());
}

#[test]
fn slow_node_holds_the_bus_back_and_losses_are_counted() {
    let mut bench = Bench::new(0);
    // While the task of the port does not run, its queue fills up.
    let mut port = bench.wire.clone();
    port.join();
    bench.see_eleven_recessive_bits();
    let kept = RECEIVE_DEPTH as u16;
    (0..kept + 7).for_each(|number| bench.receive_heartbeats(number..number + 1));
    bench.start();
    assert_eq!(bench.received(), (0..kept).collect::<Vec<_>>());
    assert_eq!(bench.lost(), 7);
    assert_eq!(bench.diagnostics().overruns().get(), 7);
    assert_eq!(bench.diagnostics().handled(Bus::Nominal).get(), u32::from(kept));
}

#[test]
fn an_event_future_that_is_dropped_loses_no_event() {
    let mut bench = Bench::new(0);
    let mut port = MockPort::new(MockClock::power_on(bench.timeline.clone(), 0));
    port.set_filters(&[Filter::function(id(0x700))]);
    assert!(port.event().now_or_never().is_none());
    bench.wire = port.clone();
    bench.receive(WireFrame::standard(0x70A, &[5]));
    // The future is polled and dropped while there is no event. The frame is returned once, later.
    let event = port.event().now_or_never();
    assert!(
        matches!(event, Some(PortEvent::Received { frame: received, .. }) if received == frame(0x70A, 5))
    );
    assert!(port.event().now_or_never().is_none());
}

/// Given a node with nothing due, when its application reads it, then no task runs.
#[test]
fn a_read_of_the_node_wakes_no_task() {
    let mut bench = Bench::joined(0);
    let polls = bench.probe.polls.get();
    bench.node.with(|_, _| ());
    bench.pool.run_until_stalled();
    assert_eq!(bench.probe.polls.get(), polls);
}

/// Given a change that makes an action due at once, then the action is done once, before the call returns.
#[test]
fn what_an_application_makes_due_is_done_in_its_step() {
    let mut bench = Bench::joined(0);
    let polls = bench.probe.polls.get();
    bench.node.with(|probe, now| probe.due.set(Some(now)));
    assert_eq!((bench.probe.polls.get(), bench.probe.due.get()), (polls + 1, None));
    bench.pool.run_until_stalled();
    assert_eq!(bench.probe.polls.get(), polls + 1);
}

/// Given a change that makes an action due in 3 ms, then the task of deadlines runs at that time.
#[test]
fn what_an_application_makes_due_later_is_done_then() {
    let mut bench = Bench::joined(0);
    let polls = bench.probe.polls.get();
    bench.node.with(|probe, now| probe.due.set(Some(now + Duration::from_millis(3))));
    bench.run_for(Time::from_us(2_999));
    assert_ne!(bench.probe.due.get(), None);
    bench.run_for(Time::from_us(2));
    assert_eq!(bench.probe.due.get(), None);
    assert!(bench.probe.polls.get() <= polls + 2, "one look at the new deadline, one when it is due");
}

#[test]
fn commands_and_receptions_at_the_same_instant_are_all_handled() {
    let mut bench = Bench::joined(0);
    for round in 0..10_u16 {
        for frame in 0..RECEIVE_DEPTH as u16 {
            bench.receive(WireFrame::standard(0x700, &(round * RECEIVE_DEPTH as u16 + frame).to_le_bytes()));
        }
        bench.send(0x302, round as u8);
        assert_eq!(bench.drain(), [(0x302, round as u8)]);
    }
    assert_eq!(bench.received(), (0..10 * RECEIVE_DEPTH as u16).collect::<Vec<_>>());
    assert_eq!((bench.transmitted(), bench.lost()), (10, 0));
}

#[test]
fn overload_of_both_directions_neither_deadlocks_nor_miscounts() {
    // Every frame received causes three to be sent on a wire that takes none.
    let mut bench = Bench::joined(3);
    let mut fed = 0_u16;
    for _ in 0..40 {
        bench.receive_heartbeats(fed..fed + 50);
        fed += 50;
    }
    // Then the wire accepts all frames.
    let drained = bench.drain().len();
    assert!(drained > QUEUE_DEPTH);
    bench.receive_heartbeats(fed..fed + 1);
    assert_eq!(bench.drain().len(), 3, "node and bus work as before");
    let handled = bench.received().len();
    assert_eq!(handled as u32 + bench.lost(), u32::from(fed) + 1, "received or counted as lost");
    assert_eq!(bench.transmitted() + bench.failures().len(), 3 * handled, "sent or reported as failed");
}

/// Given a node that answers one frame with more than its outbox holds
/// When it receives a frame
/// Then every answer goes out, is reported as failed, or is counted and reported as unsent.
#[test]
fn frames_beyond_the_outbox_are_counted_and_reported() {
    const REPLIES: u8 = 40;
    let mut bench = Bench::joined(REPLIES);
    bench.receive_heartbeats(0..1);
    let sent = bench.drain().len();
    let told = bench.probe.told.borrow();
    let unsent = told.iter().map(|event| match event {
        LinkEvent::Unsent { frames } => u32::from(*frames),
        _ => 0,
    });
    let unsent: u32 = unsent.sum();
    assert!(unsent > 0 && unsent == bench.diagnostics().app_overflows().get());
    assert_eq!(sent + bench.failures().len() + unsent as usize, usize::from(REPLIES));
}

#[test]
fn a_heartbeat_takes_the_place_of_telemetry_in_a_full_queue() {
    let mut bench = Bench::joined(0);
    // Two frames of 385h are in the mailboxes, QUEUE_DEPTH more in the queue.
    for byte in 0..QUEUE_DEPTH as u8 + 2 {
        bench.send(0x385, byte);
    }
    assert_eq!(bench.failures(), []);
    bench.send(0x385, 100);
    bench.send(0x705, 101);
    let last = QUEUE_DEPTH as u8 + 1;
    assert_eq!(bench.failures(), [(100, FailCause::QueueFull), (last, FailCause::QueueFull)]);
    let sent = bench.drain();
    assert_eq!(sent.len(), QUEUE_DEPTH + 2);
    assert!(sent.contains(&(0x705, 101)), "{sent:?}");
}

/// Given errors that no frame follows, then they are reported. Nothing else shows that the wire is cut.
///
/// Verifies: ECSS 5.6.2b
/// Verifies: ECSS 5.6.2c
#[test]
fn counters_that_move_without_an_event_are_told_too() {
    let mut bench = Bench::joined(0);
    for receive in 1..=3 {
        bench.tell(WireEvent::ReceiveError(ErrorKind::Stuff));
        bench.tell(WireEvent::Counters(ErrorCounters { transmit: 0, receive }));
    }
    bench.run_for(Time::from_ms(101));
    let moved = Health { state: ErrorState::Active, tec: 0, rec: 3, last_error: LastError::Stuff };
    assert_eq!(*bench.probe.told.borrow(), [LinkEvent::Counters(moved)]);
    bench.run_for(Time::from_ms(1000));
    assert_eq!(bench.probe.told.borrow().len(), 1, "once");
    assert_eq!(bench.wire.health(), moved, "looking changes nothing");
}

/// Given receive errors of one kind, when only the receive error counter rises or falls, then the runner reports it to the node.
///
/// Verifies: ECSS 5.6.2c
/// Notices: ECSS 5.6.2c: a change of the receive error counter alone is not reported.
#[test]
fn change_of_receive_error_counter_alone_is_reported() {
    let mut bench = Bench::joined(0);
    bench.tell(WireEvent::ReceiveError(ErrorKind::Stuff));
    for receive in [9, 10, 3] {
        bench.tell(WireEvent::Counters(ErrorCounters { transmit: 0, receive }));
        bench.run_for(Time::from_ms(101));
        let rec = receive as u8;
        let moved = Health { state: ErrorState::Active, tec: 0, rec, last_error: LastError::Stuff };
        assert_eq!(bench.probe.told.borrow().last(), Some(&LinkEvent::Counters(moved)));
    }
    assert_eq!(bench.probe.told.borrow().len(), 3);
}

/// Verifies: ECSS 5.6.2b, 5.6.2c
#[test]
fn warning_and_passive_are_reported_with_controller_counters() {
    let mut bench = Bench::joined(0);
    bench.send(0x701, 1);
    // No acknowledgement: the counter rises by 8 each time until error passive, then it stays (ISO 11898-1, 12.1.4.2
    // c).
    (1..=20).for_each(|attempt| bench.fail(ErrorKind::Ack, (8 * attempt).min(128)));
    let passive = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };
    assert_eq!(bench.wire.health(), passive);
    let warning = Health { state: ErrorState::Active, tec: 96, ..passive };
    assert_eq!(*bench.probe.told.borrow(), [LinkEvent::Health(warning), LinkEvent::Health(passive)]);
    bench.begin().expect("automatic retransmission");
    bench.end(WireEvent::Transmitted);
    bench.tell(WireEvent::Counters(ErrorCounters { transmit: 127, receive: 0 }));
    let active = Health { state: ErrorState::Active, tec: 127, rec: 0, last_error: LastError::None };
    assert!(bench.probe.told.borrow().contains(&LinkEvent::Health(active)));
    // A receiver is error passive without a frame to send.
    bench.tell(WireEvent::ReceiveError(ErrorKind::Form));
    bench.tell(WireEvent::Counters(ErrorCounters { transmit: 127, receive: 135 }));
    let receiver = Health { state: ErrorState::Passive, tec: 127, rec: 135, last_error: LastError::Form };
    assert_eq!(bench.probe.told.borrow().last(), Some(&LinkEvent::Health(receiver)));
    // Frames arrive again.
    bench.tell(WireEvent::Counters(ErrorCounters { transmit: 127, receive: 127 }));
    bench.run_for(Time::from_ms(101));
    let active = Health { state: ErrorState::Active, rec: 127, ..receiver };
    assert_eq!(bench.probe.told.borrow().last(), Some(&LinkEvent::Health(active)));
}

/// Given errors that make a sender error passive, when the wire is cut behind it, then missing acknowledgements are
/// reported to the node. A missing acknowledgement before that is only counted.
///
/// Verifies: ECSS 5.6.2b, 5.6.2c
#[test]
fn a_cut_wire_is_told_to_a_passive_sender() {
    let mut bench = Bench::joined(0);
    bench.send(0x701, 1);
    bench.fail(ErrorKind::Ack, 8);
    bench.run_for(Time::from_ms(101));
    let counted = Health { state: ErrorState::Active, tec: 8, rec: 0, last_error: LastError::Ack };
    assert_eq!(*bench.probe.told.borrow(), [LinkEvent::Counters(counted)]);
    (2..=16).for_each(|attempt| bench.fail(ErrorKind::Form, 8 * attempt));
    let passive = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Form };
    assert_eq!(bench.probe.told.borrow().last(), Some(&LinkEvent::Health(passive)));
    bench.fail(ErrorKind::Ack, 128);
    bench.run_for(Time::from_ms(2));
    let isolated = Health { last_error: LastError::Ack, ..passive };
    assert_eq!(bench.probe.told.borrow().last(), Some(&LinkEvent::Health(isolated)));
}

/// Verifies: ECSS 5.6.2a
#[test]
fn bus_off_gives_up_all_pending_and_recovers_on_command() {
    let mut bench = Bench::joined(0);
    for byte in 0..2 {
        bench.send(0x701, byte);
    }
    (1..=32).for_each(|attempt| bench.fail(ErrorKind::BitDominant, 8 * attempt));
    assert_eq!(bench.wire.health().state, ErrorState::BusOff);
    assert_eq!(bench.failures(), [(0, FailCause::Aborted), (1, FailCause::Aborted)]);
    let recovers = |bench: &Bench| bench.wire.attachment().map(|attachment| attachment.recovers);
    bench.run_for(Time::from_ms(10));
    assert_eq!(recovers(&bench), Some(false));
    bench.command(BusCommand::Recover);
    assert_eq!(recovers(&bench), Some(true));
    // The first of the 128 sequences ends.
    bench.tell(WireEvent::Joined);
    bench.send(0x701, 2);
    assert_eq!((bench.wire.request_at(), bench.begin()), (None, None));
    bench.tell(WireEvent::Counters(ErrorCounters::default()));
    assert_eq!(bench.wire.health().state, ErrorState::Active);
    assert_eq!(recovers(&bench), Some(false), "the next bus-off waits for a command again");
    assert_eq!(bench.drain(), [(0x701, 2)]);
}

#[test]
fn foreign_frames_are_filtered_and_long_dlcs_mean_eight_bytes() {
    let mut bench = Bench::joined(0);
    let ours = WireFrame::standard(0x70A, &[1, 2]);
    bench.receive(WireFrame { id: WireId::Extended(0x70A), ..ours });
    bench.receive(WireFrame { remote: true, ..ours });
    bench.receive(WireFrame::standard(0x18A, &[1, 2]));
    bench.pool.run_until_stalled();
    assert_eq!(*bench.probe.told.borrow(), []);
    bench.receive(WireFrame { dlc: 15, data: [1, 2, 3, 4, 5, 6, 7, 8], ..ours });
    bench.pool.run_until_stalled();
    let told = bench.probe.told.borrow();
    assert!(
        matches!(&told[..], [LinkEvent::Received { frame, .. }] if frame.data() == [1, 2, 3, 4, 5, 6, 7, 8])
    );
}

/// Given a node with one filter more or less than its port can have beside one for all, When another frame arrives, Then it is
/// admitted only if the filters are too few, also after the node changed the last of its own.
#[test]
fn too_few_filters_admit_every_frame() {
    for (filters, is_admitted) in [(27, false), (28, true), (32, true)] {
        let others = vec![Filter::exact(CobId::SYNC); filters - 1];
        let mut bench = Bench::with(Probe { others, ..Probe::default() });
        bench.start();
        bench.see_eleven_recessive_bits();
        for number in 27..32 {
            bench.command(BusCommand::Filter { number, filter: Filter::exact(CobId::SYNC) });
        }
        bench.receive(WireFrame::standard(0x18A, &[1, 2]));
        bench.pool.run_until_stalled();
        assert_eq!(!bench.probe.told.borrow().is_empty(), is_admitted, "{filters} filters");
    }
}

/// Given a controller with a wrong filter, as after a flip of a bit, when its bus has checked it often enough, then
/// each of its filters is that of the node.
///
/// Verifies: ECSS 6.10d
#[test]
fn wrong_filter_is_set_anew_by_the_looks_of_its_bus() {
    for wrong in 0..4 {
        let sync = Filter::exact(CobId::SYNC);
        let heartbeats = Filter::function(id(0x700));
        let mut bench = Bench::with(Probe { others: vec![sync, sync, heartbeats], ..Probe::default() });
        bench.start();
        bench.see_eleven_recessive_bits();
        for number in [0, 3] {
            bench.wire.set_filter(number, sync);
        }
        bench.receive_heartbeats(1..2);
        assert_eq!(bench.received(), [0; 0]);
        // Correct filters are not changed.
        bench.wire.set_filter(wrong, Filter::exact(id(0x18A)));
        // One step for each of four filters, and one that finds no further filter.
        bench.run_for(Time::from_ms(500));
        bench.receive_heartbeats(2..3);
        bench.receive(WireFrame::standard(0x18A, &[3, 0]));
        bench.pool.run_until_stalled();
        assert_eq!(bench.received(), [2], "filter {wrong}");
    }
}

/// Given a node with four filters, when nothing is on its bus, when it sends every 7 or 50 ms, when others do, and when a lifetime
/// ends every 20 ms, then a poll sets a filter ten times a second, and no frame adds a wake-up.
///
/// Verifies: ECSS 6.10d
#[test]
fn traffic_neither_delays_nor_hastens_the_filters() {
    let sync = Filter::exact(CobId::SYNC);
    type Act = fn(&mut Bench);
    let traffic: [(&str, u64, Act); 5] = [
        ("idle", 50, |_| {}),
        ("sends", 50, |bench| bench.send(0x181, 0)),
        ("sends much", 7, |bench| bench.send(0x181, 0)),
        ("receives", 7, |bench| bench.receive_heartbeats(0..1)),
        ("expires", 20, |bench| bench.send_for(0x181, 0, Duration::from_millis(1))),
    ];
    for (name, period, act) in traffic {
        let mut bench = Bench::with(Probe { others: vec![sync; 3], ..Probe::default() });
        bench.start();
        bench.see_eleven_recessive_bits();
        bench.wakes = 0;
        for _ in 0..4_200 / period {
            act(&mut bench);
            if name != "expires" {
                bench.drain();
            }
            let at = Time::from_ms(bench.timeline.now().as_us() / 1_000 / period * period + period);
            bench.run_for(at.since(bench.timeline.now()));
        }
        // 42 polls in rounds of five: four set a filter each, the fifth one finds none left.
        let replaced = bench.wire.replaced_filters();
        assert!(replaced.iter().all(|count| (8..=9).contains(count)), "{name}: {replaced:?}");
        let ends = if name == "expires" { 4_200 / period as usize } else { 0 };
        assert!(bench.wakes <= 43 + ends, "{name}: {} wake-ups", bench.wakes);
    }
}

/// Given a node with all filters that its port can have, then the last one, which admits every frame, is set again too.
///
/// Verifies: ECSS 6.10d
#[test]
fn filter_for_every_frame_is_set_anew() {
    let mut bench = Bench::with(Probe { others: vec![Filter::exact(CobId::SYNC); 31], ..Probe::default() });
    bench.start();
    bench.see_eleven_recessive_bits();
    bench.wire.set_filter(27, Filter::exact(CobId::SYNC));
    bench.run_for(Time::from_ms(5_000));
    bench.receive(WireFrame::standard(0x18A, &[1, 2]));
    bench.pool.run_until_stalled();
    assert_eq!(bench.received(), [0x201]);
}

/// Given a node that has one bus, then its tasks join that bus, send, and answer what they receive, as those of two do.
#[test]
fn a_node_on_one_bus_sends_and_receives() {
    let probe = Probe { replies: 1, ..Probe::default() };
    let mut bench = Bench::on_one_bus(|| probe.clone(), probe.clone());
    assert!(!bench.is_on_bus());
    bench.start();
    bench.see_eleven_recessive_bits();
    assert!(bench.is_on_bus());
    bench.send(0x701, 1);
    bench.send(0x080, 2);
    assert_eq!(bench.drain(), [(0x080, 2), (0x701, 1)]);
    bench.receive_heartbeats(7..8);
    assert_eq!(bench.received(), [7]);
    assert_eq!(bench.drain(), [(0x385, 0)]);
    assert_eq!(bench.transmitted(), 3);
}
