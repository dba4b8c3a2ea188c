//! The task of one node: events in, outbox out.

use core::future::{pending, poll_fn};

use embassy_futures::select::{Either5, select5};
use embassy_sync::blocking_mutex::raw::RawMutex;

use super::{AppLink, Links, NodeCell, Telltale};
use crate::node::{LinkEvent, Node, Outbox};
use crate::time::Clock;
use crate::types::Bus;

/// Runs a node for ever.
///
/// A slow application loses events (counted in `telltale`). The node never waits for a bus: commands a bus cannot take
/// yet stay in the outbox while events go on being handled, so bus and node cannot wait for each other.
pub async fn node_task<M: RawMutex, N: Node>(
    node: &NodeCell<M, N>,
    clock: impl Clock,
    links: &Links<M>,
    app: &AppLink<M, N::Event, N::Request>,
    telltale: &Telltale,
) -> ! {
    let mut out = Outbox::new();
    node.step(|node| node.start(clock.now(), &mut out));
    let mut deadline = Some(clock.now());
    loop {
        deliver(&mut out, links, app, telltale);
        let blocked = out.next_bus();
        let timer = async {
            match deadline {
                Some(at) => clock.at(at).await,
                None => pending().await,
            }
        };
        let room = async {
            match blocked {
                Some(bus) => poll_fn(|cx| links.commands[bus].poll_ready_to_send(cx)).await,
                None => pending().await,
            }
        };
        let (requests, touched) = (app.requests.receive(), node.touched());
        let happened = select5(links.events.receive(), timer, requests, touched, room).await;
        deadline = node.step(|node| {
            let now = clock.now();
            match happened {
                Either5::First((bus, event)) => {
                    node.on_link(bus, &event, now, &mut out);
                    match event {
                        LinkEvent::Received { .. } => telltale.handled(bus).count(),
                        LinkEvent::Overrun { lost } => telltale.overruns().add(u32::from(lost)),
                        _ => {}
                    }
                }
                Either5::Second(()) | Either5::Fourth(()) => node.poll(now, &mut out),
                Either5::Third(request) => node.on_request(request, now, &mut out),
                Either5::Fifth(()) => {}
            }
            for bus in Bus::ALL {
                let frames = out.take_unsent(bus);
                if frames > 0 {
                    node.on_link(bus, &LinkEvent::Unsent { frames }, now, &mut out);
                }
            }
            node.deadline()
        });
    }
}

/// Hands over what the channels take; commands they do not take stay, in order.
fn deliver<M: RawMutex, E, R>(
    out: &mut Outbox<E>,
    links: &Links<M>,
    app: &AppLink<M, E, R>,
    telltale: &Telltale,
) {
    telltale.app_overflows().add(out.take_overflows());
    while let Some(event) = out.pop_event() {
        if app.events.try_send(event).is_err() {
            telltale.app_overflows().count();
        }
    }
    while let Some(bus) = out.next_bus() {
        if links.commands[bus].is_full() {
            return;
        }
        if let Some((bus, command)) = out.pop_command() {
            // Only this task sends, so there is still room.
            if links.commands[bus].try_send(command).is_err() {
                telltale.app_overflows().count();
            }
        }
    }
}
