//! Record of the last reset (2032h), which an emergency reports after the boot-up message.

use easy_ext::ext;

use super::Services;
use crate::node::SpacecraftDevice;

#[ext(PostMortemServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Notes that a heartbeat or boot-up message was sent.
    pub fn on_heartbeat_sent(&mut self) {
        if self.state_mut().take_reset() {
            self.report_reset();
        }
    }

    #[inline(never)] // once
    pub fn report_reset(&mut self) {
        if let Some((code, info)) = self.objects().extension.reset_emergency() {
            self.report_past(code, info);
        }
    }
}
