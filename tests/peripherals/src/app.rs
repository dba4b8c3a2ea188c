//! The drivers and what they found.

use boards as _; // memory map, log, panics
use embassy_executor::Spawner;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::i2c::{self, I2c};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::*;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource, Sysclk,
};
use embassy_stm32::spi::{self, Spi};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::{RoundTo, Timer};
use embassy_stm32::usart::{self, BufferedUart, Uart, UartTx};
use embassy_stm32::{Config, Peripherals, bind_interrupts, dma, pac};
use embassy_time::{Duration, Instant, with_timeout};
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

    pac::PWR.cr1().modify(|w| w.set_dbp(true));
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
