//! Check of the heartbeat times of a profile.

use super::Profile;
use crate::boot::Setting;
use crate::heartbeat::{HeartbeatConsumers, HeartbeatProducer};
use crate::od::machine::Reason;
use crate::types::{Duration, NodeId};

/// Producer heartbeat time.
const PRODUCER: u16 = HeartbeatProducer::TIME.index();
/// Consumer heartbeat time.
const CONSUMERS: u16 = <HeartbeatConsumers>::CONSUMER_HEARTBEAT.index();

impl Profile {
    /// Stops the build if the heartbeat times do not fit their objects or each other.
    #[track_caller]
    pub(super) const fn assert_heartbeats(&self) {
        assert_whole(Reason::new("`heartbeat` (1017h)"), self.heartbeat, 1);
        assert_whole(Reason::new("`consumer` (1016h)"), self.consumer, 0);
        let heartbeat = Reason::new("`heartbeat` (1017h)");
        assert_longer(Reason::new("`consumer` (1016h)"), self.consumer, heartbeat, self.heartbeat);
        let mut nth = 0;
        while nth < self.settings.len() {
            let setting = &self.settings[nth];
            if let Some(period) = period(setting) {
                let period_of = setting_of("1017h", setting.node);
                assert_longer(Reason::new("`consumer` (1016h)"), self.consumer, period_of, period);
            }
            if let Some((watched, consumer)) = watched(setting) {
                let own = setting_of("1016h", setting.node).text(" for node ").number(watched.get() as u32);
                match self.period_by_settings(watched) {
                    Some(period) => assert_longer(own, consumer, setting_of("1017h", watched), period),
                    None => assert_longer(own, consumer, heartbeat, self.heartbeat),
                }
            }
            nth += 1;
        }
    }

    /// The period that the settings give a node.
    const fn period_by_settings(&self, node: NodeId) -> Option<Duration> {
        let mut nth = 0;
        while nth < self.settings.len() {
            let setting = &self.settings[nth];
            if setting.node.get() == node.get()
                && let Some(period) = period(setting)
            {
                return Some(period);
            }
            nth += 1;
        }
        None
    }
}

/// The period that a setting gives its node, if it is one of 1017h.
const fn period(setting: &Setting) -> Option<Duration> {
    match *setting.value {
        [low, high] if setting.at.index == PRODUCER && setting.at.sub == 0 => {
            Some(Duration::from_millis(u16::from_le_bytes([low, high]) as u64))
        }
        _ => None,
    }
}

/// The node that a setting has its node watch, and the time, if it is an entry of 1016h.
const fn watched(setting: &Setting) -> Option<(NodeId, Duration)> {
    match *setting.value {
        [low, high, node, _] if setting.at.index == CONSUMERS && setting.at.sub > 0 => {
            let time = Duration::from_millis(u16::from_le_bytes([low, high]) as u64);
            match NodeId::new(node) {
                Some(node) => Some((node, time)),
                None => None,
            }
        }
        _ => None,
    }
}

const fn setting_of(object: &str, node: NodeId) -> Reason {
    Reason::new("the setting of ").text(object).text(" of node ").number(node.get() as u32)
}

/// Stops the build unless the object can hold this time. `least`: in milliseconds.
#[track_caller]
const fn assert_whole(name: Reason, time: Duration, least: u64) {
    let (us, most) = (time.as_micros(), u16::MAX as u64);
    if !us.is_multiple_of(1_000) || time.as_millis() < least || time.as_millis() > most {
        let allowed = duration(name.text(" is "), time).text(": allowed are whole milliseconds, ");
        allowed.number(least as u32).text(" to ").number(most as u32).text(" ms").refuse();
    }
}

/// Stops the build unless the consumer time is longer than the period, or one of them is off.
#[track_caller]
const fn assert_longer(name: Reason, consumer: Duration, period_name: Reason, period: Duration) {
    let is_off = consumer.as_micros() == 0 || period.as_micros() == 0;
    if !is_off && consumer.as_micros() <= period.as_micros() {
        let both = duration(name.text(" is "), consumer).text(", but ").with(period_name).text(" is ");
        let rule = ": a consumer time is longer than the period that it watches";
        duration(both, period).text(rule).refuse();
    }
}

/// Adds a time in milliseconds: `2.5 ms`.
const fn duration(reason: Reason, time: Duration) -> Reason {
    let mut reason = reason.integer(time.as_millis() as i128);
    let (mut rest, mut digit) = (time.as_micros() % 1_000, 100);
    if rest > 0 {
        reason = reason.text(".");
    }
    while rest > 0 {
        reason = reason.number((rest / digit) as u32);
        (rest, digit) = (rest % digit, digit / 10);
    }
    reason.text(" ms")
}
