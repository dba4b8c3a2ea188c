//! Memory maps, compared with text that is written here by hand.

use ecss_can_memory::Chip;

fn map(chip: &str) -> String {
    Chip::named(chip).unwrap().memory_map()
}

#[test]
fn f405rg_has_its_stack_in_ccm() {
    let expected = "\
/* STM32F405RG: 1 MiB of flash, 128 KiB of contiguous RAM, 64 KiB of CCM.
   The last two 128 KiB sectors of flash belong to the parameter store, not to the program.
   The stack has the CCM: DMA does not reach it, and below it there is no memory, so that a stack that grows too far is a fault. */
MEMORY
{
  FLASH : ORIGIN = 0x08000000, LENGTH = 768K
  STORE : ORIGIN = 0x080C0000, LENGTH = 256K
  CCM   : ORIGIN = 0x10000000, LENGTH = 64K
  RAM   : ORIGIN = 0x20000000, LENGTH = 128K
}
__store_start = ORIGIN(STORE);
_stack_end = ORIGIN(CCM);
_stack_start = ORIGIN(CCM) + LENGTH(CCM);
/* DEV_ID of DBGMCU_IDCODE: the chips that this image is for. */
__device_id = 0x413;
";
    assert_eq!(map("stm32f405rg"), expected);
}

#[test]
fn f446re_has_its_stack_in_the_first_72_kib_of_ram() {
    let expected = "\
/* STM32F446RE: 512 KiB of flash, 128 KiB of contiguous RAM, no CCM.
   The last two 128 KiB sectors of flash belong to the parameter store, not to the program.
   The stack has the first 72 KiB of RAM: below there is no memory, so that a stack that grows too far is a fault. */
MEMORY
{
  FLASH : ORIGIN = 0x08000000, LENGTH = 256K
  STORE : ORIGIN = 0x08040000, LENGTH = 256K
  STACK : ORIGIN = 0x20000000, LENGTH = 72K
  RAM   : ORIGIN = 0x20012000, LENGTH = 56K
}
__store_start = ORIGIN(STORE);
_stack_end = ORIGIN(STACK);
_stack_start = ORIGIN(STACK) + LENGTH(STACK);
/* DEV_ID of DBGMCU_IDCODE: the chips that this image is for. */
__device_id = 0x421;
";
    assert_eq!(map("stm32f446re"), expected);
}

#[test]
fn f429zi_has_its_store_at_the_end_of_bank_2() {
    let expected = "\
/* STM32F429ZI: 2 MiB of flash, 192 KiB of contiguous RAM, 64 KiB of CCM.
   The last two 128 KiB sectors of flash belong to the parameter store, not to the program.
   The stack has the CCM: DMA does not reach it, and below it there is no memory, so that a stack that grows too far is a fault. */
MEMORY
{
  FLASH : ORIGIN = 0x08000000, LENGTH = 1792K
  STORE : ORIGIN = 0x081C0000, LENGTH = 256K
  CCM   : ORIGIN = 0x10000000, LENGTH = 64K
  RAM   : ORIGIN = 0x20000000, LENGTH = 192K
}
__store_start = ORIGIN(STORE);
_stack_end = ORIGIN(CCM);
_stack_start = ORIGIN(CCM) + LENGTH(CCM);
/* DEV_ID of DBGMCU_IDCODE: the chips that this image is for. */
__device_id = 0x419;
";
    assert_eq!(map("stm32f429zi"), expected);
}

#[test]
fn f469ni_has_320_kib_of_ram() {
    let expected = "\
/* STM32F469NI: 2 MiB of flash, 320 KiB of contiguous RAM, 64 KiB of CCM.
   The last two 128 KiB sectors of flash belong to the parameter store, not to the program.
   The stack has the CCM: DMA does not reach it, and below it there is no memory, so that a stack that grows too far is a fault. */
MEMORY
{
  FLASH : ORIGIN = 0x08000000, LENGTH = 1792K
  STORE : ORIGIN = 0x081C0000, LENGTH = 256K
  CCM   : ORIGIN = 0x10000000, LENGTH = 64K
  RAM   : ORIGIN = 0x20000000, LENGTH = 320K
}
__store_start = ORIGIN(STORE);
_stack_end = ORIGIN(CCM);
_stack_start = ORIGIN(CCM) + LENGTH(CCM);
/* DEV_ID of DBGMCU_IDCODE: the chips that this image is for. */
__device_id = 0x434;
";
    assert_eq!(map("stm32f469ni"), expected);
}
