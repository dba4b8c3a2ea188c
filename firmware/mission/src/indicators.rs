//! Indicators of a board: its LEDs and its reset, as the applications of the mission use them.

/// Shows what an application does. A board has LEDs; a test records the calls.
pub trait Indicators {
    /// A SYNC was sent (master) or heard (slave).
    fn sync(&mut self);

    /// A heartbeat of the master was heard.
    fn heartbeat(&mut self);

    /// A spacecraft time was heard.
    fn time(&mut self);

    /// Slave: the command LED. Master: lit while the redundant bus is the active one.
    fn state(&mut self, on: bool);

    /// Resets the chip. On a board it does not return.
    fn reset(&mut self);
}

#[cfg(all(target_os = "none", feature = "leds"))]
impl Indicators for ecss_can_stm32f4::Leds {
    #[inline] // row `size.pyboard-v11.slave.flash`: the five save 8 bytes
    fn sync(&mut self) {
        self.sync.toggle();
    }

    #[inline]
    fn heartbeat(&mut self) {
        self.heartbeat.toggle();
    }

    #[inline]
    fn time(&mut self) {
        self.time.toggle();
    }

    #[inline]
    fn state(&mut self, on: bool) {
        self.state.set_level(on.into());
    }

    #[inline]
    fn reset(&mut self) {
        ecss_can_stm32f4::reset()
    }
}
