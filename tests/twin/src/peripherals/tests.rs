//! The bus in front of the peripherals.

use super::*;

const RCC: u32 = 0x4002_3800;

fn enable(peripherals: &mut Peripherals, register: u32, bits: u32) {
    peripherals.write(Now::default(), RCC + register, Width::Word, bits).unwrap();
}

#[test]
fn nothing_answers_where_no_peripheral_is_modelled() {
    let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
    for address in [0x4000_0800, 0x4000_4400, 0x4002_3850 - 4, 0x5000_0000] {
        assert_eq!(peripherals.read(Now::default(), address, Width::Word), Err(Refusal::Unmodelled));
    }
}

#[test]
fn a_block_without_clock_refuses() {
    let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
    let moder = 0x4002_0400;
    assert_eq!(peripherals.read(Now::default(), moder, Width::Word), Err(Refusal::ClockOff));
    enable(&mut peripherals, 0x30, 1 << 1);
    assert_eq!(peripherals.read(Now::default(), moder, Width::Word), Ok(0x280));
}

#[test]
fn can_takes_words_only() {
    let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
    enable(&mut peripherals, 0x40, 1 << 25);
    assert_eq!(peripherals.read(Now::default(), 0x4000_6400, Width::Half), Err(Refusal::Width));
    assert_eq!(peripherals.read(Now::default(), 0x4000_6400, Width::Word), Ok(0x0001_0002));
}

#[test]
fn a_byte_store_to_a_port_keeps_its_neighbours() {
    let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
    enable(&mut peripherals, 0x30, 1);
    peripherals.write(Now::default(), 0x4002_0000, Width::Byte, 0x55).unwrap();
    assert_eq!(peripherals.read(Now::default(), 0x4002_0000, Width::Word), Ok(0xA800_0055));
}

#[test]
fn the_wire_sees_a_controller_only_behind_its_pins() {
    let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
    enable(&mut peripherals, 0x40, 1 << 25);
    enable(&mut peripherals, 0x30, 1 << 1);
    assert!(peripherals.can_line(Side::Can1).is_none());
    peripherals.write(Now::default(), 0x4002_0424, Width::Word, 0x99).unwrap();
    peripherals.write(Now::default(), 0x4002_0400, Width::Word, 0x000A_0280).unwrap();
    assert!(peripherals.can_line(Side::Can1).is_some());
}

#[test]
fn an_rcc_reset_returns_a_block_to_its_reset_state() {
    let mut peripherals = Peripherals::new(Model::PYBOARD_V11, 0);
    enable(&mut peripherals, 0x40, 1);
    peripherals.write(Now::default(), 0x4000_0028, Width::Half, 83).unwrap();
    enable(&mut peripherals, 0x20, 1);
    assert_eq!(peripherals.read(Now::default(), 0x4000_0028, Width::Word), Ok(0));
}

#[test]
fn the_f446_has_no_port_i_and_its_own_identity() {
    let mut f446 = Peripherals::new(Model::NUCLEO_F446RE, 0);
    enable(&mut f446, 0x30, 0x1FF);
    let mut read = |address| f446.read(Now::default(), address, Width::Word);
    assert_eq!(read(0x4002_1C00), Ok(0), "port H");
    assert_eq!(read(0x4002_2000), Err(Refusal::Unmodelled), "port I");
    assert_eq!(read(0xE004_2000).map(|id| id & 0xFFF), Ok(0x421));
    assert_eq!(read(0x1FFF_7A20).map(|size| size >> 16), Ok(512));
}
