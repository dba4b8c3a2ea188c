//! The task of what is due by time, and of what the application wants.

use core::convert::Infallible;
use core::future::poll_fn;
use core::pin::pin;
use core::task::{Context, Poll};

use embassy_sync::blocking_mutex::raw::RawMutex;

use super::alarm::Alarm;
use super::node_cell::{Shared, register, wake};
use super::{AppLink, NodeCell, Surroundings, TURN, Telltale};
use crate::node::Node;
use crate::time::Clock;
use crate::types::{Bus, Instant};

/// Starts a node and runs what is due, for ever.
///
/// A slow application loses events (counted in `telltale`). The node never waits for a bus: a full queue refuses frames, and
/// the node is told.
pub async fn node_task<M: RawMutex, N: Node>(
    node: &NodeCell<M, N>,
    clock: impl Clock,
    app: &AppLink<M, N::Event, N::Request>,
    telltale: &Telltale,
) -> Infallible {
    let around = Surroundings { app, telltale };
    node.lock(|shared| {
        let now = clock.now();
        shared.node.start(now, &mut shared.out);
        shared.armed = Some(now);
        Bus::ALL.into_iter().for_each(|bus| wake(&shared.buses[bus]));
    });
    let timer = pin!(None);
    let mut alarm = Alarm::new(timer);
    poll_fn(|context| {
        let now = clock.now();
        node.lock(|shared| {
            let due = turn(shared, &around, now, context);
            if register(&mut shared.timekeeper, context) {
                alarm.arm(due, context, || clock.at(due));
            } else {
                alarm.set(due, now, context, || clock.at(due));
            }
            shared.armed = Some(alarm.at());
        });
        Poll::Pending
    })
    .await
}

/// Does what the application wants and what is due; when to come again.
fn turn<M: RawMutex, N: Node>(
    shared: &mut Shared<N>,
    around: &Surroundings<'_, M, N>,
    now: Instant,
    context: &mut Context<'_>,
) -> Instant {
    let mut taken = 0;
    while taken < TURN
        && let Poll::Ready(request) = around.app.requests.poll_receive(context)
    {
        shared.node.on_request(request, now, &mut shared.out);
        shared.deliver(None, now, around);
        taken += 1;
    }
    if taken == TURN {
        context.waker().wake_by_ref();
    }
    shared.node.poll(now, &mut shared.out);
    shared.deliver(None, now, around);
    shared.node.deadline().unwrap_or(Instant::NEVER)
}
