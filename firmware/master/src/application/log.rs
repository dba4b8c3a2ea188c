//! Log of the master's application: changes as they happen, frames at debug level only.

use ecss_can::boot::{BootCause, BootFailure, BootProgress, Difference};
use ecss_can::emcy::Emergency;
use ecss_can::link::port::{ErrorState, Health};
use ecss_can::node::{MasterEvent, Refusal};
#[cfg(feature = "standby")]
use ecss_can::redundancy::RoleChange;
#[cfg(feature = "standby")]
use ecss_can::types::Bus;
use ecss_can::types::{NodeId, Scet};
use mission::{Message, Telemetry};

pub fn event(event: &MasterEvent) {
    match event {
        MasterEvent::SlaveState { node, bus, state } => {
            defmt::info!("slave {}: {} on {}", node.get(), state, bus);
        }
        MasterEvent::SlaveLost { node } => defmt::warn!("slave {}: lost", node.get()),
        MasterEvent::SlaveUnheard { node } => defmt::warn!("slave {}: never heard on either bus", node.get()),
        MasterEvent::Stranger { node } => {
            defmt::warn!("node {} does not answer: it does not count as a slave", node.get());
        }
        MasterEvent::SecondMaster { bus } => {
            defmt::error!("another master sends 701h on {}: EMCY 8150h", bus);
        }
        MasterEvent::SyncUncaptured => {
            defmt::error!("SYNCs are not captured, check the wires: EMCY 9000h, clocks to 10 us");
        }
        MasterEvent::SecondMasterSilent { bus } => defmt::info!("no more 701h of others on {}", bus),
        MasterEvent::Clash { node } => {
            defmt::error!("two nodes have Node-ID {}: EMCY 8150h", node.get());
        }
        MasterEvent::ClashOver { node } => defmt::info!("one node has Node-ID {} again", node.get()),
        MasterEvent::OverBudget { id } => defmt::error!("sends too much: {=u16:03X}h refused", id.raw()),
        MasterEvent::Babbling { node, step } => {
            defmt::error!("slave {}: sends too much, {}", node.get(), step)
        }
        MasterEvent::SlaveReturned { node, bus } => defmt::info!("slave {}: back on {}", node.get(), bus),
        MasterEvent::Emergency { node, emergency: Emergency { code, register, info }, .. } => {
            defmt::warn!(
                "slave {}: EMCY {=u16:04X}h, error register {=u8:02X}h, {=[u8; 5]:02X}",
                node.get(),
                code.get(),
                register.bits(),
                *info
            );
        }
        MasterEvent::Boot { node, progress } => match progress {
            BootProgress::Started | BootProgress::Booted => {
                defmt::info!("slave {}: boot-up, {}", node.get(), progress);
            }
            _ => defmt::debug!("slave {}: boot-up, {}", node.get(), progress),
        },
        MasterEvent::BootFailed { node, failure } => boot_failed(*node, failure),
        MasterEvent::ConfigurationLost { node, difference: Difference { at, expected, found } } => {
            defmt::warn!(
                "slave {}: configuration lost, {=u16:04X}h sub {} is {=u32:08X}h, expected {=u32:08X}h; configured again",
                node.get(),
                at.index,
                at.sub,
                *found,
                *expected
            );
        }
        MasterEvent::BootCompleted => defmt::info!("all mandatory slaves booted and synchronised"),
        MasterEvent::Written(at) => {
            defmt::info!("object {=u16:04X}h sub {} written", at.index, at.sub);
        }
        MasterEvent::Step(step) => {
            defmt::info!("clock set: {=u32} s, was {=u32} s", step.to.coarse(), step.from.coarse());
        }
        MasterEvent::SelfTest => defmt::info!("self-test"),
        MasterEvent::BusSwitched { from, to, cause } => {
            defmt::warn!("active bus: {}, no longer {} ({})", to, from, cause);
        }
        MasterEvent::GaveUp { bus } => defmt::warn!("no slave heard in Ntoggle changes: staying on {}", bus),
        MasterEvent::State(state) => defmt::info!("{}", state),
        MasterEvent::ResetNode => defmt::info!("reset by a client"),
        MasterEvent::Refused { node } => defmt::debug!("slave {}: command not sent", node.get()),
        MasterEvent::Health { bus, health: Health { state, tec, rec, last_error } } => match state {
            ErrorState::Active => {
                defmt::info!("{}: error {}, TEC {}, REC {}, last {}", bus, state, tec, rec, last_error);
            }
            _ => defmt::warn!("{}: error {}, TEC {}, REC {}, last {}", bus, state, tec, rec, last_error),
        },
        MasterEvent::BusStalled { bus } => defmt::error!("{} neither joined nor left, trying on", bus),
        MasterEvent::BusFailed { bus } => defmt::error!("{} failed: bus-off too often", bus),
        // It is logged with the bus.
        MasterEvent::Role(_)
        | MasterEvent::Pdo { .. }
        | MasterEvent::Frame { .. }
        | MasterEvent::Synchronised { .. }
        | MasterEvent::Time(_)
        | MasterEvent::SyncSent { .. } => {}
    }
}

/// Another role of this board. `bus`: its active bus while it is active.
#[cfg(feature = "standby")]
pub fn role(RoleChange { role, cause }: RoleChange, bus: Option<Bus>) {
    match bus {
        Some(bus) => defmt::warn!("this master board: {} on {} ({})", role, bus, cause),
        None => defmt::warn!("this master board: {} ({})", role, cause),
    }
}

pub fn telemetry(node: NodeId, message: &Message) {
    match Telemetry::decode(message) {
        Some(telemetry) => defmt::debug!("slave {}: {}", node.get(), telemetry),
        None => defmt::warn!("slave {}: unknown telemetry {=u16:04X}h", node.get(), message.code()),
    }
}

/// Against the spacecraft time of the SYNC that the slave answered, once there was one.
pub fn local_time(node: NodeId, scet: Scet, reference: Option<Scet>) {
    if let Some(reference) = reference {
        defmt::debug!("slave {}: clock off by {} us", node.get(), scet.micros_since(reference));
    }
}

pub fn refused(node: NodeId, sent: Result<(), Refusal>) {
    if let Err(refusal) = sent {
        defmt::debug!("slave {}: not sent, {}", node.get(), refusal);
    }
}

fn boot_failed(node: NodeId, BootFailure { error, cause }: &BootFailure) {
    let (node, letter) = (node.get(), error.letter());
    match cause {
        BootCause::Silence => defmt::warn!("slave {}: boot-up failed, error {} ({})", node, letter, error),
        BootCause::Difference(Difference { at, expected, found }) => defmt::warn!(
            "slave {}: boot-up failed, error {} ({}): {=u16:04X}h sub {} is {=u32:08X}h, expected {=u32:08X}h",
            node,
            letter,
            error,
            at.index,
            at.sub,
            *found,
            *expected
        ),
        BootCause::CobIdInUse { at, id, other } => defmt::warn!(
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
            defmt::warn!("slave {}: boot-up failed, error {} ({}): too many COB-IDs", node, letter, error);
        }
        BootCause::Transfer { at, code } => defmt::warn!(
            "slave {}: boot-up failed, error {} ({}): {=u16:04X}h sub {}, abort code {=u32:08X}h",
            node,
            letter,
            error,
            at.index,
            at.sub,
            *code
        ),
    }
}
