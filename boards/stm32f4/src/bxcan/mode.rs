//! Mode of a controller: joins and leaves its bus, one request at a time (RM0090 32.4).
//!
//! ```text
//! Entering ── INAK ──> Silent ── join ──> Joining ── INAK = 0 ──> OnBus
//!    ^                                                              │ leave, listen: ABRQ
//!    └───────────── INRQ ────────────── Emptying <──────────────────┘
//! ```
//!
//! On a bus the controller takes part or only listens (SILM). SILM can be set in Init mode only, so a change between
//! the two passes through Init mode.
//!
//! A mailbox that transmits when it is aborted empties at the end of the transmission (RM0090 32.7.2), and that end
//! never comes in Init mode: so INRQ is set only after the mailboxes are empty. No function here blocks: a request that
//! the controller has not executed yet is polled again, without a time limit.
//!
//! Verifies: ECSS 5.6.2a

use ecss_can::types::{Duration, Instant};

/// Multiple of the time for emptying mailboxes after which a request counts as stalled: the controller is defective or its bus is dominant
/// all the time.
const STALLED: u32 = 10;

/// Flags of a controller that show its mode.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// INAK of MSR: the controller is in Init mode or not yet on the bus.
    pub init: bool,
    /// TME of TSR: no mailbox is pending.
    pub empty: bool,
}

/// A write to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    /// The settings that can be changed in Init mode only. Written again when `listens` changes.
    Configure {
        /// SILM: drives no dominant bit.
        listens: bool,
    },
    /// Set ABRQ of all mailboxes.
    Abort,
    /// Set INRQ.
    Init,
    /// Clear INRQ.
    Normal,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// INRQ was set.
    Entering,
    /// In Init mode: sends nothing, not even an acknowledgement (ECSS 6.10f).
    Silent,
    /// INRQ was cleared. The controller takes part after 11 recessive bits.
    Joining,
    OnBus,
    /// The mailboxes were aborted.
    Emptying,
}

/// Present and requested mode of one controller.
#[derive(Debug)]
pub(super) struct Mode {
    step: Step,
    since: Instant,
    /// Configured value of SILM: the controller only listens. `None` before the first configuration.
    configured: Option<bool>,
    on_bus: bool,
    listens: bool,
    stall_told: bool,
    /// Time that mailboxes may take to become empty.
    emptying: Duration,
}

impl Mode {
    /// Starts with INRQ set at `now`, for the first time. `emptying`: time that mailboxes may take to become empty.
    pub fn entering(emptying: Duration, now: Instant) -> Self {
        Mode {
            step: Step::Entering,
            since: now,
            configured: None,
            on_bus: false,
            listens: false,
            stall_told: false,
            emptying,
        }
    }

    /// Requests that the controller be on the bus or off it. `listens`: on the bus without driving a dominant bit.
    pub fn want(&mut self, on_bus: bool, listens: bool) {
        (self.on_bus, self.listens) = (on_bus, listens);
    }

    /// Returns whether frames may be put into mailboxes.
    pub fn is_wanted_to_send(&self) -> bool {
        self.on_bus && !self.listens
    }

    fn is_configured(&self) -> bool {
        self.configured == Some(self.listens)
    }

    /// Starts the recovery from bus-off, which needs INRQ set and cleared (RM0090 32.7.6). The returned request is to
    /// be written at once.
    pub fn recover(&mut self, now: Instant) -> Option<Request> {
        let recovers = self.on_bus && matches!(self.step, Step::OnBus | Step::Joining);
        recovers.then(|| self.enter(Step::Entering, Request::Init, now))
    }

    /// Returns whether INRQ is set.
    pub fn is_init(&self) -> bool {
        matches!(self.step, Step::Entering | Step::Silent)
    }

    /// Returns the configured value of SILM. `None`: the settings are not written yet.
    pub fn configured(&self) -> Option<bool> {
        self.configured
    }

    /// Notes that a setting or the mode itself was lost: the settings are written again, in Init mode. A controller on its bus
    /// leaves it and joins again. The returned request is to be written at once.
    pub fn lose(&mut self, now: Instant) -> Option<Request> {
        self.configured = None;
        self.is_init().then(|| self.enter(Step::Entering, Request::Init, now))
    }

    /// Takes what was requested from a controller in which no change is in progress. If it contradicts the state, a bit flipped.
    pub fn restore(&mut self, on_bus: bool, listens: bool) {
        if !self.is_settled() {
            self.want(on_bus, listens);
        }
    }

    /// Returns the next write. Call it after every change until it returns `None`.
    pub fn advance(&mut self, seen: Seen, now: Instant) -> Option<Request> {
        match self.step {
            Step::Entering | Step::Silent if seen.init && !self.is_configured() => {
                self.configured = Some(self.listens);
                Some(Request::Configure { listens: self.listens })
            }
            Step::Entering if seen.init => {
                self.reach(Step::Silent, now);
                self.advance(seen, now)
            }
            Step::Silent if self.on_bus => Some(self.enter(Step::Joining, Request::Normal, now)),
            Step::Joining if !seen.init => {
                self.reach(Step::OnBus, now);
                self.advance(seen, now)
            }
            Step::Joining | Step::OnBus if !self.on_bus || !self.is_configured() => {
                Some(self.enter(Step::Emptying, Request::Abort, now))
            }
            Step::Emptying if self.on_bus && self.is_configured() => {
                self.reach(Step::Joining, now);
                self.advance(seen, now)
            }
            Step::Emptying if seen.empty || now.since(self.since) >= self.emptying => {
                Some(self.enter(Step::Entering, Request::Init, now))
            }
            _ => None,
        }
    }

    /// Returns whether the controller has reached the requested mode.
    #[cfg_attr(target_os = "none", inline(never))] // row `size.pyboard-v11.slave.flash`
    pub fn is_settled(&self) -> bool {
        self.is_configured() && self.step == if self.on_bus { Step::OnBus } else { Step::Silent }
    }

    /// Returns whether the controller is in Init mode and stays there.
    pub fn is_silent(&self) -> bool {
        !self.on_bus && self.is_settled()
    }

    /// Returns, once for each request, whether the present request takes too long.
    pub fn take_stall(&mut self, now: Instant) -> bool {
        let stalled = !self.is_settled() && now.since(self.since) >= self.emptying.times(STALLED);
        stalled && !core::mem::replace(&mut self.stall_told, true)
    }

    fn enter(&mut self, step: Step, request: Request, now: Instant) -> Request {
        self.reach(step, now);
        request
    }

    fn reach(&mut self, step: Step, now: Instant) {
        (self.step, self.since, self.stall_told) = (step, now, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAST: Duration = Duration::from_millis(5);
    /// 400 bits at 10 kbit/s.
    const SLOW: Duration = Duration::from_millis(40);
    const INIT: Seen = Seen { init: true, empty: true };
    const NORMAL: Seen = Seen { init: false, empty: true };
    const SENDING: Seen = Seen { init: false, empty: false };

    const CONFIGURE: Request = Request::Configure { listens: false };
    const LISTEN: Request = Request::Configure { listens: true };

    fn ms(ms: u64) -> Instant {
        Instant::from_micros(1_000 * ms)
    }

    fn requests(mode: &mut Mode, seen: Seen, now: Instant) -> Vec<Request> {
        // More requests than any mode needs: a mode that requests without end fails a test.
        std::iter::from_fn(|| mode.advance(seen, now)).take(9).collect()
    }

    fn silent() -> Mode {
        let mut mode = Mode::entering(FAST, ms(0));
        assert_eq!(requests(&mut mode, INIT, ms(0)), [CONFIGURE]);
        mode
    }

    fn on_bus() -> Mode {
        let mut mode = silent();
        mode.want(true, false);
        assert_eq!(requests(&mut mode, INIT, ms(1)), [Request::Normal]);
        assert_eq!(requests(&mut mode, NORMAL, ms(2)), []);
        assert!(mode.is_settled());
        mode
    }

    #[test]
    fn settings_and_a_request_to_join_wait_for_init_mode() {
        let mut mode = Mode::entering(FAST, ms(0));
        assert!(!mode.is_wanted_to_send());
        mode.want(true, false);
        assert!(mode.is_wanted_to_send());
        assert_eq!(requests(&mut mode, NORMAL, ms(1)), []);
        assert_eq!(requests(&mut mode, INIT, ms(2)), [CONFIGURE, Request::Normal]);
        assert!(!mode.is_settled(), "INAK falls after 11 recessive bits");
        assert_eq!(requests(&mut mode, NORMAL, ms(3)), []);
        assert!(mode.is_settled());
    }

    /// Given a controller on its bus, when a setting is lost, then it leaves the bus by Init mode, is configured and joins again.
    #[test]
    fn lost_setting_is_written_again_in_init_mode() {
        let mut mode = on_bus();
        assert_eq!(mode.lose(ms(3)), None);
        assert_eq!(requests(&mut mode, SENDING, ms(3)), [Request::Abort]);
        assert_eq!(requests(&mut mode, NORMAL, ms(4)), [Request::Init]);
        assert_eq!(requests(&mut mode, INIT, ms(5)), [CONFIGURE, Request::Normal]);
        assert_eq!(requests(&mut mode, NORMAL, ms(6)), []);
        assert!(mode.is_settled() && !mode.is_init());
    }

    /// Given a controller in Init mode, when INRQ is lost, so that it joins its bus, then INRQ is set again, and the controller is
    /// silent.
    #[test]
    fn silent_controller_that_lost_inrq_becomes_silent_again() {
        let mut mode = silent();
        assert_eq!(mode.lose(ms(1)), Some(Request::Init));
        assert_eq!(requests(&mut mode, NORMAL, ms(1)), []);
        assert_eq!(requests(&mut mode, INIT, ms(2)), [CONFIGURE]);
        assert!(mode.is_silent());
    }

    /// Given a controller that enters Init mode for the first time, when INRQ is lost, then it is set again.
    #[test]
    fn inrq_that_is_lost_while_entering_is_set_again() {
        let mut mode = Mode::entering(FAST, ms(0));
        assert_eq!(mode.configured(), None);
        assert_eq!(mode.lose(ms(1)), Some(Request::Init));
        assert_eq!(requests(&mut mode, INIT, ms(2)), [CONFIGURE]);
        assert_eq!((mode.configured(), mode.is_silent()), (Some(false), true));
    }

    /// Given a controller on its bus, off it or listening, when a bit of the request flips, then it is requested as before.
    #[test]
    fn flipped_request_is_taken_from_the_controller() {
        type Flip = fn(&mut Mode);
        let flips: [Flip; 2] = [|mode| mode.on_bus = !mode.on_bus, |mode| mode.listens = !mode.listens];
        for (flip, (on_bus, listens)) in flips
            .iter()
            .flat_map(|flip| [(false, false), (true, false), (true, true)].map(|mode| (flip, mode)))
        {
            let mut mode = silent();
            mode.want(on_bus, listens);
            requests(&mut mode, INIT, ms(1));
            requests(&mut mode, NORMAL, ms(2));
            assert!(mode.is_settled());
            flip(&mut mode);
            mode.restore(on_bus, listens);
            assert_eq!((mode.on_bus, mode.listens, mode.is_settled()), (on_bus, listens, true));
        }
    }

    /// Given a controller on its bus, when its INRQ flips, then its mode stays as it was.
    #[test]
    fn settled_mode_is_not_taken_from_the_controller() {
        let mut mode = on_bus();
        mode.restore(false, false);
        assert!(mode.is_wanted_to_send() && mode.is_settled());
    }

    /// Verifies: ECSS 8.2.1a.1
    #[test]
    fn a_bus_is_left_when_the_mailboxes_are_empty() {
        let mut mode = on_bus();
        mode.want(false, false);
        assert_eq!(requests(&mut mode, SENDING, ms(10)), [Request::Abort]);
        assert_eq!(requests(&mut mode, SENDING, ms(11)), []);
        assert_eq!(requests(&mut mode, NORMAL, ms(12)), [Request::Init]);
        assert!(!mode.is_silent(), "it may be in a frame of others");
        assert_eq!(requests(&mut mode, INIT, ms(13)), []);
        assert!(mode.is_settled() && mode.is_silent());
    }

    /// Verifies: ECSS 8.2.1a.1
    #[test]
    fn a_mailbox_that_does_not_empty_keeps_nobody_on_the_bus() {
        let mut mode = on_bus();
        mode.want(false, false);
        assert_eq!(requests(&mut mode, SENDING, ms(10)), [Request::Abort]);
        assert_eq!(requests(&mut mode, SENDING, ms(15)), [Request::Init]);
    }

    /// A frame of 8 bytes takes up to 13.5 ms there, the error frame after it 2.3 ms.
    #[test]
    fn a_slow_bus_has_time_to_empty_a_mailbox() {
        let mut mode = Mode::entering(SLOW, ms(0));
        mode.want(true, false);
        assert_eq!(requests(&mut mode, INIT, ms(0)), [CONFIGURE, Request::Normal]);
        assert_eq!(requests(&mut mode, NORMAL, ms(2)), []);
        mode.want(false, false);
        assert_eq!(requests(&mut mode, SENDING, ms(10)), [Request::Abort]);
        assert_eq!(requests(&mut mode, SENDING, ms(10 + 16)), []);
        assert_eq!(requests(&mut mode, SENDING, ms(10 + 40)), [Request::Init]);
    }

    #[test]
    fn a_bus_joined_again_before_it_was_left_is_not_left() {
        let mut mode = on_bus();
        mode.want(false, false);
        assert_eq!(requests(&mut mode, SENDING, ms(10)), [Request::Abort]);
        mode.want(true, false);
        assert_eq!(requests(&mut mode, SENDING, ms(11)), []);
        assert!(mode.is_settled());
    }

    #[test]
    fn bus_joined_again_while_being_left_is_joined_from_init_mode() {
        let mut mode = on_bus();
        mode.want(false, false);
        assert_eq!(requests(&mut mode, NORMAL, ms(10)), [Request::Abort, Request::Init]);
        mode.want(true, false);
        assert_eq!(requests(&mut mode, NORMAL, ms(10)), []);
        assert_eq!(requests(&mut mode, INIT, ms(11)), [Request::Normal]);
    }

    #[test]
    fn recovery_waits_for_init_mode_and_reports_a_long_wait_once() {
        let mut mode = on_bus();
        assert_eq!(mode.recover(ms(10)), Some(Request::Init));
        assert_eq!(mode.recover(ms(11)), None, "under way");
        assert_eq!((requests(&mut mode, NORMAL, ms(59)), mode.take_stall(ms(59))), (vec![], false));
        assert!(mode.take_stall(ms(60)));
        assert!(!mode.take_stall(ms(61)));
        assert_eq!(requests(&mut mode, INIT, ms(500)), [Request::Normal]);
        assert_eq!(requests(&mut mode, NORMAL, ms(501)), []);
        assert!(mode.is_settled());
    }

    /// Verifies: ECSS 8.2.1a.1
    /// Notices: ECSS 8.2.1a.1: a recovery from bus-off joins a bus that was left.
    #[test]
    fn a_bus_that_was_left_is_not_recovered() {
        let mut mode = silent();
        assert_eq!(mode.recover(ms(10)), None);
        assert!(!mode.take_stall(ms(1_000)));
    }

    /// Given a controller without a request to join, when INAK is set for an hour, is cleared and set again, then it is
    /// configured and stays in Init mode.
    ///
    /// Verifies: ECSS 6.10f
    /// Notices: ECSS 6.10f: a controller that was in Init mode for two seconds joins its bus by itself.
    #[test]
    fn who_was_not_told_to_join_never_requests_normal_mode() {
        for (listens, configure) in [(false, CONFIGURE), (true, LISTEN)] {
            let mut mode = Mode::entering(FAST, ms(0));
            mode.want(false, listens);
            let mut written = vec![];
            for at in 0..3_600 {
                written.extend(requests(&mut mode, INIT, ms(1_000 * at)));
                assert!(mode.is_silent());
            }
            assert_eq!(mode.recover(ms(3_600_000)), None);
            for seen in [NORMAL, SENDING, INIT] {
                written.extend(requests(&mut mode, seen, ms(3_600_001)));
            }
            assert_eq!(written, [configure]);
            assert!(!mode.is_wanted_to_send());
        }
    }

    #[test]
    fn a_bus_that_is_dominant_all_the_time_stalls_who_joins_it() {
        let mut mode = silent();
        mode.want(true, false);
        assert_eq!(requests(&mut mode, INIT, ms(10)), [Request::Normal]);
        assert!(mode.take_stall(ms(60)));
    }

    #[test]
    fn listening_controller_is_configured_in_init_and_does_not_send() {
        let mut mode = silent();
        mode.want(true, true);
        assert!(!mode.is_wanted_to_send() && !mode.is_settled());
        assert_eq!(requests(&mut mode, INIT, ms(1)), [LISTEN, Request::Normal]);
        assert_eq!(requests(&mut mode, NORMAL, ms(2)), []);
        assert!(mode.is_settled());
    }

    #[test]
    fn change_from_listening_to_sending_and_back_passes_init_mode() {
        let mut mode = on_bus();
        mode.want(true, true);
        assert_eq!(requests(&mut mode, SENDING, ms(10)), [Request::Abort]);
        assert_eq!(requests(&mut mode, NORMAL, ms(11)), [Request::Init]);
        assert_eq!(requests(&mut mode, INIT, ms(12)), [LISTEN, Request::Normal]);
        assert_eq!(requests(&mut mode, NORMAL, ms(13)), []);
        mode.want(true, false);
        assert!(mode.is_wanted_to_send() && !mode.is_settled());
        assert_eq!(requests(&mut mode, NORMAL, ms(20)), [Request::Abort, Request::Init]);
        assert_eq!(requests(&mut mode, INIT, ms(21)), [CONFIGURE, Request::Normal]);
        assert_eq!(requests(&mut mode, NORMAL, ms(22)), []);
        assert!(mode.is_settled());
    }

    #[test]
    fn who_is_to_send_again_before_its_bus_was_left_stays_there() {
        let mut mode = on_bus();
        mode.want(true, true);
        assert_eq!(requests(&mut mode, SENDING, ms(10)), [Request::Abort]);
        mode.want(true, false);
        assert_eq!(requests(&mut mode, SENDING, ms(11)), []);
        assert!(mode.is_settled());
    }
}
