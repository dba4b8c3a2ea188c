//! The drivers and what they found.

use core::sync::atomic::{AtomicU32, Ordering};

use boards_runtime as _; // log, panics
use embassy_executor::Spawner;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::i2c::{self, I2c};
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::*;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource, Sysclk,
};
use embassy_stm32::rtc::{DateTime, DayOfWeek, Rtc, RtcConfig};
use embassy_stm32::spi::{self, Spi};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::{RoundTo, Timer};
use embassy_stm32::usart::{self, BufferedUart, Uart, UartTx};
use embassy_stm32::{Config, Peri, Peripherals, bind_interrupts, dma, pac};
use embassy_time::{Duration, Instant, Timer as Delay, with_timeout};
use embedded_io_async::{Read, Write};

bind_interrupts!(struct Irqs {
    USART1 => usart::BufferedInterruptHandler<USART1>;
    UART4 => usart::InterruptHandler<UART4>;
    DMA1_STREAM2 => dma::InterruptHandler<DMA1_CH2>;
    DMA1_STREAM4 => dma::InterruptHandler<DMA1_CH4>;
    DMA2_STREAM2 => dma::InterruptHandler<DMA2_CH2>;
    DMA2_STREAM3 => dma::InterruptHandler<DMA2_CH3>;
});

#[cfg(feature = "pyboard-v11")]
bind_interrupts!(struct RandomIrqs {
    RNG => embassy_stm32::rng::InterruptHandler<RNG>;
});

/// Of EXTI: alarms and wake-up timer of the RTC.
const LINES: [usize; 2] = [17, 22];
/// An LM75, and an address where nothing is.
const LM75: u8 = 0x48;
const NOTHING: u8 = 0x50;

#[cfg(feature = "pyboard-v11")]
const CLOCK: (Hse, PllPreDiv) = (Hse { freq: Hertz(12_000_000), mode: HseMode::Oscillator }, PllPreDiv::DIV6);
#[cfg(feature = "nucleo-f446re")]
const CLOCK: (Hse, PllPreDiv) = (Hse { freq: Hertz(8_000_000), mode: HseMode::Bypass }, PllPreDiv::DIV4);

/// As the boards have it, and 48 MHz for the random number generator.
fn start() -> Peripherals {
    let mut config = Config::default();
    config.rcc.hse = Some(CLOCK.0);
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: CLOCK.1,
        mul: PllMul::MUL168,
        divp: Some(PllPDiv::DIV2),
        divq: Some(PllQDiv::DIV7),
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    embassy_stm32::init(config)
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = start();
    options();

    let mut config = i2c::Config::default();
    config.frequency = Hertz(400_000);
    let bus = I2c::new_blocking(p.I2C1, p.PB6, p.PB7, config);
    sensor(bus);

    let mut console = UartTx::new_blocking(p.USART6, p.PC6, usart::Config::default()).unwrap();
    console.blocking_write(b"hello").unwrap();
    console.blocking_flush().unwrap();

    let mut buffers = [[0; 16]; 2];
    let [sending, receiving] = &mut buffers;
    let mut config = usart::Config::default();
    config.baudrate = 9_600;
    config.parity = usart::Parity::ParityEven;
    let port = BufferedUart::new(p.USART1, p.PA10, p.PA9, sending, receiving, Irqs, config).unwrap();
    buffered(port).await;

    let mut config = usart::Config::default();
    config.baudrate = 1_000_000;
    let port = Uart::new(p.UART4, p.PC11, p.PC10, p.DMA1_CH4, p.DMA1_CH2, Irqs, config).unwrap();
    echo(port).await;

    let select = Output::new(p.PC4, Level::High, Speed::Low);
    let mut config = spi::Config::default();
    config.frequency = Hertz(1_000_000);
    let bus = Spi::new(p.SPI1, p.PA5, p.PA7, p.PA6, p.DMA2_CH3, p.DMA2_CH2, Irqs, config);
    looped(bus, select).await;

    macro_rules! timers {
        ($($timer:ident),*) => {
            $(
                let timer = Timer::new(p.$timer);
                timer.set_frequency(Hertz(1_000), RoundTo::Slower);
                // The prescaler takes effect with an update.
                timer.generate_update_event();
                timer.start();
                let (begin, mut updates) = (Instant::now(), 0);
                while begin.elapsed() < Duration::from_micros(10_500) {
                    updates += u32::from(timer.clear_update_interrupt());
                }
                defmt::info!("{}: {=u32} updates", stringify!($timer), updates);
            )*
        };
    }
    timers!(TIM1, TIM3, TIM4, TIM5, TIM6, TIM7, TIM8, TIM9, TIM10, TIM11, TIM12, TIM13, TIM14);

    let mut unit = embassy_stm32::crc::Crc::new(p.CRC);
    defmt::info!("crc: {=u32:08X} {=u32:08X}", unit.feed_word(0x1234_5678), unit.feed_words(&[0, u32::MAX]));

    calendar(p.RTC).await;
    copy().await;

    pac::RTC.bkpr(19).write(|w| w.set_bkp(0xB00C_0DE5));
    defmt::info!("backup: {=u32:08X}", pac::RTC.bkpr(19).read().bkp());

    // The F446 has none.
    #[cfg(feature = "pyboard-v11")]
    {
        let mut generator = embassy_stm32::rng::Rng::new(p.RNG, RandomIrqs);
        let mut bytes = [0; 8];
        generator.async_fill_bytes(&mut bytes).await.unwrap();
        defmt::info!("rng: {=bool}", bytes != [0; 8] && generator.next_u32() != generator.next_u32());
    }
    defmt::info!("done");
    beyond();
}

/// Programs level 1 of the brown-out reset and resets the part, once.
fn options() {
    let flash = pac::FLASH;
    let level = flash.optcr().read().bor_lev();
    defmt::info!("options: {=u8}", level);
    if level != 3 {
        return;
    }
    flash.optkeyr().write_value(0x0819_2A3B);
    flash.optkeyr().write_value(0x4C5D_6E7F);
    flash.optcr().modify(|w| w.set_bor_lev(2));
    flash.optcr().modify(|w| w.set_optstrt(true));
    while flash.sr().read().bsy() {}
    cortex_m::peripheral::SCB::sys_reset()
}

/// Over the end of a leap February, with an alarm at its first second; then the wake-up timer.
async fn calendar(rtc: Peri<'static, RTC>) {
    let (mut rtc, clock) = Rtc::new(rtc, RtcConfig::default());
    let eve = DateTime::from(2028, 2, 28, DayOfWeek::Monday, 23, 59, 58, 0);
    rtc.set_datetime(eve.unwrap()).unwrap();
    let begin = Instant::now();
    pac::EXTI.rtsr(0).write(|w| LINES.iter().for_each(|line| w.set_line(*line, true)));
    pac::EXTI.imr(0).write(|w| LINES.iter().for_each(|line| w.set_line(*line, true)));
    // Second 1 of any minute. The alarm is off and may be written.
    open(|rtc| {
        rtc.alrmr(0).write_value(pac::rtc::regs::Alrmr(0x8080_8001));
        rtc.cr().modify(|w| w.set_alre(0, true));
        rtc.cr().modify(|w| w.set_alrie(0, true));
    });
    while !interrupt::RTC_ALARM.is_pending() && begin.elapsed() < Duration::from_secs(5) {
        Delay::after_millis(1).await;
    }
    let took = begin.elapsed().as_millis();
    let now = clock.now().unwrap();
    let (year, month, day) = (now.year(), now.month(), now.day());
    let (hour, minute, second) = (now.hour(), now.minute(), now.second());
    defmt::info!("alarm: {}-{}-{} {}:{}:{} {}", year, month, day, hour, minute, second, took);

    // 200 periods of LSI over 16: 100 ms.
    open(|rtc| {
        rtc.wutr().write(|w| w.set_wut(199));
        rtc.cr().modify(|w| w.set_wutie(true));
        rtc.cr().modify(|w| w.set_wute(true));
    });
    let begin = Instant::now();
    while !interrupt::RTC_WKUP.is_pending() && begin.elapsed() < Duration::from_secs(1) {
        Delay::after_millis(1).await;
    }
    defmt::info!("wake-up: {=u64}", begin.elapsed().as_millis());
}

/// Opens the registers of the RTC that its driver does not reach.
fn open(change: impl FnOnce(pac::rtc::Rtc)) {
    pac::RTC.wpr().write(|w| w.set_key(0xCA));
    pac::RTC.wpr().write(|w| w.set_key(0x53));
    change(pac::RTC);
    pac::RTC.wpr().write(|w| w.set_key(0xFF));
}

/// DMA2 copies memory, with registers: the driver asks for unsafe code.
async fn copy() {
    static FROM: [AtomicU32; 16] = [const { AtomicU32::new(0) }; 16];
    static TO: [AtomicU32; 16] = [const { AtomicU32::new(0) }; 16];
    FROM.iter().enumerate().for_each(|(n, word)| word.store(n as u32 * 0x0101_0101, Ordering::Relaxed));
    pac::RCC.ahb1enr().modify(|w| w.set_dma2en(true));
    let stream = pac::DMA2.st(0);
    stream.par().write_value(FROM.as_ptr() as u32);
    stream.m0ar().write_value(TO.as_ptr() as u32);
    stream.ndtr().write(|w| w.set_ndt(16));
    // From memory to memory, words, both addresses counting.
    stream.cr().write_value(pac::dma::regs::Cr(2 << 13 | 2 << 11 | 1 << 10 | 1 << 9 | 2 << 6 | 1));
    while !pac::DMA2.isr(0).read().tcif(0) {}
    let same =
        FROM.iter().zip(&TO).all(|(from, to)| from.load(Ordering::Relaxed) == to.load(Ordering::Relaxed));
    defmt::info!("copy: {=bool}", same);
}

/// Starts the DAC, which the twin does not model.
#[inline(never)]
fn beyond() {
    pac::RCC.apb1enr().modify(|w| w.set_dacen(true));
    pac::DAC1.cr().write(|w| w.set_en(0, true));
}

/// A limit is written and read back, the temperature read; an address is empty.
fn sensor(mut bus: I2c<'_, embassy_stm32::mode::Blocking, i2c::Master>) {
    let mut limit = [0; 2];
    let mut temperature = [0; 2];
    bus.blocking_write(LM75, &[3, 0x2A, 0x80]).unwrap();
    bus.blocking_write_read(LM75, &[3], &mut limit).unwrap();
    bus.blocking_write_read(LM75, &[0], &mut temperature).unwrap();
    let begin = Instant::now();
    let refused = bus.blocking_write(NOTHING, &[0]);
    let us = begin.elapsed().as_micros();
    defmt::info!("i2c: {=[u8]:02X} {=[u8]:02X} {} {=bool}", limit, temperature, refused, us < 100);
}

/// Twenty bytes come, more than the buffers hold; most go back, one higher.
async fn buffered(mut port: BufferedUart<'_>) {
    let mut bytes = [0; 20];
    let read = with_timeout(Duration::from_millis(100), port.read_exact(&mut bytes)).await;
    bytes.iter_mut().for_each(|byte| *byte += 1);
    // The driver takes no more at once than its buffer holds.
    port.write_all(&bytes[..15]).await.unwrap();
    port.flush().await.unwrap();
    defmt::info!("buffered: {=bool}", matches!(read, Ok(Ok(()))));
}

/// What came until the line was idle goes back, by DMA both ways.
async fn echo(mut port: Uart<'_, Async>) {
    let mut bytes = [0; 32];
    let read = with_timeout(Duration::from_millis(100), port.read_until_idle(&mut bytes)).await;
    let len = read.map_or(0, |len| len.unwrap());
    port.write(&bytes[..len]).await.unwrap();
    port.flush().await.unwrap();
    defmt::info!("echo: {=usize}", len);
}

/// MOSI is MISO, while the chip select is low; by polling, then by DMA, then with 16 bits.
async fn looped(mut bus: Spi<'_, Async, spi::mode::Master>, mut select: Output<'_>) {
    let mut deselected = [0; 2];
    bus.blocking_transfer(&mut deselected, &[0x12_u8, 0x34]).unwrap();
    select.set_low();
    let mut polled = [0; 4];
    bus.blocking_transfer(&mut polled, &[1_u8, 2, 3, 4]).unwrap();
    let mut moved = [0; 4];
    bus.transfer(&mut moved, &[5_u8, 6, 7, 8]).await.unwrap();
    let mut wide = [0; 2];
    bus.blocking_transfer(&mut wide, &[0x1234_u16, 0xABCD]).unwrap();
    select.set_high();
    defmt::info!("spi: {=[u8]} {=[u8]} {=[u8]} {}", deselected, polled, moved, wide);
}
