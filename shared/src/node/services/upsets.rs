//! Reports of upsets that the board found (2033h).

use easy_ext::ext;

use super::Services;
use crate::emcy::ErrorCode;
use crate::node::SpacecraftDevice;
use crate::node::upsets::{ProgramState, Upsets};

/// Source of the emergency that reports a mended register. The address of the register follows, little-endian.
const MENDED: u8 = 2;
/// Source of the emergency that reports a damaged or mended program.
const DAMAGED: u8 = 3;

#[ext(UpsetServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Shows what the board found. Reports a register that was mended since the last call, and a program that is damaged or mended. Call it
    /// once for each heartbeat of the node.
    pub fn report_upsets(&mut self) {
        let Some(found) = self.state().upsets().map(Upsets::found) else { return };
        let shown = &mut self.objects_mut().extension.upsets.found;
        let before = core::mem::replace(shown, found);
        if before.registers != found.registers {
            let [a, b, c, d] = found.last.to_le_bytes();
            self.report_past(ErrorCode::HARDWARE, [MENDED, a, b, c, d]);
        }
        let is_damaged = matches!(found.program, ProgramState::Damaged | ProgramState::Mended);
        self.set_error(ErrorCode::HARDWARE, DAMAGED, is_damaged);
    }
}
