//! Serial ports, SPI, timers, CRC unit, random numbers, the backup domain and option bytes, register by register.

use super::*;
use crate::devices::{Loopback, SpiDevice, SpiMode};

const RCC: u32 = 0x4002_3800;
const PORT_A: u32 = 0x4002_0000;
const USART1: u32 = 0x4001_1000;
const SPI1: u32 = 0x4001_3000;
const TIM1: u32 = 0x4001_0000;
const TIM4: u32 = 0x4000_0800;
const TIM6: u32 = 0x4000_1000;
const TIM12: u32 = 0x4000_1800;
const RNG: u32 = 0x5006_0800;
const RTC: u32 = 0x4000_2800;
const PWR: u32 = 0x4000_7000;

/// Peripherals on HSI with every clock of APB1, APB2 and port A on, and their time.
struct Bench {
    peripherals: Peripherals,
    cycle: u64,
}

impl Bench {
    fn new() -> Bench {
        let mut bench = Bench { peripherals: Peripherals::new(Model::shipped("pyboard-v11"), 7), cycle: 0 };
        for (offset, value) in [(0x30, 1 | 1 << 12), (0x34, 1 << 6), (0x40, u32::MAX), (0x44, u32::MAX)] {
            bench.write(RCC + offset, value);
        }
        bench
    }

    fn now(&self) -> Now {
        Now { cycle: self.cycle, time: Time::ZERO }
    }

    fn try_write(&mut self, address: u32, value: u32) -> Result<(), Refusal> {
        self.peripherals.write(self.now(), address, Width::Word, value)
    }

    fn write(&mut self, address: u32, value: u32) {
        self.try_write(address, value).unwrap_or_else(|refusal| panic!("{address:08X}h: {refusal}"));
    }

    fn read(&mut self, address: u32) -> u32 {
        self.peripherals.read(self.now(), address, Width::Word).unwrap()
    }

    fn irqs(&mut self) -> Vec<u32> {
        let levels = self.peripherals.irq_levels(self.now());
        (0..96).filter(|irq| levels[*irq as usize / 32] >> (irq % 32) & 1 == 1).collect()
    }

    /// USART1 on PA9 and PA10 with BRR 160, 100 kbit/s; a word takes 1600 cycles. `cr1` beside UE, TE and RE.
    fn with_usart(cr1: u32) -> Bench {
        let mut bench = Bench::new();
        for (address, value) in [
            (PORT_A, 0xA828_0000),
            (PORT_A + 0x24, 0x0000_0770),
            (USART1 + 0x08, 160),
            (USART1 + 0x0C, 1 << 13 | 0b11 << 2 | cr1),
        ] {
            bench.write(address, value);
        }
        bench
    }
}

/// RM0090 30.3.2: TXE while a word is in the shift register, TC behind the last one.
#[test]
fn a_serial_port_sends_two_words_back_to_back() {
    let mut bench = Bench::with_usart(0);
    assert_eq!(bench.read(USART1), 0xC0);
    bench.write(USART1 + 0x04, 0x41);
    assert_eq!(bench.read(USART1), 0x80);
    bench.write(USART1 + 0x04, 0x42);
    assert_eq!(bench.read(USART1), 0);
    bench.cycle = 3199;
    assert_eq!(bench.read(USART1), 0x80);
    bench.cycle = 3200;
    assert_eq!(bench.read(USART1), 0xC0);
    let sent: Vec<_> =
        bench.peripherals.take_sent().iter().map(|sent| (sent.cycle, sent.data, sent.bit)).collect();
    assert_eq!(sent, [(1600, 0x41, 160), (3200, 0x42, 160)]);
}

/// RXNE, then ORE when nobody reads, then IDLE a word after the last one; the load of SR and DR clears them.
#[test]
fn a_serial_port_receives_overruns_and_falls_idle() {
    let mut bench = Bench::with_usart(1 << 5);
    bench.peripherals.put_serial(0, 0, 100_000, &[1, 2]);
    bench.cycle = 1599;
    assert_eq!(bench.irqs(), [0_u32; 0]);
    bench.cycle = 1600;
    assert_eq!((bench.irqs(), bench.read(USART1)), (vec![37], 0xE0));
    bench.cycle = 4800;
    assert_eq!(bench.read(USART1), 0xF8, "ORE and IDLE");
    assert_eq!((bench.read(USART1 + 0x04), bench.read(USART1)), (1, 0xC0));
    assert_eq!(bench.irqs(), [0_u32; 0]);
}

#[test]
fn another_bit_rate_is_a_framing_error() {
    for (baud, status) in [(97_000, 0xE0), (110_000, 0xE2), (9_600, 0xE2)] {
        let mut bench = Bench::with_usart(0);
        bench.peripherals.put_serial(0, 0, baud, &[0x55]);
        bench.cycle = 1600;
        assert_eq!(bench.read(USART1), status, "{baud}");
    }
}

#[test]
fn a_serial_port_needs_its_pins() {
    let mut bench = Bench::with_usart(0);
    bench.write(PORT_A, 0xA800_0000);
    bench.peripherals.put_serial(0, 0, 100_000, &[1]);
    bench.write(USART1 + 0x04, 0x41);
    bench.cycle = 10_000;
    assert_eq!(bench.read(USART1), 0xC0);
    assert_eq!(bench.peripherals.take_sent(), []);
}

#[test]
fn what_a_serial_port_lacks_is_refused() {
    for (register, value) in
        [(0x0C, 1), (0x0C, 2), (0x10, 1 << 14), (0x10, 1 << 11), (0x14, 1 << 1), (0x14, 1 << 8)]
    {
        let mut bench = Bench::with_usart(0);
        assert_eq!(
            bench.try_write(USART1 + register, value),
            Err(Refusal::Unmodelled),
            "{register:X}h {value:X}h"
        );
    }
    let mut bench = Bench::with_usart(0);
    bench.write(USART1 + 0x08, 15);
    assert_eq!(bench.try_write(USART1 + 0x0C, 1 << 13 | 1 << 3), Err(Refusal::Misuse));
}

/// Answers with the complement; notes the mode.
#[derive(Clone, Debug, Default)]
struct Complement;

impl SpiDevice for Complement {
    fn transfer(&mut self, mode: SpiMode, bits: u32, word: u16) -> u16 {
        assert_eq!((mode.idles_high, mode.second_edge, bits), (true, false, 8));
        !word & 0xFF
    }
}

/// SPI1 on PA5 and PA7; SCK is PCLK2 over 8, so a byte takes 64 cycles. `cr1` beside SPE, MSTR, SSM and SSI.
fn with_spi(cr1: u32, device: impl SpiDevice + 'static, select: Option<Pin>) -> Bench {
    let mut bench = Bench::new();
    bench.peripherals.attach_spi(0, 0, Box::new(device), select);
    bench.write(PORT_A, 0xA800_8800);
    bench.write(PORT_A + 0x20, 0x5050_0000);
    bench.write(SPI1, 0x344 | 2 << 3 | cr1);
    bench
}

#[test]
fn spi_exchanges_a_byte_in_eight_periods() {
    // CPOL, and the lowest bit first.
    let mut bench = with_spi(1 << 1 | 1 << 7, Complement, None);
    bench.write(SPI1 + 0x0C, 0x01);
    assert_eq!(bench.read(SPI1 + 0x08), 0x82, "TXE and BSY");
    bench.cycle = 63;
    assert_eq!(bench.read(SPI1 + 0x08), 0x82);
    bench.cycle = 64;
    assert_eq!(bench.read(SPI1 + 0x08), 0x03);
    assert_eq!((bench.read(SPI1 + 0x0C), bench.read(SPI1 + 0x08)), (0xFE, 0x02));
}

/// RM0090 28.3.10: the unread byte stays; a load of DR and one of SR clear OVR.
#[test]
fn an_unread_byte_overruns_spi() {
    let mut bench = with_spi(0, Loopback, None);
    for byte in [0x11, 0x22] {
        bench.write(SPI1 + 0x0C, byte);
        bench.cycle += 64;
    }
    assert_eq!(bench.read(SPI1 + 0x08), 0x43);
    assert_eq!(bench.read(SPI1 + 0x0C), 0x11);
    assert_eq!((bench.read(SPI1 + 0x08), bench.read(SPI1 + 0x08)), (0x42, 0x02));
}

#[test]
fn a_device_answers_only_while_it_is_selected() {
    let mut bench = with_spi(0, Loopback, Some(Pin::new('A', 0)));
    for (level, answer) in [(1, 0xFF), (0, 0x5A)] {
        bench.write(PORT_A, 0xA800_8801);
        bench.write(PORT_A + 0x14, level);
        bench.write(SPI1 + 0x0C, 0x5A);
        bench.cycle += 64;
        assert_eq!(bench.read(SPI1 + 0x0C), answer);
    }
}

/// SSM without SSI is a low NSS.
#[test]
fn a_master_with_low_nss_is_a_mode_fault() {
    let mut bench = Bench::new();
    bench.write(SPI1, 0x244);
    assert_eq!((bench.read(SPI1 + 0x08), bench.read(SPI1)), (0x22, 0x200));
    for bit in [10, 13, 15] {
        assert_eq!(bench.try_write(SPI1, 0x344 | 1 << bit), Err(Refusal::Unmodelled), "bit {bit}");
    }
}

/// Update and compare are one line of TIM4, two of TIM1 (RM0090 table 61).
#[test]
fn timers_raise_their_lines() {
    for (timer, compare, update) in [(TIM4, 30, 30), (TIM1, 27, 25)] {
        let mut bench = Bench::new();
        for (register, value) in [(0x2C, 999), (0x34, 100), (0x0C, 0b10), (0x00, 1)] {
            bench.write(timer + register, value);
        }
        assert_eq!(bench.peripherals.next_timer_event(bench.now()), Some(100));
        bench.cycle = 100;
        assert_eq!(bench.irqs(), [compare]);
        bench.write(timer + 0x10, 0);
        bench.write(timer + 0x0C, 1);
        bench.cycle = 1000;
        assert_eq!(bench.irqs(), [update]);
    }
}

#[test]
fn a_timer_has_only_its_own_channels() {
    let mut bench = Bench::new();
    for (timer, there, missing) in
        [(TIM6, 0x2C, 0x34), (TIM12, 0x38, 0x3C), (TIM4, 0x40, 0x44), (TIM1, 0x44, 0x50)]
    {
        assert_eq!(bench.try_write(timer + there, 5), Ok(()), "{timer:08X}h");
        assert_eq!(bench.try_write(timer + missing, 5), Err(Refusal::Unmodelled), "{timer:08X}h");
    }
}

/// The value of the vendor's examples for this word.
#[test]
fn the_crc_unit_starts_again_by_its_reset_bit() {
    const CRC: u32 = 0x4002_3000;
    let mut bench = Bench::new();
    bench.write(CRC, 0x1234_5678);
    assert_eq!(bench.read(CRC), 0xDF8A_8A2B);
    bench.write(CRC + 0x08, 1);
    assert_eq!(bench.read(CRC), u32::MAX);
}

/// RNG_CLK is off on HSI: a clock error instead of a number.
#[test]
fn random_numbers_need_their_clock() {
    let mut bench = Bench::new();
    bench.write(RNG, 0b1100);
    bench.cycle = 100_000;
    assert_eq!((bench.read(RNG + 4), bench.irqs()), (0x22, vec![80]));
    // PLL on HSI: 16 MHz / 8 * 168 / 7 is 48 MHz.
    let mut bench = Bench::new();
    bench.write(RCC + 0x04, 7 << 24 | 168 << 6 | 8);
    bench.write(RCC, 1 << 24 | 0x83);
    bench.write(RNG, 0b1100);
    assert_eq!(bench.peripherals.next_timer_event(bench.now()), Some(13));
    bench.cycle = 13;
    assert_eq!((bench.read(RNG + 4), bench.irqs()), (1, vec![80]));
    let first = bench.read(RNG + 8);
    assert_eq!(bench.read(RNG + 4), 0);
    bench.cycle = 26;
    assert_ne!(bench.read(RNG + 8), first);
    let mut f446 = Peripherals::new(Model::shipped("nucleo-f446re"), 0);
    assert_eq!(f446.read(Now::default(), RNG, Width::Word), Err(Refusal::Unmodelled));
}

/// DBP in PWR_CR opens the backup domain; a reset keeps it, power-on clears it.
#[test]
fn backup_registers_outlive_a_reset() {
    let mut bench = Bench::new();
    bench.write(RTC + 0x50, 1);
    assert_eq!(bench.read(RTC + 0x50), 0);
    bench.write(PWR, 0x4100);
    bench.write(RTC + 0x50, 1);
    bench.peripherals.reset(Time::ZERO, ResetCause::Software);
    assert_eq!(bench.read(RTC + 0x50), 1);
    bench.peripherals.reset(Time::ZERO, ResetCause::PowerOn);
    assert_eq!(bench.read(RTC + 0x50), 0);
}

/// The source of RTCCLK needs DBP and stays until BDRST, which resets the RTC with its backup registers. The calendar counts by it.
#[test]
fn the_backup_domain_has_a_clock_of_its_own() {
    const BDCR: u32 = RCC + 0x70;
    let mut bench = Bench::new();
    let at = |bench: &mut Bench, us, address| {
        let now = Now { cycle: 0, time: Time::from_us(us) };
        bench.peripherals.read(now, address, Width::Word).unwrap()
    };
    bench.write(RCC + 0x74, 1);
    bench.write(BDCR, 1 << 15 | 2 << 8);
    assert_eq!(bench.read(BDCR), 0, "DBP is off");
    bench.write(PWR, 0x4100);
    bench.write(BDCR, 1 << 15 | 2 << 8);
    bench.write(BDCR, 1 << 15 | 1 << 8);
    assert_eq!(bench.read(BDCR), 1 << 15 | 2 << 8, "LSI stays");
    // LSI over 128 and 256: a second lasts 1.024 s.
    for (us, tr) in [(1_023_900, 0), (1_024_100, 1), (61_440_100, 0x100)] {
        assert_eq!(at(&mut bench, us, RTC), tr, "{us} us");
        at(&mut bench, us, RTC + 4);
    }
    bench.write(RTC + 0x50, 5);
    bench.write(BDCR, 1 << 16);
    assert_eq!((at(&mut bench, 61_440_200, RTC), bench.read(RTC + 0x50), bench.read(BDCR)), (0, 0, 1 << 16));
}

/// WDG_SW clear: the watchdog runs from every reset on, with FFFh counts of 4 periods of 32 kHz.
#[test]
fn the_option_bytes_start_the_watchdog() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(0x1FFF_C000), 0xFFFF_AAED);
    assert_eq!(bench.try_write(0x1FFF_C000, 0), Err(Refusal::Unmodelled));
    bench.peripherals.flash_mut().set_options(0x0FFF_AACC);
    assert_eq!(bench.peripherals.watchdog_deadline(), None);
    bench.peripherals.reset(Time::from_ms(100), ResetCause::Pin);
    assert_eq!(bench.peripherals.watchdog_deadline(), Some(Time::from_ms(612)));
}
