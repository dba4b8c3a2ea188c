//! Log messages of the master's application: changes when they happen, frames at debug level only.

use ecss_can::boot::{BootCause, BootFailure, BootProgress, Difference};
use ecss_can::emcy::Emergency;
use ecss_can::link::port::{ErrorState, Health};
use ecss_can::node::{MasterEvent, Refusal};
use ecss_can::redundancy::RoleChange;
use ecss_can::types::Bus;
use ecss_can::types::{NodeId, Scet};

use crate::{Message, Telemetry, debug, error, info, warn};

pub fn event(event: &MasterEvent) {
    match event {
        MasterEvent::SlaveState { node, bus, state } => {
            info!("slave {}: {} on {}", node.get(), state, bus);
        }
        MasterEvent::SlaveLost { node } => warn!("slave {}: lost", node.get()),
        MasterEvent::SlaveUnheard { node } => warn!("slave {}: never heard on either bus", node.get()),
        MasterEvent::UnknownNode { node } => {
            warn!("node {} does not answer: it does not count as a slave", node.get());
        }
        MasterEvent::SecondMaster { bus } => {
            error!("another master sends 701h on {}: EMCY 8150h", bus);
        }
        MasterEvent::SyncUncaptured => {
            error!("SYNCs are not captured, check the wires: EMCY 9000h, clocks to 10 us");
        }
        MasterEvent::SecondMasterSilent { bus } => info!("no more 701h of others on {}", bus),
        MasterEvent::Clash { node } => {
            error!("two nodes have Node-ID {}: EMCY 8150h", node.get());
        }
        MasterEvent::ClashOver { node } => info!("one node has Node-ID {} again", node.get()),
        MasterEvent::OverBudget { id } => error!("sends too much: {=u16:03X}h refused", id.raw()),
        MasterEvent::Babbling { node, step } => {
            error!("slave {}: sends too much, {}", node.get(), step)
        }
        MasterEvent::SlaveReturned { node, bus } => info!("slave {}: back on {}", node.get(), bus),
        MasterEvent::Emergency { node, emergency: Emergency { code, register, info }, .. } => {
            warn!(
                "slave {}: EMCY {=u16:04X}h, error register {=u8:02X}h, {=[u8; 5]:02X}",
                node.get(),
                code.get(),
                register.bits(),
                *info
            );
        }
        MasterEvent::ErrorsRead { node } => {
            warn!("slave {}: active errors are others than it reported, see 2048h", node.get());
        }
        MasterEvent::ErrorNotKept { node } => {
            error!("slave {}: no room for its error in 2048h", node.get());
        }
        MasterEvent::NotSent { bus, id, data } => {
            warn!("{=u16:03X}h not sent on {}: {=[u8; 8]:02X}", id.raw(), bus, *data);
        }
        MasterEvent::Boot { node, progress } => match progress {
            BootProgress::Started | BootProgress::Booted => {
                info!("slave {}: boot-up, {}", node.get(), progress);
            }
            _ => debug!("slave {}: boot-up, {}", node.get(), progress),
        },
        MasterEvent::BootFailed { node, failure } => boot_failed(*node, failure),
        MasterEvent::ConfigurationLost { node, difference: Difference { at, expected, found } } => {
            warn!(
                "slave {}: configuration lost, {=u16:04X}h sub {} is {=u32:08X}h, expected {=u32:08X}h; configured again",
                node.get(),
                at.index,
                at.sub,
                *found,
                *expected
            );
        }
        MasterEvent::BootCompleted => info!("all mandatory slaves booted and synchronised"),
        MasterEvent::Written(at) => {
            info!("object {=u16:04X}h sub {} written", at.index, at.sub);
        }
        MasterEvent::Step(step) => {
            info!("clock set: {=u32} s, was {=u32} s", step.to.coarse(), step.from.coarse());
        }
        MasterEvent::SelfTest => info!("self-test"),
        MasterEvent::BusSwitched { from, to, cause } => {
            warn!("active bus: {}, no longer {} ({})", to, from, cause);
        }
        MasterEvent::GaveUp { bus } => warn!("no slave heard in Ntoggle changes: staying on {}", bus),
        MasterEvent::State(state) => info!("{}", state),
        MasterEvent::ResetNode => info!("reset by a client"),
        MasterEvent::Refused { node } => debug!("slave {}: command not sent", node.get()),
        MasterEvent::Health { bus, health: Health { state, tec, rec, last_error } } => match state {
            ErrorState::Active => {
                info!("{}: error {}, TEC {}, REC {}, last {}", bus, state, tec, rec, last_error);
            }
            _ => warn!("{}: error {}, TEC {}, REC {}, last {}", bus, state, tec, rec, last_error),
        },
        MasterEvent::BusStalled { bus } => error!("{} neither joined nor left, trying on", bus),
        MasterEvent::BusFailed { bus } => error!("{} failed: bus-off too often", bus),
        // Logged with the bus.
        _ => {}
    }
}

/// Logs a change of this board's role. `bus`: active bus, if the board is active.
pub fn role(RoleChange { role, cause }: RoleChange, bus: Option<Bus>) {
    match bus {
        Some(bus) => warn!("this master board: {} on {} ({})", role, bus, cause),
        None => warn!("this master board: {} ({})", role, cause),
    }
}

pub fn telemetry(node: NodeId, message: &Message) {
    match Telemetry::decode(message) {
        Some(telemetry) => debug!("slave {}: {}", node.get(), telemetry),
        None => warn!("slave {}: unknown telemetry {=u16:04X}h", node.get(), message.code()),
    }
}

/// Logs the difference between a slave's local time and the spacecraft time of the SYNC that it answered, if there was
/// one.
pub fn local_time(node: NodeId, scet: Scet, reference: Option<Scet>) {
    if let Some(reference) = reference {
        debug!("slave {}: clock off by {} us", node.get(), scet.micros_since(reference));
    }
}

pub fn refused(node: NodeId, sent: Result<(), Refusal>) {
    if let Err(refusal) = sent {
        debug!("slave {}: not sent, {}", node.get(), refusal);
    }
}

fn boot_failed(node: NodeId, BootFailure { error, cause }: &BootFailure) {
    let (node, letter) = (node.get(), error.letter());
    match cause {
        BootCause::Silence => warn!("slave {}: boot-up failed, error {} ({})", node, letter, error),
        BootCause::Difference(Difference { at, expected, found }) => warn!(
            "slave {}: boot-up failed, error {} ({}): {=u16:04X}h sub {} is {=u32:08X}h, expected {=u32:08X}h",
            node, letter, error, at.index, at.sub, *found, *expected
        ),
        BootCause::CobIdInUse { at, id, other } => warn!(
            "slave {}: boot-up failed, error {} ({}): {=u16:04X}h sub {} is {=u16:03X}h, which node {} sends",
            node,
            letter,
            error,
            at.index,
            at.sub,
            id.raw(),
            other.get()
        ),
        BootCause::TooManyCobIds => {
            warn!("slave {}: boot-up failed, error {} ({}): too many COB-IDs", node, letter, error);
        }
        BootCause::Transfer { at, code } => warn!(
            "slave {}: boot-up failed, error {} ({}): {=u16:04X}h sub {}, abort code {=u32:08X}h",
            node, letter, error, at.index, at.sub, *code
        ),
    }
}
