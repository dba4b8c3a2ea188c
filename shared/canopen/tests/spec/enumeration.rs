//! Values that are enums: `#[derive(Enumeration)]`. Structs for the values of a PDO: `#[derive(PdoValues)]`.

use async_canopen::od::{Access, DataType, Entry, NamedValue, Names, Number, Typed, Variable, checked};
use async_canopen::pdo::{Direction, Layout};
use async_canopen::prelude::*;
use async_canopen::types::AbortCode::{TooLong, TooShort, ValueRange, ValueTooHigh};

/// With a gap, and not in the order of the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u8)]
enum Mode {
    Boost = 8,
    #[default]
    Off = 0,
    Auto,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(i16)]
enum Direct {
    Down = -300,
    #[default]
    Still = 0,
    Up = 300,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u32)]
enum Wide {
    #[default]
    Low = 1,
    High = u32::MAX,
}

#[derive(Debug, Record)]
struct Channel {
    /// Gain
    #[sub(1, rw, pdo)]
    gain: u8,
    /// Mode
    #[sub(2.., rw, pdo)]
    modes: [Mode; 2],
}

#[derive(Debug, Objects)]
struct Group {
    /// Wide
    #[object(0x6400, rw)]
    wide: Wide,
}

#[derive(Debug, Objects)]
struct Heater {
    /// Mode
    #[object(0x6301, rw, pdo, default = Mode::Auto)]
    mode: Mode,
    /// Direction
    #[object(0x6302, array, rww, pdo)]
    directions: [Direct; 3],
    /// Limited mode
    #[object(0x6303, rw, pdo, high = 1)]
    limited: Mode,
    /// Channel
    #[object(0x6310.., record)]
    channels: [Channel; 2],
    /// Modes in a row
    #[object(0x6320.., rw)]
    row: [Mode; 2],
    #[objects]
    group: Group,
}

fn write(heater: &mut Heater, index: u16, sub: u8, value: &[u8]) -> Result<(), AbortCode> {
    checked::write(heater, Address::new(index, sub), value)
}

#[test]
fn bits_of_an_enumeration_are_those_of_its_number() {
    assert_eq!((Mode::TYPE, Mode::SIZE), (DataType::Unsigned8, 1));
    assert_eq!((Direct::TYPE, Direct::SIZE), (DataType::Integer16, 2));
    assert_eq!((Wide::TYPE, Wide::SIZE), (DataType::Unsigned32, 4));
    assert_eq!((Mode::Boost.bits(), Direct::Down.bits(), Wide::High.bits()), (8, 0xFED4, 0xFFFF_FFFF));
    // What lies above belongs to others.
    assert_eq!(Mode::from_bits(0xAA01), Some(Mode::Auto));
    assert_eq!(Direct::from_bits(0xAA_FED4), Some(Direct::Down));
    assert_eq!((Mode::from_bits(2), Direct::from_bits(0xFFFF), Wide::from_bits(0)), (None, None, None));
    assert_eq!((0..=u8::MAX).filter(|number| Mode::is_value((*number).into())).count(), 3);
}

#[test]
fn bits_without_a_variant_change_nothing() {
    let mut mode = Mode::Auto;
    mode.set_bits(7);
    assert_eq!(mode, Mode::Auto);
    mode.set_bits(8);
    assert_eq!(mode, Mode::Boost);
}

#[test]
fn value_at_power_on_is_a_variant() {
    let heater = Heater::default();
    assert_eq!((heater.mode, heater.limited, heater.group.wide), (Mode::Auto, Mode::Off, Wide::Low));
    assert_eq!(heater.directions, [Direct::Still; 3]);
}

/// Given values of an enumeration in each place of a dictionary, when a client writes a number without a variant, then it gets
/// 06090030h and the value stays.
///
/// Verifies: ECSS 6.1a
#[test]
fn sdo_write_without_a_variant_is_aborted() {
    let mut heater = Heater::default();
    assert_eq!(write(&mut heater, 0x6301, 0, &[8]), Ok(()));
    assert_eq!(write(&mut heater, 0x6301, 0, &[9]), Err(ValueRange));
    assert_eq!(heater.mode, Mode::Boost);
    assert_eq!(write(&mut heater, 0x6302, 3, &[0x2C, 0x01]), Ok(()));
    assert_eq!(write(&mut heater, 0x6302, 3, &[0x2D, 0x01]), Err(ValueRange));
    assert_eq!(heater.directions, [Direct::Still, Direct::Still, Direct::Up]);
    assert_eq!(write(&mut heater, 0x6311, 3, &[8]), Ok(()));
    assert_eq!(write(&mut heater, 0x6311, 3, &[2]), Err(ValueRange));
    assert_eq!(write(&mut heater, 0x6311, 1, &[2]), Ok(()));
    assert_eq!((heater.channels[1].gain, heater.channels[1].modes), (2, [Mode::Off, Mode::Boost]));
    assert_eq!(write(&mut heater, 0x6321, 0, &[1]), Ok(()));
    assert_eq!(write(&mut heater, 0x6321, 0, &[3]), Err(ValueRange));
    assert_eq!(heater.row, [Mode::Off, Mode::Auto]);
    assert_eq!(write(&mut heater, 0x6400, 0, &[0xFF; 4]), Ok(()));
    assert_eq!(write(&mut heater, 0x6400, 0, &[0; 4]), Err(ValueRange));
    assert_eq!(heater.group.wide, Wide::High);
}

#[test]
fn length_and_limits_are_checked_before_the_variant() {
    let mut heater = Heater::default();
    assert_eq!(write(&mut heater, 0x6302, 1, &[1]), Err(TooShort));
    assert_eq!(write(&mut heater, 0x6301, 0, &[9, 9]), Err(TooLong));
    assert_eq!(write(&mut heater, 0x6303, 0, &[8]), Err(ValueTooHigh));
    assert_eq!(write(&mut heater, 0x6303, 0, &[1]), Ok(()));
    assert_eq!(heater.limited, Mode::Auto);
}

/// Given receive PDOs of a single value and of values in a row, when one of them has no variant, then it stays, the others are
/// taken, and the frame does not count as applied.
///
/// Verifies: ECSS 6.2a
#[test]
fn receive_pdo_without_a_variant_is_out_of_range() {
    let mut heater = Heater::default();
    let layout = |entries: &[u32]| Layout::new::<Heater>(Direction::Receive, entries).unwrap();
    let single = layout(&[0x6301_0008]);
    assert!(single.unpack(&mut heater, 8));
    assert!(!single.unpack(&mut heater, 2));
    assert_eq!(heater.mode, Mode::Boost);
    let limited = layout(&[0x6303_0008]);
    assert!(limited.unpack(&mut heater, 1));
    assert!(!limited.unpack(&mut heater, 8));
    assert_eq!(heater.limited, Mode::Auto);
    let row = layout(&[0x6302_0110, 0x6302_0210, 0x6302_0310]);
    assert!(row.unpack(&mut heater, 0x012C_0000_FED4));
    assert!(!row.unpack(&mut heater, 0xFED4_0001_012C));
    assert_eq!(heater.directions, [Direct::Up, Direct::Still, Direct::Down]);
    let record = layout(&[0x6311_0108, 0x6311_0208, 0x6311_0308]);
    assert!(record.unpack(&mut heater, 0x08_01_07));
    assert!(!record.unpack(&mut heater, 0x07_00_06));
    assert_eq!((heater.channels[1].gain, heater.channels[1].modes), (6, [Mode::Off, Mode::Boost]));
}

#[test]
fn names_of_an_enumeration_are_described() {
    let mut described = vec![];
    Heater::describe(&mut |object, names: &Names| described.push((object.index, names.values)));
    let of = |index| described.iter().find(|(other, _)| *other == index).unwrap().1;
    let mode: &[NamedValue] = &[
        NamedValue { number: 8, name: "Boost" },
        NamedValue { number: 0, name: "Off" },
        NamedValue { number: 1, name: "Auto" },
    ];
    assert_eq!(of(0x6301), [mode]);
    assert_eq!(of(0x6302)[0], []);
    assert_eq!(of(0x6302)[1].iter().map(|value| value.number).collect::<Vec<_>>(), [-300, 0, 300]);
    assert_eq!(of(0x6310), [&[], &[], mode]);
    assert_eq!(of(0x6400)[0][1], NamedValue { number: 0xFFFF_FFFF, name: "High" });
    // Images have no names: the entry is that of a number.
    assert_eq!(
        Heater::MODE.entry(),
        &Entry::of::<u8>(0, 1, Access::Rw).for_pdo(async_canopen::od::PdoUse::Required)
    );
}

/// Values of [`STATE`].
#[derive(Clone, Copy, Debug, PartialEq, PdoValues)]
struct State {
    mode: Mode,
    direction: Direct,
    gain: u8,
}

const TUPLE: Pdo<Heater, (Mode, Direct, u8)> =
    Pdo::new(CobIdOf::node(0x280)).map(Heater::MODE).skip().map(Heater::CHANNELS.nth(0).field(Channel::GAIN));
const STATE: Pdo<Heater, State> = TUPLE.into_struct();
const HEATER: NodeId = NodeId::of::<5>();
const PDOS: PdoSet = PdoSet::new(&[STATE.of(HEATER).receive(1)], &[]);

fn received(data: [u8; 4]) -> ReceivedPdo {
    let [a, b, c, d] = data;
    ReceivedPdo::new(&PDOS, 0, Bus::Nominal, [a, b, c, d, 0, 0, 0, 0], Instant::ZERO)
}

#[test]
fn struct_and_tuple_are_the_same_payload() {
    let state = State { mode: Mode::Boost, direction: Direct::Down, gain: 7 };
    let frame = STATE.of(HEATER).frame(state);
    assert_eq!((frame.id().raw(), frame.data()), (0x285, &[8, 0xD4, 0xFE, 7][..]));
    assert_eq!(frame, TUPLE.of(HEATER).frame((Mode::Boost, Direct::Down, 7)));
    let pdo = received([8, 0xD4, 0xFE, 7]);
    assert_eq!((pdo.get(STATE.of(HEATER)), pdo.from(STATE)), (Some(state), Some((HEATER, state))));
    assert_eq!(pdo.get(TUPLE.of(HEATER)), Some((Mode::Boost, Direct::Down, 7)));
}

/// Given a PDO of another node with a number that has no variant, then its receiver gets no values and sees that it is this PDO.
#[test]
fn pdo_of_another_node_without_a_variant_has_no_values() {
    for data in [[2, 0, 0, 7], [8, 0xD5, 0xFE, 7]] {
        let pdo = received(data);
        assert!(pdo.is(STATE.of(HEATER)));
        assert_eq!(
            (pdo.get(STATE.of(HEATER)), pdo.get(TUPLE.of(HEATER)), pdo.from(STATE)),
            (None, None, None)
        );
    }
}
