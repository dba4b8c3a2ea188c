//! Text of `memory.x`.

use crate::Chip;

/// First address of the flash.
const FLASH: u32 = 0x0800_0000;
/// First address of the CCM.
const CCM: u32 = 0x1000_0000;
/// First address of the SRAM.
const RAM: u32 = 0x2000_0000;
/// Size of the parameter store: two sectors.
const STORE_KIB: u32 = 2 * 128;
/// Size of the stack in SRAM, where there is no CCM.
const STACK_KIB: u32 = 72;

impl Chip {
    /// Returns the address of the parameter store: of the last two sectors of flash, 128 KiB each.
    pub fn store_start(&self) -> u32 {
        FLASH + (self.flash_kib() - STORE_KIB) * 1024
    }

    /// Returns the text of `memory.x`.
    pub fn memory_map(&self) -> String {
        let name = self.name().to_ascii_uppercase();
        let (flash, ram) = (size(self.flash_kib()), self.ram_kib());
        let program_kib = self.flash_kib() - STORE_KIB;
        let store = self.store_start();
        let (memories, reason, stack, regions) = match self.ccm_kib() {
            0 => (
                format!("{ram} KiB of contiguous RAM, no CCM"),
                format!(
                    "The stack has the first {STACK_KIB} KiB of RAM: below there is no memory, so that a stack that grows \
                     too far is a fault."
                ),
                "STACK",
                region("STACK", RAM, STACK_KIB)
                    + &region("RAM", RAM + STACK_KIB * 1024, ram - STACK_KIB),
            ),
            ccm => (
                format!("{ram} KiB of contiguous RAM, {ccm} KiB of CCM"),
                "The stack has the CCM: DMA does not reach it, and below it there is no memory, so that a stack that \
                 grows too far is a fault."
                    .to_owned(),
                "CCM",
                region("CCM", CCM, ccm) + &region("RAM", RAM, ram),
            ),
        };
        let flash_regions = region("FLASH", FLASH, program_kib) + &region("STORE", store, STORE_KIB);
        let device_id = self.device_id();
        format!(
            "/* {name}: {flash} of flash, {memories}.
   The last two 128 KiB sectors of flash belong to the parameter store, not to the program.
   {reason} */
MEMORY
{{
{flash_regions}{regions}}}
__store_start = ORIGIN(STORE);
_stack_end = ORIGIN({stack});
_stack_start = ORIGIN({stack}) + LENGTH({stack});
/* DEV_ID of DBGMCU_IDCODE: the chips that this image is for. */
__device_id = {device_id:#05x};
"
        )
    }
}

/// Returns a line of the linker's MEMORY block.
fn region(name: &str, origin: u32, kib: u32) -> String {
    format!("  {name:<5} : ORIGIN = 0x{origin:08X}, LENGTH = {kib}K\n")
}

fn size(kib: u32) -> String {
    if kib.is_multiple_of(1024) { format!("{} MiB", kib / 1024) } else { format!("{kib} KiB") }
}
