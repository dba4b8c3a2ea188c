//! Drivers of embassy-stm32 on the peripherals of emulated boards (`twin/foreign/peripherals`).

use can_wire::time::Time;
use twin::board::{AccessError, BoardConfig, EmulatedBoard, Fittings, SerialWord};
use twin::crystal::Crystal;
use twin::devices::Loopback;
use twin::model::Model;
use twin::pin::Pin;

use flight::{NUCLEO_F446RE, PYBOARD_V11, parsed};

const USART1: u8 = 1;
const UART4: u8 = 4;
const USART6: u8 = 6;

/// A board that has flown the drivers, what it said, and what left its serial ports.
struct Flown {
    log: Vec<String>,
    serial: Vec<SerialWord>,
    refused: AccessError,
}

impl Flown {
    /// What follows `name` in the log.
    fn said(&self, name: &str) -> &str {
        let line = self.log.iter().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        line.unwrap_or_else(|| panic!("no {name} in {:#?}", self.log))
    }

    fn words(&self, usart: u8) -> Vec<SerialWord> {
        self.serial.iter().filter(|word| word.usart == usart).copied().collect()
    }

    fn data(&self, usart: u8) -> Vec<u16> {
        self.words(usart).iter().map(|word| word.data).collect()
    }
}

/// The board `name` with its image.
fn drivers(name: &str) -> EmulatedBoard {
    let elf = firmware_images::build_test_peripherals(name).unwrap();
    let config = BoardConfig {
        name: "drivers".to_owned(),
        model: Model::shipped(name),
        image: parsed(&elf),
        straps: Vec::new(),
        crystal: Crystal::ppm(0.0),
        position_m: 0.0,
        power_on_at: Time::ZERO,
        fittings: Fittings { temperature_c: -10.5, ..Fittings::default() },
    };
    let mut board = EmulatedBoard::new(config, 7);
    board.attach_spi(1, Loopback, Some(Pin::new('C', 4)));
    board.power(true);
    board
}

/// Flies the image for the board `name`, with another end at each serial port, until it reaches for the DAC.
fn fly(name: &str) -> Flown {
    let mut board = drivers(name);
    board.put_serial(USART1, 9_600, &(1..=20).collect::<Vec<u8>>());
    // The driver of the other port loses what comes before it listens.
    let mut log = Vec::new();
    while !log.iter().any(|line| line == "buffered: true") {
        let next = board.now() + Time::from_ms(1);
        board.run_until(next).unwrap();
        log.extend(board.take_log().into_iter().map(|line| line.text));
        assert!(next < Time::from_ms(600), "{log:#?}");
    }
    board.put_serial(UART4, 1_000_000, b"until idle");
    let refused = board.run_until(Time::from_ms(5_000)).unwrap_err();
    log.extend(board.take_log().into_iter().map(|line| line.text));
    Flown { log, serial: board.take_serial(), refused }
}

fn both() -> [Flown; 2] {
    [PYBOARD_V11, NUCLEO_F446RE].map(fly)
}

/// Given an LM75, a wire from MOSI to MISO and another end on each serial port, when the drivers run, then each finds what is there.
#[test]
fn the_drivers_of_embassy_find_what_is_there() {
    for flown in both() {
        assert_eq!(flown.said("i2c"), "[2A, 80] [F5, 80] Err(Nack) true");
        assert_eq!(flown.data(USART6), b"hello".map(u16::from));
        assert_eq!(flown.said("buffered"), "true");
        assert_eq!(flown.data(USART1), (2..=16).collect::<Vec<u16>>());
        assert_eq!(flown.said("echo"), "10");
        assert_eq!(flown.data(UART4), b"until idle".map(u16::from));
        assert_eq!(flown.said("spi"), "[255, 255] [1, 2, 3, 4] [5, 6, 7, 8] [4660, 43981]");
        for timer in [1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14] {
            assert_eq!(flown.said(&format!("TIM{timer}")), "10 updates");
        }
        // CRC-32/MPEG-2 of 12345678h, and of that, zero and FFFF FFFFh.
        assert_eq!(flown.said("crc"), "DF8A8A2B EC13FD42");
        // Set to 23:59:58 of the 28th of February; the second second of LSI begins within a cycle of it.
        assert_eq!(flown.said("alarm"), "2028-2-29 0:0:1 3000");
        assert_eq!(flown.said("wake-up"), "100");
        assert_eq!(flown.said("copy"), "true");
        assert_eq!(flown.said("backup"), "B00C0DE5");
        let levels: Vec<_> = flown.log.iter().filter(|line| line.starts_with("options")).collect();
        assert_eq!(levels, ["options: 3", "options: 2"], "before and after the reset");
        assert_eq!(flown.log.last().map(String::as_str), Some("done"));
    }
}

#[test]
fn the_f405_alone_has_random_numbers() {
    let [f405, f446] = both();
    assert_eq!(f405.said("rng"), "true");
    assert!(!f446.log.iter().any(|line| line.starts_with("rng")));
}

/// A word lasts 10 bits without, 11 with parity; the driver sends them back to back.
#[test]
fn words_last_as_long_as_the_bit_rate_says() {
    let [flown, _] = both();
    for (usart, baud, bits) in [(USART6, 115_200.0, 10.0), (USART1, 9_600.0, 11.0)] {
        let words = flown.words(usart);
        assert!(words.len() >= 5, "{} words", words.len());
        for pair in words.windows(2) {
            let us = (pair[1].at - pair[0].at).as_us() as f64;
            assert!((us - bits / baud * 1e6).abs() < 1.5, "{us} us at {baud}");
            assert!((f64::from(pair[0].baud) / baud - 1.0).abs() < 0.005, "{} for {baud}", pair[0].baud);
        }
    }
}

/// Given a program that reaches for the DAC at its end, then the error names its register and the function.
#[test]
fn a_refusal_names_the_register_and_the_function() {
    for Flown { refused, .. } in both() {
        assert_eq!(
            (refused.address, refused.register.as_deref()),
            (0x4000_7400, Some("DAC.CR")),
            "{refused}"
        );
        let function = refused.function.as_deref().unwrap_or_else(|| panic!("{refused}"));
        assert!(function.ends_with("::beyond"), "{refused}");
        assert!(refused.to_string().contains(&format!("in {function} ")), "{refused}");
    }
}
