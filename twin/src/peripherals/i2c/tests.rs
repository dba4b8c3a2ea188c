//! I2C as a program accesses it, register by register.

use crate::devices::Lm75;
use crate::mmio::{Refusal, Width};
use crate::peripherals::bench::{Bench, RCC};

const PORT_B: u32 = 0x4002_0400;
const I2C1: u32 = 0x4000_5400;
const CR1: u32 = I2C1;
const CR2: u32 = I2C1 + 0x04;
const DR: u32 = I2C1 + 0x10;
const SR1: u32 = I2C1 + 0x14;
const SR2: u32 = I2C1 + 0x18;
const CCR: u32 = I2C1 + 0x1C;
const TRISE: u32 = I2C1 + 0x20;

const PE: u32 = 1;
const START: u32 = 1 << 8;
const STOP: u32 = 1 << 9;
const ACK: u32 = 1 << 10;
const POS: u32 = 1 << 11;

/// SCL of 100 kHz at 16 MHz: a byte with its acknowledgement takes nine periods.
const PERIOD: u64 = 160;
const BYTE: u64 = 9 * PERIOD;

/// A pyboard with I2C1 on PB6 and PB7 at 100 kHz.
fn with(device: Option<Lm75>) -> Bench {
    let mut bench = Bench::pyboard();
    if let Some(device) = device {
        bench.peripherals.attach_i2c(0, 0, Box::new(device));
    }
    bench.set_up([(RCC + 0x30, 1 << 1), (RCC + 0x40, 1 << 21)]);
    bench.set_up([(PORT_B, 0x0000_A280), (PORT_B + 0x20, 0x4400_0000)]);
    bench.set_up([(CR2, 16), (CCR, 80), (TRISE, 17), (CR1, PE)]);
    bench
}

/// Sends START and address, and loads SR2, which clears ADDR.
fn select(bench: &mut Bench, address: u32, cr1: u32) {
    bench.write(CR1, cr1 | START);
    bench.cycle += PERIOD / 2;
    assert_eq!(bench.read(SR1) & 1, 1, "SB");
    bench.write(DR, address);
    bench.cycle += BYTE;
    assert_eq!(bench.read(SR1) & 2, 2, "ADDR");
    bench.read(SR2);
}

/// RM0090 27.3.3, figures 240 and 241: EV5, EV6, EV8 and EV8_2.
#[test]
fn a_transmission_goes_through_its_events() {
    let mut bench = with(Some(Lm75::new(0x48, 25.0)));
    assert_eq!((bench.read(SR1), bench.read(SR2)), (0, 0));
    bench.write(CR1, PE | START);
    bench.cycle += PERIOD / 2 - 1;
    assert_eq!((bench.read(SR1), bench.read(SR2)), (0, 2), "BUSY alone while the START lasts");
    bench.cycle += 1;
    assert_eq!(
        (bench.read(SR1), bench.read(SR2), bench.read(CR1)),
        (1, 3, PE),
        "SB; MSL and BUSY; START is cleared"
    );
    bench.write(DR, 0x90);
    assert_eq!(bench.read(SR1), 0);
    bench.cycle += BYTE - 1;
    assert_eq!(bench.read(SR1), 0);
    bench.cycle += 1;
    assert_eq!(bench.read(SR2), 7, "without a load of SR1 since, ADDR stays");
    assert_eq!(bench.read(SR1), 0x82, "ADDR and TXE");
    assert_eq!(bench.read(SR2), 7, "TRA");
    assert_eq!(bench.read(SR1), 0x80);
    // Two bytes are taken at once: one into the shift register, one into DR.
    bench.write(DR, 1);
    assert_eq!(bench.read(SR1), 0x80);
    bench.write(DR, 1);
    assert_eq!(bench.read(SR1), 0);
    bench.cycle += BYTE;
    assert_eq!(bench.read(SR1), 0x80);
    bench.cycle += BYTE;
    assert_eq!(bench.read(SR1), 0x84, "BTF and TXE");
    bench.write(CR1, PE | STOP);
    assert_eq!((bench.read(SR1), bench.read(SR2)), (0, 7));
    bench.cycle += PERIOD / 2;
    assert_eq!((bench.read(SR2), bench.read(CR1)), (0, PE), "STOP is cleared");
}

/// The data sheet's way: pointer, repeated START, two bytes; ACK off before the second one ends.
#[test]
fn a_reception_ends_with_nack_and_stop() {
    let mut bench = with(Some(Lm75::new(0x48, 25.5)));
    select(&mut bench, 0x90, PE | ACK);
    bench.write(DR, 0);
    bench.cycle += BYTE;
    assert_eq!(bench.read(SR1), 0x84);
    select(&mut bench, 0x91, PE | ACK);
    bench.cycle += BYTE;
    assert_eq!((bench.read(SR1), bench.read(DR)), (0x40, 0x19));
    bench.write(CR1, PE | STOP);
    bench.cycle += BYTE;
    assert_eq!((bench.read(SR1), bench.read(DR), bench.read(SR1)), (0x40, 0x80, 0));
    bench.cycle += PERIOD / 2;
    assert_eq!(bench.read(SR2), 0);
}

/// RM0090 27.3.3, reception of two bytes: POS, ACK off after ADDR, BTF, STOP, two loads of DR.
#[test]
fn two_bytes_are_received_by_pos_and_btf() {
    let mut bench = with(Some(Lm75::new(0x48, 25.5)));
    select(&mut bench, 0x91, PE | ACK | POS);
    bench.write(CR1, PE | POS);
    bench.cycle += 2 * BYTE;
    assert_eq!(bench.read(SR1), 0x44, "RXNE and BTF");
    bench.write(CR1, PE | POS | STOP);
    assert_eq!((bench.read(DR), bench.read(SR1)), (0x19, 0x40));
    assert_eq!((bench.read(DR), bench.read(SR1)), (0x80, 0));
}

/// A byte that is not read stretches the clock: the third one waits.
#[test]
fn a_slow_program_stretches_the_clock() {
    let mut bench = with(Some(Lm75::new(0x48, 25.5)));
    select(&mut bench, 0x91, PE | ACK);
    bench.cycle += 20 * BYTE;
    assert_eq!(bench.read(SR1), 0x44);
    assert_eq!(bench.read(DR), 0x19);
    assert_eq!(bench.read(SR1), 0x40, "the byte of the shift register");
    bench.cycle += BYTE - 1;
    assert_eq!(bench.read(SR1), 0x40);
    bench.cycle += 1;
    assert_eq!(bench.read(SR1), 0x44);
}

#[test]
fn a_missing_acknowledgement_raises_the_error_line() {
    let mut bench = with(Some(Lm75::new(0x4F, 25.0)));
    bench.write(CR2, 16 | 1 << 8);
    bench.write(CR1, PE | START);
    bench.cycle += PERIOD / 2;
    bench.read(SR1);
    bench.write(DR, 0x90);
    bench.cycle += BYTE;
    assert_eq!(bench.irqs(), [32], "I2C1_ER is input 32");
    assert_eq!((bench.read(SR1), bench.read(SR2)), (0x400, 3), "AF; still master");
    bench.write(SR1, !0x400);
    assert_eq!(bench.irqs(), [0; 0]);
    bench.write(CR1, PE | STOP);
    bench.cycle += PERIOD / 2;
    assert_eq!(bench.read(SR2), 0);
}

#[test]
fn events_raise_their_line_where_enabled() {
    let mut bench = with(Some(Lm75::new(0x48, 25.0)));
    bench.write(CR1, PE | START);
    bench.cycle += PERIOD / 2;
    assert_eq!(bench.irqs(), [0; 0]);
    bench.write(CR2, 16 | 1 << 9);
    assert_eq!(bench.irqs(), [31]);
    bench.read(SR1);
    bench.write(DR, 0x90);
    assert_eq!(bench.irqs(), [0; 0]);
    assert_eq!(bench.peripherals.next_timer_event(bench.now()), Some(bench.cycle + BYTE));
    bench.cycle += BYTE;
    bench.read(SR1);
    bench.read(SR2);
    assert_eq!(bench.irqs(), [0; 0], "TXE needs ITBUFEN");
    bench.write(CR2, 16 | 3 << 9);
    assert_eq!(bench.irqs(), [31]);
}

/// Without a device the lines have no pull-ups and no START ends. With the chip's own pull-ups it ends, and no device
/// acknowledges.
#[test]
fn without_a_pull_up_no_start_ends() {
    let mut bench = with(None);
    bench.write(CR1, PE | START);
    bench.cycle += 1_000_000;
    assert_eq!((bench.read(SR1), bench.read(SR2), bench.read(CR1)), (0, 2, PE | START));
    bench.write(PORT_B + 0x0C, 0x0000_5100);
    bench.irqs();
    bench.cycle += PERIOD / 2;
    assert_eq!(bench.read(SR1), 1);
    bench.write(DR, 0x90);
    bench.cycle += BYTE;
    assert_eq!(bench.read(SR1), 0x400);
}

#[test]
fn without_its_pins_no_start_ends() {
    let mut bench = with(Some(Lm75::new(0x48, 25.0)));
    bench.write(PORT_B + 0x20, 0x4000_0000);
    bench.write(CR1, PE | START);
    bench.cycle += 1_000_000;
    assert_eq!((bench.read(SR1), bench.read(SR2)), (0, 2));
}

/// RM0090 27.6.8: SCL in fast mode is 3 or 25 times CCR long.
#[test]
fn the_speed_follows_ccr() {
    for (ccr, byte) in [(80, 9 * 160), (1 << 15 | 14, 9 * 42), (3 << 14 | 2, 9 * 50)] {
        let mut bench = with(Some(Lm75::new(0x48, 25.0)));
        for (register, value) in [(CR1, 0), (CCR, ccr), (CR1, PE | START)] {
            bench.write(register, value);
        }
        bench.cycle += PERIOD;
        bench.read(SR1);
        bench.write(DR, 0x90);
        bench.cycle += byte - 1;
        assert_eq!(bench.read(SR1), 0, "{ccr:X}h");
        bench.cycle += 1;
        assert_eq!(bench.read(SR1), 0x82, "{ccr:X}h");
    }
}

#[test]
fn what_the_manual_forbids_is_refused() {
    for (register, value) in [(CR2, 42), (CCR, 3)] {
        let mut bench = with(None);
        bench.write(CR1, 0);
        bench.write(register, value);
        assert_eq!(bench.store(CR1, Width::Word, PE), Err(Refusal::Misuse), "{register:08X}h");
    }
    let mut bench = with(Some(Lm75::new(0x48, 25.0)));
    for bit in [1, 4, 5, 12, 13] {
        assert_eq!(bench.store(CR1, Width::Word, PE | 1 << bit), Err(Refusal::Unmodelled), "bit {bit}");
    }
    bench.write(CR1, PE | START);
    bench.cycle += PERIOD;
    assert_eq!(bench.store(DR, Width::Word, 0x90), Err(Refusal::Misuse), "SB was not read");
    bench.read(SR1);
    assert_eq!(bench.store(DR, Width::Word, 0xF0), Err(Refusal::Unmodelled), "ten bits");
}

#[test]
fn a_software_reset_releases_the_bus() {
    let mut bench = with(Some(Lm75::new(0x48, 25.0)));
    select(&mut bench, 0x90, PE);
    bench.write(CR1, 1 << 15);
    assert_eq!(bench.read(CR1), 1 << 15);
    bench.write(CR1, 0);
    for (register, value) in [(CR1, 0), (CR2, 0), (SR1, 0), (SR2, 0), (CCR, 0), (TRISE, 2)] {
        assert_eq!(bench.read(register), value, "{register:08X}h");
    }
}

/// Given two devices on one bus, then the address selects one.
#[test]
fn only_the_addressed_device_answers() {
    let mut bench = with(Some(Lm75::new(0x48, 25.0)));
    bench.peripherals.attach_i2c(0, 0, Box::new(Lm75::new(0x49, 50.0)));
    for (address, byte) in [(0x91, 0x19), (0x93, 0x32)] {
        select(&mut bench, address, PE | ACK);
        bench.write(CR1, PE | STOP);
        bench.cycle += BYTE;
        assert_eq!(bench.read(DR), byte);
        bench.cycle += PERIOD;
    }
}
