//! Timers, the backup domain and option bytes, register by register; and what is absent.

use super::*;

const RCC: u32 = 0x4002_3800;
const TIM1: u32 = 0x4001_0000;
const TIM4: u32 = 0x4000_0800;
const TIM6: u32 = 0x4000_1000;
const TIM12: u32 = 0x4000_1800;
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

/// The source of RTCCLK needs DBP and stays until BDRST.
#[test]
fn the_backup_domain_takes_stores_when_it_is_open() {
    const BDCR: u32 = RCC + 0x70;
    let mut bench = Bench::new();
    bench.write(BDCR, 1 << 15 | 2 << 8);
    assert_eq!(bench.read(BDCR), 0, "DBP is off");
    bench.write(PWR, 0x4100);
    bench.write(BDCR, 1 << 15 | 2 << 8);
    bench.write(BDCR, 1 << 15 | 1 << 8);
    assert_eq!(bench.read(BDCR), 1 << 15 | 2 << 8, "LSI stays");
    bench.write(BDCR, 1 << 16);
    assert_eq!(bench.read(BDCR), 1 << 16);
}

/// Each stops its board, by its name: nothing is modelled there.
#[test]
fn absent_peripherals_refuse_by_their_names() {
    let mut bench = Bench::new();
    for (address, register) in [
        (0x4000_2800, "RTC.TR"),
        (0x4000_4400, "USART2.SR"),
        (0x4001_2000, "ADC1.SR"),
        (0x4001_3000, "SPI1.CR1"),
        (0x4002_3000, "CRC.DR"),
        (0x5006_0800, "RNG.CR"),
    ] {
        assert_eq!(bench.try_write(address, 0), Err(Refusal::Unmodelled), "{register}");
        assert_eq!(name(bench.peripherals.part(), address).as_deref(), Some(register));
    }
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
