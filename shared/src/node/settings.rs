//! Numbers of a node that its profile has.

use async_canopen::node::Settings;

use crate::profile::Profile;
use crate::types::NodeId;

/// Returns what the services of a node take from its profile.
pub fn of_profile(profile: &Profile, id: NodeId) -> Settings {
    Settings {
        heartbeats: profile.redundancy().heartbeats(),
        late_heartbeat: profile.late_heartbeat,
        sync: profile.sync,
        event: profile.event,
        sdo_timeout: profile.sdo_timeout,
        access: profile.access(id),
        bus_off: profile.bus_off,
        autostart: profile.autostart,
    }
}
